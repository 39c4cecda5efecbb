"""A slope of the whole ground in the most detailed run-out and before the impact."""

from __future__ import annotations

import math
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro import handlers
from retrodict.models import RUNGS, parts, rungs_for
from retrodict.models.arrays import Data, Structure

import retrodict as rd
from retrodict.constants import GRAVITY
from retrodict.mechanics import Ground, Incline, rest
from retrodict.scene.records import Measured, Scene, Slope
from tests.shared.scenes import at_rest, collision, positive, rolls

RUNG = RUNGS["planar-moment+wheels"]
SCENE = collision(share=0.02)
SLOPE = Slope(Measured(0.06, 0.005), Measured(-1.0, 0.05))
ON_SLOPE = replace(SCENE, slope=SLOPE)
AFTER = jnp.array([-3.0, 2.0, 3.0, 7.0, -9.0, 9.0])


def as_measured(structure: Structure, data: Data) -> parts.Values:
    return parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))


def test_without_one_the_ground_is_level() -> None:
    structure, data = RUNG.of_scene(SCENE)
    assert parts.ground(structure, data, as_measured(structure, data)).incline is None
    assert not {"grade", "uphill"} & data.inputs.keys()


@pytest.mark.slow
def test_it_is_two_inputs_of_the_run_outs() -> None:
    (structure, data), (level, _) = RUNG.of_scene(ON_SLOPE), RUNG.of_scene(SCENE)
    assert set(structure.uncertain) - set(level.uncertain) == {
        ("grade", "normal"),
        ("uphill", "normal"),
    }
    x = as_measured(structure, data)
    ends = RUNG.run_out.rest_poses(structure, data, x, AFTER)
    ground = parts.ground(structure, data, x)
    for i, v in enumerate("ab"):
        car = jax.tree.map(lambda both: both[i], parts.cars(structure, x))  # noqa: B023
        own = Ground(
            jnp.asarray(ground.coefficients)[i], None, ground.zones, incline=Incline(0.06, -1.0)
        )
        start, velocity = parts.impact_poses(x)[i], AFTER.reshape(2, 3)[i]
        alone = rest(start, velocity, car, own, int(data.steps.number))
        np.testing.assert_allclose(ends[i], alone, rtol=0, atol=1e-9, err_msg=v)


@pytest.mark.parametrize(
    "name", [n for n in rungs_for(SCENE) if n.endswith(("+slide", "+spin", "+roll"))]
)
def test_simpler_run_outs_neglect_it(name: str) -> None:
    rung = RUNGS[name]
    (on_slope, its), (level, own) = map(rung.of_scene, (ON_SLOPE, SCENE))
    assert on_slope == level
    assert its.inputs.keys() == own.inputs.keys()
    assert any("slopes" in line for line in rung.description(SCENE).left_out)


def test_the_run_out_along_the_way_does_not_stand_in_on_a_slope() -> None:
    scene = rolls(SCENE, "a", (0.9, 0.9, 0.5, 0.5))
    rung = RUNGS["planar-moment+roll"]
    assert not rung.refusal(scene)
    assert "level" in rung.refusal(replace(scene, slope=SLOPE))


@pytest.mark.parametrize("turn", [0.0, math.pi])
def test_a_skid_up_to_the_impact(turn: float) -> None:
    """v0² = v² + 2 g (f cos θ + sin θ) s uphill; downhill with the other sign."""
    skid = replace(ON_SLOPE.approach["a"], skid=positive(20.0, 0.01))
    uphill = Measured(skid.direction.value + turn, 0.05)  # type: ignore[union-attr]
    scene = replace(
        ON_SLOPE, approach=ON_SLOPE.approach | {"a": skid}, slope=replace(SLOPE, uphill=uphill)
    )
    structure, data = RUNG.of_scene(scene)
    x = as_measured(structure, data)
    v, after = x["speed_a"], jnp.zeros(6)
    change = parts.approach_of_a(x)[:2]
    after = after.at[:2].set(change)  # no delta-v: before it is as after
    with handlers.trace() as trace:
        parts.record_skids(structure, x, after)
    theta, f = math.atan(0.06), x["friction_road"] * x["grip_a"]
    held = f * math.cos(theta) + math.cos(turn) * math.sin(theta)
    expected = math.sqrt(v**2 + 2 * GRAVITY * held * x["skid_a"])
    assert float(trace["travelling_speed_a"]["value"]) == pytest.approx(expected)


def simulated(uphill: float) -> Scene:
    """B at 19 m/s strikes A, on a grade of 6 %; friction and all else is well known."""
    bare = collision(share=0.0, berm=False)
    road = replace(bare.surfaces[0], friction=positive(0.5, 0.01))
    slope = Slope(Measured(0.06, 0.003), Measured(uphill, 0.02))
    of_a = replace(bare.approach["a"], speed=Measured(20.0, 0.1))
    scene = replace(bare, surfaces=(road,), slope=slope, approach=bare.approach | {"a": of_a})
    rung = RUNGS["momentum+wheels"]
    structure, data = rung.of_scene(scene)
    x = as_measured(structure, data)
    V_a = np.array([-12.0, 2.0])  # a glancing blow: both run out far, B uphill and A downhill
    before_b = 19.0 * np.array([math.cos(-0.38), math.sin(-0.38)])
    impulse = 1857.0 * (V_a - np.array(parts.approach_of_a(x))[:2])
    V_b = before_b - impulse / 1778.0
    after = jnp.array([*V_a, 1.5, *V_b, 4.0])
    ends = np.array(rung.run_out.rest_poses(structure, data, x, after))
    return at_rest(scene, {v: tuple(end) for v, end in zip("ab", ends, strict=True)})


@pytest.mark.slow
def test_a_crash_on_a_slope_is_recovered_where_the_slope_is_stated() -> None:
    """Level ground makes B, which ran out uphill, leave slower than it did, and A faster against it.

    Both take from B's speed before the impact: 6 % of it and more.
    """
    scene = simulated(uphill=-math.pi / 4)

    def speed(scene: Scene) -> tuple[float, float]:
        draws = rd.reconstruct(scene, model="momentum+wheels", method="importance", seed=3)
        assert draws.checks.passed
        values = draws.idata["posterior"]["speed_b"].values
        return float(values.mean()), float(values.std())

    mean, sd = speed(scene)
    assert abs(mean - 19.0) < 2 * sd
    level, its_sd = speed(replace(scene, slope=None))
    assert level < 19.0 - 2 * its_sd
