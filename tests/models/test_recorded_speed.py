"""The speed at an impact whose moment on the recorder's clock is uncertain, against quadrature."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import arviz as az
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro import handlers
from retrodict.models import RUNGS, parts, rungs_for
from scipy import integrate, stats

import retrodict as rd
from retrodict.scene import SceneError, parse_scene
from retrodict.scene.records import Measured, Scene
from retrodict.scene.speed_record import SpeedRecord
from retrodict.scene.write import scene_toml
from tests.models.closed_form import GRAVITY, everything_exact, momentum_and_slide
from tests.models.test_evidence import RUNG, SITES
from tests.shared.scenes import LEVER_A, collision

# braking from 0.7 s before the end on: the window reaches over the bend
RECORD = SpeedRecord((-2.0, -1.0, -0.7, 0.0), (20.5, 20.0, 19.8, 15.0), -1.2, -0.1, 0.4)


def speed_at(time: float) -> float:
    return float(np.interp(time, RECORD.times, RECORD.speeds))


def mixed(of) -> float:
    """The mean over the moments of the impact of a function of the speed recorded then."""
    total = integrate.quad(
        lambda t: of(speed_at(t)), RECORD.low, RECORD.high, points=[-1.0, -0.7], epsabs=1e-12
    )[0]
    return total / (RECORD.high - RECORD.low)


def recorded(v: str):
    scene = collision(share=0.0, berm=False)
    speed = Measured(*RECORD.moments, source="a recorder")
    own = replace(scene.approach[v], speed=speed, record=RECORD)
    return replace(scene, approach=scene.approach | {v: own})


def test_mean_and_deviation_are_those_of_all_moments() -> None:
    mean = mixed(lambda v: v)
    square = mixed(lambda v: v**2)
    assert RECORD.moments == pytest.approx((mean, np.sqrt(square - mean**2 + RECORD.sd**2)))


def test_the_speed_of_a_has_the_law_of_all_moments() -> None:
    structure, data = RUNG.of_scene(recorded("a"))
    draws = np.random.default_rng(0).standard_normal((20_000, len(structure.uncertain)))
    speeds = jax.vmap(lambda xi: parts.from_standard(structure, data, xi)["speed_a"])(draws)
    for at in (15.0, 16.0, 18.0, 19.5, 20.0, 20.5):
        expected = mixed(lambda v, at=at: stats.norm.cdf((at - v) / RECORD.sd))
        error = np.sqrt(expected * (1 - expected) / len(draws))
        assert np.mean(np.asarray(speeds) < at) == pytest.approx(expected, abs=4 * error + 1e-6)


@pytest.mark.slow
def test_the_density_of_b_s_speed_is_the_mean_over_all_moments() -> None:
    """By the midpoints of as many equally probable moments."""
    scene = recorded("b")
    structure, data = RUNG.of_scene(scene)
    place = structure.names.index("time_zero_b")
    moments = stats.norm.ppf((np.arange(2000) + 0.5) / 2000)

    def density(deviate: jax.Array, speed: float) -> jax.Array:
        xi = jnp.zeros(len(structure.uncertain)).at[place].set(deviate)
        sites = {k: jnp.asarray(v) for k, v in (SITES | {"speed_b": speed}).items()}
        model = handlers.substitute(RUNG.model, sites | {"measured": xi})
        trace = handlers.trace(handlers.seed(model, 0)).get_trace(structure, data)
        return jnp.exp(trace["speed_b"]["fn"].log_prob(speed))

    for speed in (14.5, 17.0, 19.9, 20.6):
        found = float(jax.vmap(density, (0, None))(jnp.asarray(moments), speed).mean())
        expected = mixed(lambda v, at=speed: stats.norm.pdf((at - v) / RECORD.sd) / RECORD.sd)
        assert found == pytest.approx(expected, abs=1e-5), speed


def test_a_scene_file_says_the_record_and_says_it_again() -> None:
    table = (
        "speed_record = { times = ['-2 s', '-1 s', '-0.7 s', '0 s'], "
        "speeds = ['20.5 m/s', '20 m/s', '19.8 m/s', '15 m/s'], impact = ['-1.2 s', '-0.1 s'], "
        "uncertainty = { value = 0.4, unit = 'm/s', source = 'a recorder' } }"
    )
    from tests.shared.scene_file import SCENE

    scene = parse_scene(SCENE.replace('speed = "45 ± 2 mph"', table), "recorded")
    assert scene.approach["a"].record == RECORD
    assert scene.approach["a"].speed == Measured(*RECORD.moments, source="a recorder")
    again = parse_scene(scene_toml(scene), "recorded")
    assert again.approach["a"] == scene.approach["a"]
    beyond = table.replace("'-0.1 s'", "'0.3 s'")
    with pytest.raises(SceneError, match="reaches beyond the record"):
        parse_scene(SCENE.replace('speed = "45 ± 2 mph"', beyond), "recorded")


MAP = """
schema = 1
[recorder]
vehicle = "A"
columns = {{ time = "Time", {0} = "Value" }}
units = {{ time = "s", {0} = "m/s" }}
"""
ROWS = "".join(f"{at},{speed}\n" for at, speed in zip(RECORD.times, RECORD.speeds, strict=True))
# what is imported: a table, and the map's lines on it. The scene's own delta-v is 13.1 ± 0.1 m/s
RECORDER = {
    "an unknown time zero": (
        f"Time,Value\n{ROWS}",
        MAP.format("speed")
        + '[recorder.speed]\nimpact = ["-1.2 s", "-0.1 s"]\nuncertainty = "0.4 m/s"\n',
    ),
    "a lost end of the pulse": (
        "Time,Value\n0,0\n0.03,7\n0.06,13.2\n",
        MAP.format("delta_v")
        + '[recorder.delta_v]\nat = "last"\nended = "early"\nuncertainty = "0.1 m/s"\n',
    ),
}


def nearly_exact(scene: Scene) -> Scene:
    """As `everything_exact`, with the errors without which a scene file takes an assumed one."""

    def nearly(of: Any, *names: str) -> Any:
        known = {name: getattr(of, name) for name in names}
        return replace(
            of, **{k: replace(m, sd=1e-5 * max(1.0, abs(m.value))) for k, m in known.items()}
        )

    scene = everything_exact(scene)
    own = ("mass", "yaw_inertia", "impact_distance", "impact_angle", "heading", "grip")
    a = nearly(scene.approach["a"], "speed", "direction", "yaw_rate")
    return replace(
        scene,
        vehicles={v: nearly(vehicle, *own) for v, vehicle in scene.vehicles.items()},
        approach=scene.approach | {"a": a},
        contact=nearly(scene.contact, "x", "y", "Gamma"),
        surfaces=(nearly(scene.surfaces[0], "friction"),),
    )


def by_quadrature(which: str, scene: Scene) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Quantities on a grid over rest positions and A's speed, and the posterior's weights there."""
    x, weight = np.polynomial.hermite_e.hermegauss(10)
    z = np.stack(np.meshgrid(*[x] * 4, indexing="ij"), axis=-1).reshape(-1, 2, 2)
    mass = np.prod(np.stack(np.meshgrid(*[weight] * 4, indexing="ij")), axis=0).ravel()
    if which == "an unknown time zero":
        speeds = np.linspace(13.5, 22.5, 91)
        of_speed = np.array([
            mixed(lambda v, at=at: stats.norm.pdf((at - v) / RECORD.sd)) for at in speeds
        ])  # fmt: skip
    else:
        speeds, of_speed = np.array([20.1168]), np.ones(1)
    found = [momentum_and_slide(scene, z, slower=20.1168 - speed) for speed in speeds]
    speed_b, log_factor = (np.array(rows) for rows in zip(*found, strict=True))
    speed_a = np.broadcast_to(speeds[:, None], speed_b.shape)
    share = of_speed[:, None] * mass * np.exp(log_factor)
    if which == "a lost end of the pulse":
        rest = np.array([scene.rest["a"].x.value, scene.rest["a"].y.value]) + 0.15 * z[:, 0]
        way = rest + LEVER_A
        after = way * np.sqrt(2 * 0.5 * GRAVITY / np.hypot(*way.T))[:, None]
        change = np.hypot(after[:, 0] + 20.1168, after[:, 1])
        return {"speed_b": speed_b}, share * stats.norm.cdf((change - 13.2) / 0.1)
    return {"speed_a": speed_a, "speed_b": speed_b}, share


