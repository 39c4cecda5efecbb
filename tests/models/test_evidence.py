"""What a model predicts of each item of evidence, against values found by hand or by SciPy."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro import handlers
from numpyro.infer.util import log_density
from retrodict.models import RUNGS, evidence, parts
from retrodict.models.arrays import Data, Structure
from scipy import stats
from scipy.interpolate import CubicHermiteSpline

from retrodict.inference.transforms.layout import with_response_surface
from retrodict.mechanics import Car, Path, end_of_rotation
from retrodict.scene.fields import DEPARTURE
from retrodict.scene.records import Mark, Measured, RunOutError, Scene
from tests.shared.scenes import DEGREE, LEVER_B, collision, rolls

RUNG = RUNGS["planar-moment+spin"]
SITES = {"speed_b": 19.0, "direction_b": -0.2, "omega_b": 0.3, "e": 0.1, "mu": 0.25, "e_m": 0.7}


def trace_of(scene: Scene, rung=RUNG) -> dict:
    """The trace of the model at one point."""
    structure, data = rung.of_scene(scene)
    sites = SITES | {"measured": jnp.zeros(len(structure.uncertain))}
    model = handlers.substitute(rung.model, {k: jnp.asarray(v) for k, v in sites.items()})
    return handlers.trace(handlers.seed(model, 0)).get_trace(structure, data)


def test_departures_are_what_velocities_after_the_impact_say() -> None:
    every = dict(
        zip(DEPARTURE, (Measured(m, 0.1) for m in (5.0, 8.0, 9.0, 12.0, -11.0, 3.0)), strict=False)
    )
    scene = replace(collision(share=0.0, berm=False), departure={"a": every, "b": every})
    trace = trace_of(scene)
    value = {
        k: float(site["value"]) for k, site in trace.items() if site["type"] == "deterministic"
    }
    before = {"a": (-20.1168, 0.0), "b": (value["vbx"], value["vby"])}
    for v in "ab":
        V = np.array([value[f"V{v}x"], value[f"V{v}y"]])
        heading = scene.vehicles[v].heading.value
        ahead = np.array([np.cos(heading), np.sin(heading)])
        change = V - before[v]
        expected = {
            "speed": np.hypot(*V),
            "yaw_rate": value[f"Omega_{v}"],
            "delta_v": value[f"delta_v_{v}"],
            "delta_v_forward": change @ ahead,
            "delta_v_left": change @ [-ahead[1], ahead[0]],
        }
        for name, wanted in expected.items():
            assert float(trace[f"departure_{name}_{v}"]["fn"].mean) == pytest.approx(wanted), name
        direction = float(trace[f"departure_direction_{v}"]["fn"].mean)
        assert np.cos(direction - np.arctan2(V[1], V[0])) == pytest.approx(1)
        assert abs(direction - 5.0) <= np.pi  # the representative nearest to what was measured


@pytest.mark.slow
@pytest.mark.parametrize("of", ["centre", "rear_left"])
def test_a_mark_is_as_far_as_the_nearest_of_many_points_of_the_path(of: str) -> None:
    point = Mark(3.0, -4.0, 0.2, of)
    scene = replace(collision(share=0.0, berm=False), marks={"b": (point,)})
    trace, (structure, data) = trace_of(scene), RUNG.of_scene(scene)
    x = parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))
    after = jnp.array([trace[name]["value"] for of_one in parts.AFTER for name in of_one])
    path = np.asarray(RUNG.run_out.paths(structure, data, x, after).pose)[1]
    line = path[:, :2]
    if of == "rear_left":  # 1.45 m behind, 0.75 m to the left
        ahead = np.stack([np.cos(path[:, 2]), np.sin(path[:, 2])], axis=1)
        line = line - 1.45 * ahead + 0.75 * np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    share = np.linspace(0, 1, 1000)[:, None, None]
    apart = line[:-1] + share * np.diff(line, axis=0) - [3.0, -4.0]
    predicted = float(trace["mark_1_b"]["fn"].mean)
    assert abs(predicted) == pytest.approx(np.linalg.norm(apart, axis=-1).min(), abs=1e-4)


@pytest.mark.parametrize("name", ["momentum+slide", "planar+spin", "planar-moment+wheels"])
def test_every_rung_weighs_what_lies_on_the_way_by_the_run_out_s_error_too(name: str) -> None:
    """Also those that take every wheel as locked."""
    error = RunOutError(position=Measured(0.05), heading=Measured(10 * DEGREE))
    scene = rolls(collision(share=0.0, berm=False), "b", (0.1,) * 4)
    b = replace(scene.vehicles["b"], run_out_error=error)
    mark = {"b": (Mark(3.0, -4.0, 0.2, "centre"),)}
    scene = replace(scene, vehicles=scene.vehicles | {"b": b}, marks=mark)
    data = RUNGS[name].of_scene(scene)[1]
    expected = {
        "rest_x_b": np.hypot(0.15, 0.05 * scene.path_to("b", 8.968, -12.896)),
        "mark_1_b": np.hypot(0.2, 0.05 * scene.path_to("b", 3.0, -4.0)),
        "rest_x_a": 0.15,
        "rest_heading_b": np.hypot(3, 10 * scene.path_to("b", 8.968, -12.896) / 20) * DEGREE,
    }
    for item, sd in expected.items():
        if item in data.evidence:
            assert data.evidence[item][1] == pytest.approx(sd), item
    assert {"rest_x_b", "rest_x_a", "mark_1_b"} <= set(data.evidence)


STEADY = {  # braking over g, of a car that moves straight ahead on a road of friction 0.5
    "momentum+slide": 0.5,
    "momentum+spin": 0.5,
    "momentum+wheels": 0.5 * 0.3,
}


@pytest.mark.slow
@pytest.mark.parametrize("model", STEADY)
@pytest.mark.parametrize("of", ["centre", "rear_left"])
def test_speed_at_a_mark_is_what_the_way_there_left_of_it(model: str, of: str) -> None:
    """v² = v0² − 2 a s, and the course is the heading, of a car that moves straight ahead."""
    heading, start, v0 = -22 * DEGREE, -LEVER_B, 12.0
    ahead = np.array([np.cos(heading), np.sin(heading)])
    left = np.array([-ahead[1], ahead[0]])
    wheel = -1.45 * ahead + 0.75 * left if of == "rear_left" else 0 * ahead
    far = v0**2 / (2 * 9.80665 * STEADY[model])
    ways = far * np.array([0.01, 0.3, 0.8, 0.99, 1.2])
    points = start + wheel + 0.4 * left + ways[:, None] * ahead
    known = {"speed": Measured(8.0, 1.0), "course": Measured(heading + 6 * np.pi + 1, 0.1)}
    marks = tuple(Mark(*point, 0.2, of, **known) for point in points)
    scene = rolls(collision(share=0.0, berm=False), "b", (0.3,) * 4)
    road = replace(scene.surfaces[0], friction=Measured(0.5))
    scene = replace(scene, rest={}, marks={"b": marks}, surfaces=(road,))
    turns = [] if "slide" in model else [0.0]
    found = observed(scene, model, jnp.array([-7.0, 2.0, *turns, *(v0 * ahead), *turns]))
    speeds = v0 * np.sqrt(np.maximum(1 - ways / far, 0))
    for i, speed in enumerate(speeds, 1):
        assert found[f"mark_{i}_speed_b"] == pytest.approx(speed, abs=1e-3), i
        course = found[f"mark_{i}_course_b"]
        assert course == pytest.approx(heading + 6 * np.pi, abs=1e-6), i  # nearest to the measured
    beside = [0.4] * 4 + [np.hypot(0.4, 0.2 * far)]
    assert [found[f"mark_{i}_b"] for i in range(1, 6)] == pytest.approx(beside, abs=1e-6)


ASIDE = jnp.array([-7.0, 2.4, 0.6, 12.0, 3.0, -3.0])  # B is struck aside, and rolls on


def struck_aside(**changes) -> Scene:
    """A scene in which B, with one wheel locked, has been `ASIDE`."""
    scene = rolls(collision(share=0.0, berm=False), "b", (0.95, 0.05, 0.05, 0.05))
    return replace(scene, rest={}, **changes)


@pytest.mark.slow
def test_speed_and_course_at_a_mark_are_those_of_the_path_beside_it() -> None:
    known = {"speed": Measured(8.0, 1.0), "course": Measured(0.0, 0.1)}
    mark = Mark(9.0, 0.5, 0.2, "front_right", **known)
    scene = struck_aside(marks={"b": (mark,)})
    found = observed(scene, "momentum+wheels", ASIDE)
    path = path_of_b(scene)
    rows = np.linspace(0, path.time[-1], 100_001)
    curve = CubicHermiteSpline(path.time, path.pose[:, :2], path.velocity[:, :2])
    angle = CubicHermiteSpline(path.time, path.pose[:, 2], path.velocity[:, 2])(rows)
    ahead = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    track = curve(rows) + 1.35 * ahead + 0.75 * np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
    nearest = rows[np.argmin(np.linalg.norm(track - [mark.x, mark.y], axis=1))]
    V = curve(nearest, 1)
    assert found["mark_1_speed_b"] == pytest.approx(np.hypot(*V), abs=0.02)
    assert found["mark_1_course_b"] == pytest.approx(np.arctan2(V[1], V[0]), abs=0.01)


@pytest.mark.slow
def test_the_end_of_rotation_is_that_of_the_vehicle_s_path() -> None:
    end = {k: Measured(m, 0.5) for k, m in (("x", 3.0), ("y", 1.0), ("heading", 14.0))}
    scene = struck_aside(end_of_rotation={"b": end})
    found = observed(scene, "momentum+wheels", ASIDE)
    x, y, heading = end_of_rotation(path_of_b(scene), Car(1.0, 1.35, 1.45, 1.5))
    assert list(found) == ["end_x_b", "end_y_b", "end_heading_b"]
    assert [found["end_x_b"], found["end_y_b"]] == pytest.approx([float(x), float(y)])
    turns = (found["end_heading_b"] - float(heading)) / (2 * np.pi)
    assert turns == pytest.approx(round(turns))
    assert abs(found["end_heading_b"] - 14.0) <= np.pi
    part = struck_aside(end_of_rotation={"b": {"heading": end["heading"]}})
    assert list(RUNGS["momentum+wheels"].of_scene(part)[0].evidence) == ["end_heading_b"]
    assert not RUNGS["momentum+slide"].of_scene(scene)[0].followed


@pytest.mark.slow
def test_what_was_measured_on_the_way_has_slopes_wherever_it_lies() -> None:
    """Before the impact, beside the path and beyond the rest; of cars that move or stand."""
    known = {"speed": Measured(8.0, 1.0), "course": Measured(0.0, 0.1)}
    points = ((-20.0, 0.0), (9.0, 0.5), (300.0, 0.0))
    marks = tuple(Mark(x, y, 0.2, "centre", **known) for x, y in points)
    end = {k: Measured(m, 0.5) for k, m in (("x", 3.0), ("y", 1.0), ("heading", 14.0))}
    scene = struck_aside(marks={"b": marks}, end_of_rotation={"b": end})
    structure, data = RUNGS["momentum+wheels"].of_scene(scene)
    structure = structure.differentiable

    @jax.jit
    @jax.grad
    def slope(after: jax.Array) -> jax.Array:
        return log_density(observing, (structure, data, "momentum+wheels", after), {}, {})[0]

    for after in (ASIDE, jnp.zeros(6), 1e-6 * ASIDE):
        found = np.asarray(slope(after))
        assert np.isfinite(found).all()
        if after is ASIDE:
            assert (np.abs(found[3:]) > 1e-3).all()


def observing(structure: Structure, data: Data, model: str, after: jax.Array) -> None:
    """What a model observes of two run-outs from given velocities."""
    x = parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))
    paths = RUNGS[model].run_out.paths(structure, data, x, after)
    rests = paths.pose[:, -1, : len(structure.rests)]
    evidence.observe(structure, data, x, after, rests, paths)


def observed(scene: Scene, model: str, after: jax.Array) -> dict[str, float]:
    """What it predicts of each item."""
    at = (*RUNGS[model].of_scene(scene), model, after)
    trace = handlers.trace(handlers.seed(observing, 0)).get_trace(*at)
    return {name: float(site["fn"].mean) for name, site in trace.items()}


def path_of_b(scene: Scene) -> Path:
    """Of B from `ASIDE`."""
    rung = RUNGS["momentum+wheels"]
    structure, data = rung.of_scene(scene)
    x = parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))
    return Path(*(np.asarray(rows)[1] for rows in rung.run_out.paths(structure, data, x, ASIDE)))


def test_a_robust_scene_errs_by_students_t() -> None:
    normal, robust = (
        collision(share=0.0, berm=False),
        replace(collision(share=0.0, berm=False), robust=True),
    )
    sites = SITES | {"measured": jnp.zeros(3)}
    found = [log_density(RUNG.model, RUNG.of_scene(s), {}, sites)[0] for s in (normal, robust)]
    residuals = [
        (float(site["fn"].mean) - float(site["value"])) / float(site["fn"].scale)
        for name, site in trace_of(normal).items()
        if name in normal.evidence()
    ]
    expected = stats.t(4).logpdf(residuals).sum() - stats.norm.logpdf(residuals).sum()
    assert float(found[1] - found[0]) == pytest.approx(expected)


@pytest.mark.parametrize("braking", [None, 0.7])
def test_a_skid_to_impact_adds_its_energy(braking: float | None) -> None:
    scene = collision(share=0.0, berm=False)
    b = replace(scene.approach["b"], skid=Measured(12.0, 0.0, "lognormal"))
    if braking:
        b = replace(b, skid_braking=Measured(braking))
    trace = trace_of(replace(scene, approach=scene.approach | {"b": b}))
    friction = float(parts.from_standard(*RUNG.of_scene(scene), jnp.zeros(3))["friction_road"])
    expected = np.sqrt(19.0**2 + 2 * 9.80665 * friction * (braking or 1.0) * 12.0)
    assert float(trace["travelling_speed_b"]["value"]) == pytest.approx(expected)
    assert "travelling_speed_a" not in trace


def test_a_rung_without_yaw_explains_no_yaw() -> None:
    names = [*collision().evidence(), "departure_yaw_rate_a", "departure_speed_a", "mark_2_b"]
    names += ["mark_2_speed_b", "mark_1_course_a", "end_x_a", "end_y_a", "end_heading_b"]
    left = [name for name in names if not evidence.explained(name, turns=False)]
    turned = ["rest_heading_a", "rest_heading_b", "departure_yaw_rate_a"]
    assert left == [*turned, "end_x_a", "end_y_a", "end_heading_b"]
    assert all(evidence.explained(name, turns=True) for name in names)


def test_an_unknown_speed_of_a_has_its_prior() -> None:
    scene = collision(share=0.0, berm=False)
    a = replace(scene.approach["a"], speed=None)
    structure, data = RUNG.of_scene(replace(scene, approach=scene.approach | {"a": a}))
    i = structure.names.index("speed_a")
    for deviate in (-3.0, -0.5, 0.0, 2.0, 6.0):
        xi = jnp.zeros(len(structure.uncertain)).at[i].set(deviate)
        speed = float(parts.from_standard(structure, data, xi)["speed_a"])
        law = stats.halfnorm(scale=30)
        assert law.sf(speed) == pytest.approx(stats.norm.sf(deviate), rel=1e-9)
        assert law.cdf(speed) == pytest.approx(stats.norm.cdf(deviate), rel=1e-9)


def test_any_measured_rest_determines_the_motion_but_along_a_measured_path() -> None:
    scene = collision()
    whole = RUNG.of_scene(scene)[0]
    assert not whole.unmeasured
    assert whole.transform == "rest-pose"
    rest = {"a": scene.rest["a"], "b": replace(scene.rest["b"], heading=None)}
    partly = replace(scene, rest=rest)
    structure, data = RUNG.of_scene(partly)
    assert structure.unmeasured == ("rest_heading_b",)
    assert structure.transform == "rest-pose"
    assert "rest_heading_b" not in structure.evidence
    assert float(data.evidence["rest_heading_a"][1]) == pytest.approx(3 * DEGREE)
    only_a = replace(scene, rest={"a": scene.rest["a"]})
    assert RUNG.of_scene(only_a)[0].transform == "rest-pose"
    assert RUNG.of_scene(replace(scene, rest={}))[0].transform == "standard"
    wheels, rolled = RUNGS["planar-moment+wheels"], rolls(scene, "b", (0.3,) * 4)
    structure = wheels.of_scene(rolled)[0]
    assert structure.paced
    assert not structure.unmeasured
    assert not with_response_surface(structure)
    passed = replace(rolled, marks={"b": (Mark(3.0, -4.0, 0.2, "centre"),)})
    assert with_response_surface(wheels.of_scene(passed)[0]) == ("b",)
    along = RUNGS["planar-moment+roll"].of_scene(passed)[0]
    assert (
        along.transform == "standard"
    )  # its errors of the yaw rate are too wide for the bounds of e_m
    assert "mark_1_b" not in along.evidence
    assert RUNGS["momentum+roll"].of_scene(passed)[0].transform == "rest-pose"
    # a rung that follows no heading lacks nothing
    assert not RUNGS["momentum+slide"].of_scene(partly)[0].unmeasured
