"""Mechanics take lists as they take arrays, and a ground of one friction is a number."""

import jax
import numpy as np
import pytest

from retrodict.mechanics import (
    Bodies,
    Car,
    Coefficients,
    Ground,
    Wheels,
    Zone,
    audit,
    clock,
    rest,
    run_out,
    separation,
    severity,
    wheel_paths,
)

BODIES = Bodies(1857, 1778, 3374, 3007, 1.636, 0.653, 0.205, 2.079, -0.155)
COEFFICIENTS = Coefficients(0.1, 0.35, 0.7)
APPROACH = [-20, 0, 0, 19, -4, -1]
CAR = Car(1.8, 1.3, 1.5, 1.5)
POSE, VELOCITY = [0, 0, 0.3], [12, 3, 4]
NOWHERE = Zone(np.zeros((0, 2)), np.zeros((0, 2)))
STEPS = 24


def same(one, other) -> None:
    for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.slow
def test_an_impact_of_lists_is_that_of_arrays():
    array, headings = np.array(APPROACH, float), [3.1, -0.2]
    same(separation(APPROACH, BODIES, COEFFICIENTS), separation(array, BODIES, COEFFICIENTS))
    same(audit(APPROACH, BODIES, COEFFICIENTS), audit(array, BODIES, COEFFICIENTS))
    same(
        severity(APPROACH, BODIES, COEFFICIENTS, headings),
        severity(array, BODIES, COEFFICIENTS, np.array(headings)),
    )
    assert clock([0.0, np.pi / 2]).tolist() == [12, 3]


@pytest.mark.slow
def test_a_run_out_of_lists_is_that_of_arrays():
    wheels = Wheels([1, 1, 0.1, 0.1], [0, 0, 0, 0])
    square = [[9, 9], [12, 9], [12, 12]]
    ground = Ground([0.7, 0.3, 0.2], [0.01, 0, 0], Zone([[5, 0]], [[1, 0]]), (square,), [1])
    listed = rest(POSE, VELOCITY, CAR._replace(wheels=wheels), ground, STEPS)
    arrays = jax.tree.map(
        lambda a: np.asarray(a, float),
        (POSE, VELOCITY, CAR._replace(wheels=wheels), ground),
        is_leaf=lambda a: isinstance(a, list),
    )
    same(listed, rest(*arrays, STEPS))


def test_one_friction_everywhere_is_a_number():
    plain, spelled = Ground(0.7), Ground(np.array([0.7]), None, NOWHERE)
    path = run_out(POSE, VELOCITY, CAR, plain, STEPS)
    same(path, run_out(np.array(POSE), np.array(VELOCITY), CAR, spelled, STEPS))
    assert repr(path) == "<Path: pose (26, 3), velocity (26, 3), time (26,)>"
    same(wheel_paths(POSE, CAR), wheel_paths(np.array(POSE), CAR))


@pytest.mark.slow
def test_forward_mode_by_adaptive_steps_is_refused_with_what_to_do():
    def end(velocity, steps=None):
        return rest(POSE, velocity, CAR, Ground(0.7), steps)

    with pytest.raises(TypeError, match=r"jax\.jacrev .* steps=200"):
        jax.jvp(end, (np.array(VELOCITY, float),), (np.ones(3),))
    _, slope = jax.jvp(lambda v: end(v, STEPS), (np.array(VELOCITY, float),), (np.ones(3),))
    assert np.isfinite(slope).all()