@pytest.mark.slow
@pytest.mark.parametrize("which", RECORDER)
def test_a_recorder_file_gives_the_posterior_that_quadrature_gives(
    which: str, tmp_path: Path
) -> None:
    """From the recorder's table through the scene file to the posterior."""
    scene = nearly_exact(collision(share=0.0, berm=False))
    table, map_text = RECORDER[which]
    for name, text in (("a.csv", table), ("a.toml", map_text), ("scene.toml", scene_toml(scene))):
        (tmp_path / name).write_text(text, "utf-8")
    taken = rd.import_evidence(*(tmp_path / name for name in ("a.csv", "a.toml", "scene.toml")))
    (tmp_path / "scene.toml").write_text(taken.text, "utf-8")
    result = rd.reconstruct(tmp_path / "scene.toml", model="momentum+slide", draws=2000)
    assert result.checks.passed, result.checks.reasons
    expected, share = by_quadrature(which, scene)
    share /= share.sum()
    for name, values in expected.items():
        draws = result.idata["posterior"][name]
        mean = float(np.sum(share * values))
        sd = float(np.sqrt(np.sum(share * (values - mean) ** 2)))
        errors = [float(az.mcse(draws.values, method=of)) for of in ("mean", "sd")]
        assert float(draws.mean()) == pytest.approx(mean, abs=4 * errors[0]), name
        assert float(draws.std()) == pytest.approx(sd, abs=4 * errors[1]), name


def test_every_rung_takes_a_record() -> None:
    for name in rungs_for(recorded("b")):
        structure, data = RUNGS[name].of_scene(recorded("b"))
        assert structure.recorded == (("b", 4),)
        assert data.records["b"].shape == (4, 2)
