"""The edges of the run-out that docs/atlas.md lists."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import Ground, Wheels, rest
from tests.shared import reference
from tests.shared.edges import (
    CAR,
    PLAIN,
    SPINNING,
    by_reference,
    error_of_steps,
    grazed_edge,
    on_edge,
    skid,
)

_rest = jax.jit(rest)


@pytest.mark.slow
def test_a_wheel_at_the_instant_centre() -> None:
    velocity = [3.0, 6.0, 4.0]
    truth = by_reference(velocity, 0.7)
    np.testing.assert_allclose(skid(velocity, 0.7), truth, atol=1e-6)
    np.testing.assert_allclose(skid(velocity, 0.7, 768), truth, atol=1e-3)


def test_spin_alone_translation_alone_and_nothing() -> None:
    """v²/2fg without spin; turning on the spot strays little; what stands still stays."""
    slide = skid([10.0, 0.0, 0.0], 0.5)
    np.testing.assert_allclose(slide, [100 / (9.80665), 0.0, 0.3], atol=1e-9)
    turn = skid([0.0, 0.0, 8.0], 0.5)
    assert np.hypot(*turn[:2]) < 0.1
    np.testing.assert_allclose(turn, by_reference([0.0, 0.0, 8.0], 0.5), atol=1e-6)
    for velocity in ([0.0, 0.0, 0.0], [1e-7, 0.0, 1e-7]):
        np.testing.assert_allclose(skid(velocity, 0.5), [0.0, 0.0, 0.3], atol=1e-8)


@pytest.mark.parametrize(
    "offset",
    [pytest.param(-0.1, marks=pytest.mark.slow), 0.0, pytest.param(0.1, marks=pytest.mark.slow)],
)
def test_a_zone_boundary_grazed(offset: float) -> None:
    scene = grazed_edge(offset)
    np.testing.assert_allclose(on_edge(scene, None), reference.solve(scene)[0], atol=1e-6)


@pytest.mark.slow
def test_ice_ends_right_or_not_a_number() -> None:
    """At 0.02 160 turns over 1600 m are right; at 0.003 they are too many to follow."""
    velocity = [20.0, 0.0, 15.0]
    for friction in (0.05, 0.02):
        truth = by_reference(velocity, friction)
        np.testing.assert_allclose(skid(velocity, friction), truth, atol=1e-4)
    assert np.isnan(skid(velocity, 0.003)).all()


@pytest.mark.slow
def test_steps_from_coarse_to_fine() -> None:
    """Fixed steps err, by what `step_error` gives within a factor of two; the default does not."""
    truth = by_reference(SPINNING, 0.5)
    errors = []
    for steps in (3, 48, 768):
        errors.append(np.abs(skid(SPINNING, 0.5, steps) - truth).max())
        assert 0.5 < error_of_steps(steps).max() / errors[-1] < 2
    assert errors[0] > 0.1 > errors[1] > 1e-3 > errors[2]
    assert np.abs(skid(SPINNING, 0.5) - truth).max() < 1e-6


@pytest.mark.slow
def test_turns_that_wrap() -> None:
    """A start a whole turn on ends a whole turn on, and nowhere else."""
    velocity, ground = jnp.array([8.0, 1.0, 12.0]), Ground(jnp.array([0.5]), None, PLAIN)
    first = _rest(jnp.array([0.0, 0.0, 0.3]), velocity, CAR, ground)
    assert float(first[2]) > 4 * np.pi
    for turn in (2 * np.pi, -2 * np.pi):
        other = _rest(jnp.array([0.0, 0.0, 0.3 + turn]), velocity, CAR, ground)
        np.testing.assert_allclose(other, first + jnp.array([0.0, 0.0, turn]), atol=1e-7)


@pytest.mark.slow
def test_free_wheels_give_no_rest_pose() -> None:
    def rolls(drag: float) -> np.ndarray:
        return skid([10.0, 0.5, 1.0], 0.7, wheels=Wheels(jnp.full(4, drag), jnp.zeros(4)))

    assert np.isnan(rolls(0.0)).all()
    slow, slower = np.hypot(*rolls(0.05)[:2]), np.hypot(*rolls(0.01)[:2])
    assert slower / slow == pytest.approx(5, rel=0.1)  # what rolls on goes as 1/drag


@pytest.mark.parametrize("steps", [pytest.param(None, marks=pytest.mark.slow), 96])
def test_a_wheel_that_lifts_gives_no_rest_pose(steps: int | None) -> None:
    """Sideways on friction 1 the inner wheels' load is 1 - 2 h/track: none left at h = 0.75 m."""
    assert np.isfinite(skid([0.0, 10.0, 0.0], 1.0, steps, height=0.5)).all()
    assert np.isnan(skid([0.0, 10.0, 0.0], 1.0, steps, height=0.8)).all()


@pytest.mark.slow
def test_friction_lost_to_speed() -> None:
    """Without spin: the integral of v / (f g exp(-c v)) over v, in closed form."""
    f, c, v = 0.7, 0.2, 30.0
    ground = Ground(jnp.array([f]), jnp.array([c]), PLAIN)
    found = _rest(jnp.zeros(3), jnp.array([v, 0.0, 0.0]), CAR, ground)
    way = ((c * v - 1) * np.exp(c * v) + 1) / (c**2 * f * 9.80665)
    np.testing.assert_allclose(found, [way, 0.0, 0.0], rtol=1e-7)
