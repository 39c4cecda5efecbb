"""The speed at an impact whose moment on the recorder's clock is uncertain, against quadrature."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro import handlers
from retrodict.models import RUNGS, parts
from scipy import integrate, stats

import retrodict as rd
from retrodict.scene import SceneError, parse_scene
from retrodict.scene.records import Measured, SpeedRecord
from retrodict.scene.write import scene_toml
from tests.models.test_evidence import RUNG, SITES
from tests.shared.scenes import collision

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
    assert again.approach == scene.approach
    beyond = table.replace("'-0.1 s'", "'0.3 s'")
    with pytest.raises(SceneError, match="reaches beyond the record"):
        parse_scene(SCENE.replace('speed = "45 ± 2 mph"', beyond), "recorded")


def weighted(x: np.ndarray, weights: np.ndarray) -> tuple[float, float, float]:
    """Mean, standard deviation and the mean's error of weighted draws."""
    share = weights / weights.sum()
    mean = float(share @ x)
    sd = float(np.sqrt(share @ (x - mean) ** 2))
    return mean, sd, sd * float(np.sqrt((share**2).sum()))


@pytest.mark.slow
@pytest.mark.parametrize("evidence", ["unknown time zero", "lost end of the pulse"])
def test_a_reconstruction_is_that_of_reweighted_draws(evidence: str) -> None:
    """Draws of a scene without the evidence, weighted by its likelihood by quadrature."""
    wide = Measured(18.0, 3.0)
    bare = collision(share=0.0, berm=False)
    bare = replace(bare, approach=bare.approach | {"a": replace(bare.approach["a"], speed=wide)})
    settings = {"model": "momentum+spin", "method": "nuts", "draws": 2000}
    draws = rd.reconstruct(bare, **settings).idata["posterior"]
    speed_a, speed_b = (np.asarray(draws[f"speed_{v}"]).ravel() for v in "ab")
    if evidence == "unknown time zero":
        scene = recorded("a")
        likelihood = np.array([
            mixed(lambda v, at=at: stats.norm.pdf((at - v) / RECORD.sd)) for at in speed_a
        ])  # fmt: skip
        weights = likelihood / stats.norm.pdf((speed_a - wide.value) / wide.sd)
    else:
        change = np.asarray(draws["delta_v_a"]).ravel()
        bound = Measured(float(np.quantile(change, 0.7)), 0.5)
        scene = replace(bare, departure={"a": {"delta_v_at_least": bound}})
        weights = stats.norm.cdf((change - bound.value) / bound.sd)
    mean, sd, error = weighted(speed_b, weights)
    result = rd.reconstruct(scene, **settings)
    assert result.findings.checks.passed
    found = np.asarray(result.idata["posterior"]["speed_b"]).ravel()
    ours = found.std() / np.sqrt(1000)  # of chains whose draws depend on one another
    # effective draws of the weights and of the first chains, which depend on one another too
    assert found.mean() == pytest.approx(mean, abs=4 * np.hypot(2 * error, ours))
    assert found.std() == pytest.approx(sd, rel=0.12)


def test_every_rung_takes_a_record() -> None:
    for name in RUNGS:
        structure, data = RUNGS[name].of_scene(recorded("b"))
        assert structure.recorded == (("b", 4),)
        assert data.records["b"].shape == (4, 2)
