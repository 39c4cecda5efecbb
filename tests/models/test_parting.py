"""Vehicles that part before the impact are ruled out, by models of an impact of two vehicles."""

from pathlib import Path

import jax
import numpy as np
import pytest
from retrodict.models import parts

from retrodict.inference.fitting.about_peak import crashes_of
from retrodict.inference.prior_check import reference
from retrodict.scene import load_scene

SCENE = load_scene(
    Path(__file__).parents[2] / "benchmarks" / "users" / "scenes" / "rear-end-delta-v.toml"
)
SPEEDS = ("speed_a", "speed_b")


@pytest.mark.slow
@pytest.mark.parametrize("rung", ["planar-common+spin", "planar-moment+wheels"])
def test_no_crash_is_left_in_which_b_does_not_catch_a(rung: str) -> None:
    """At the contact, where courses and yaw rates that are not quite nought count as well."""
    crashes = crashes_of(SCENE, rung)
    u = np.random.default_rng(0).standard_normal((2048, crashes.size))
    log_likelihood, quantities = crashes.at(u)
    parting = quantities["closing_speed"] <= 0
    assert 0.05 < parting.mean() < 0.95
    assert (log_likelihood[parting] == -np.inf).all()
    # but for impacts of some mm/s, after which velocities may be no numbers
    fast = quantities["closing_speed"] > 0.01
    assert np.isfinite(log_likelihood[fast]).all()
    # one goes after the other: but for some hundredths of a radian that is the faster one, behind
    behind = quantities["speed_b"] < quantities["speed_a"] - 0.2
    assert (log_likelihood[behind] == -np.inf).all()


@pytest.mark.slow
@pytest.mark.parametrize("rung", ["planar-common+spin", "planar-moment+wheels"])
def test_the_evidence_leaves_no_crash_in_which_b_behind_is_the_slower(rung: str) -> None:
    left = reference(crashes_of(SCENE, rung), SPEEDS, seed=0)
    slower = left.quantities["speed_b"] <= left.quantities["speed_a"]
    assert left.effective > 200
    assert left.weights[slower].sum() < 1e-6


@pytest.mark.slow
def test_by_momentum_alone_the_impulse_pushes() -> None:
    crashes = crashes_of(SCENE, "momentum+spin")
    u = np.random.default_rng(0).standard_normal((2048, crashes.size))
    log_likelihood, q = crashes.at(u)
    v_a = q["speed_a"] * np.array([np.cos(q["direction_a"]), np.sin(q["direction_a"])])
    v_b = np.array([q["vbx"], q["vby"]])
    structure, data = crashes.programs.structure, crashes.data

    def beyond(measured: jax.Array) -> jax.Array:
        """From the centre of gravity of B to that of A, by way of the impact centre."""
        lever_a, lever_b = parts.levers(parts.from_standard(structure, data, measured))
        return lever_b - lever_a

    apart = np.asarray(jax.vmap(beyond)(q["measured"])).T
    P = np.array([q["impulse_x"], q["impulse_y"]])
    pushes = (np.sum((v_b - v_a) * P, axis=0) > 0) & (np.sum(apart * P, axis=0) > 0)
    assert 0.05 < pushes.mean() < 0.95
    np.testing.assert_array_equal(np.isfinite(log_likelihood), pushes)


@pytest.mark.slow
def test_the_speed_of_a_car_that_nudged_another_is_that_of_weighted_crashes() -> None:
    """An independent forward model gives 11.46 ± 0.99 m/s."""
    left = reference(crashes_of(SCENE, "planar-moment+wheels"), SPEEDS, seed=0)
    speed = left.quantities["speed_b"]
    assert left.effective > 400
    mean = left.weights @ speed
    sd = np.sqrt(left.weights @ (speed - mean) ** 2)
    assert mean == pytest.approx(11.46, abs=4 * 0.99 / np.sqrt(left.effective) + 0.005)
    assert sd == pytest.approx(0.99, abs=4 * 0.99 / np.sqrt(2 * left.effective) + 0.005)
