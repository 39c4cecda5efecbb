"""Vehicles that go on together: conserved momenta, the planar impact's limit, the run-out by SciPy."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from retrodict.constants import GRAVITY
from retrodict.mechanics import (
    Bodies,
    Car,
    Coefficients,
    Ground,
    critical_mu,
    lever_arms,
    rest,
    run_out,
    separation,
)
from retrodict.mechanics.integration import Paced
from retrodict.mechanics.together import Layout, Masses, common_motion, joined, layout
from retrodict.mechanics.tyre import Wheels

PATCH = 0.08
MASSES = Masses(np.array([1600.0, 1300.0]), np.array([2700.0, 1900.0]))
POSES = np.array([[-2.1, 0.1, 0.05], [1.0, 0.3, 1.6]])
CARS = Car(*np.array([[1.7, 1.5], [1.2, 1.1], [1.5, 1.45], [1.52, 1.47]]))
GRIP = np.array([1.0, 0.9])


def random_motions(count=20, seed=3):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        masses = Masses(rng.uniform(800, 3000, 2), rng.uniform(900, 6000, 2))
        levers = rng.uniform(-2.5, 2.5, (2, 2))
        before = rng.normal(0, [12, 12, 1, 12, 12, 1])
        yield masses, levers, before, rng.uniform(-np.pi, np.pi)


def test_momentum_and_angular_momentum_are_kept_and_one_body_moves():
    for masses, levers, before, _ in random_motions():
        apart = levers[0] - levers[1]
        after = np.asarray(common_motion(before, apart, masses)).reshape(2, 3)
        first = before.reshape(2, 3)
        np.testing.assert_allclose(masses.mass @ after[:, :2], masses.mass @ first[:, :2])
        places = np.array([[0.0, 0.0], apart])  # angular momentum about A's centre of gravity

        def angular(v, masses=masses, places=places):
            moments = places[:, 0] * v[:, 1] - places[:, 1] * v[:, 0]
            return masses.mass @ moments + masses.yaw_inertia @ v[:, 2]

        assert angular(after) == pytest.approx(angular(first), rel=1e-9)
        assert after[0, 2] == after[1, 2]
        turning = after[0, 2] * np.array([-apart[1], apart[0]])
        np.testing.assert_allclose(after[1, :2] - after[0, :2], turning, atol=1e-9)


def test_it_is_the_planar_impact_without_restitution_rotation_or_sliding_left():
    """SAE 770014 eqs 19 to 24 at e = 0, e_m = 0 and the critical mu."""
    for masses, levers, before, Gamma in random_motions():
        bodies = Bodies(*masses.mass, *masses.yaw_inertia, *lever_arms(*levers), Gamma)
        mu = critical_mu(before, bodies, 0.0, 0.0)
        planar = separation(before, bodies, Coefficients(0.0, mu, 0.0))
        joined_ = common_motion(before, levers[0] - levers[1], masses)
        np.testing.assert_allclose(joined_, planar, atol=1e-8)


def body(wheels=None):
    at = layout(jnp.asarray(POSES), jnp.asarray(MASSES.mass))
    return at, joined(at, MASSES, CARS._replace(wheels=wheels), jnp.asarray(GRIP))


def by_scipy(at: Layout, velocity, friction):
    """Rest poses of both vehicles on eight locked wheels, by forces on each wheel over time."""
    M = MASSES.mass.sum()
    centre = MASSES.mass @ POSES[:, :2] / M
    offset = POSES[:, :2] - centre
    inertia = MASSES.yaw_inertia.sum() + MASSES.mass @ (offset**2).sum(axis=1)
    arms, loads = [], []
    for i in range(2):
        _, front, rear, track = (column[i] for column in CARS[:4])
        c, s = np.cos(POSES[i, 2]), np.sin(POSES[i, 2])
        for ahead, share in ((front, rear), (-rear, front)):
            for left in (track / 2, -track / 2):
                arms.append(offset[i] + [c * ahead - s * left, s * ahead + c * left])
                loads.append(MASSES.mass[i] * GRAVITY * share / (front + rear) / 2 * GRIP[i])
    arms, loads = np.array(arms), np.array(loads)

    def rate(_, y):
        c, s = np.cos(y[2]), np.sin(y[2])
        arm = arms @ np.array([[c, s], [-s, c]])
        slip = y[3:5] + y[5] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        size = np.sqrt((slip**2).sum(axis=1) + (PATCH * y[5]) ** 2 + 1e-18)
        force = -friction * (loads / size)[:, None] * slip
        moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        return [*y[3:], *force.sum(axis=0) / M, moment.sum() / inertia]

    def stopped(_, y):
        return y[3] ** 2 + y[4] ** 2 + inertia / M * y[5] ** 2 - 1e-8

    stopped.terminal = True
    y = [*centre, 0.0, *velocity]
    end = solve_ivp(rate, (0, 60), y, "DOP853", rtol=1e-10, atol=1e-12, events=stopped).y[:, -1]
    c, s = np.cos(end[2]), np.sin(end[2])
    places = end[:2] + offset @ np.array([[c, s], [-s, c]])
    return np.column_stack([places, POSES[:, 2] + end[2]])


@pytest.mark.parametrize("velocity", [(9.0, 4.0, 3.0), (4.0, -7.0, -5.0), (12.0, 0.0, 0.2)])
def test_the_joined_body_comes_to_rest_where_scipy_says(velocity):
    at, both = body()
    end = at.poses(rest(at.pose, np.array(velocity), both, Ground(0.7), steps=400))
    np.testing.assert_allclose(end, by_scipy(at, velocity, 0.7), atol=2e-3)


def test_without_yaw_the_joined_body_slides_as_far_as_its_mean_friction_lets_it():
    at, both = body()
    end = rest(at.pose, np.array([10.0, 0.0, 0.0]), both, Ground(0.7), steps=400)
    mean = 0.7 * (MASSES.mass @ GRIP) / MASSES.mass.sum()
    # unequal grip turns it a little
    assert end[0] - at.pose[0] == pytest.approx(100 / (2 * mean * GRAVITY), rel=0.02)


def test_wheels_that_roll_carry_the_joined_body_farther():
    velocity = np.array([10.0, 0.0, 0.0])
    rolling = Wheels(jnp.array([[0.05] * 4, [1.0] * 4]), jnp.zeros((2, 4)))
    at, locked = body()
    _, freer = body(rolling)
    far, near = (
        rest(at.pose, velocity, each, Ground(0.7), steps=steps)[0]
        for each, steps in ((freer, Paced(4.0)), (locked, 400))
    )
    assert far > 1.3 * near


def test_both_paths_are_those_of_one_body():
    at, both = body()
    paths = at.paths(run_out(at.pose, np.array([9.0, 4.0, 3.0]), both, Ground(0.7), steps=96))
    between = paths.pose[1, :, :2] - paths.pose[0, :, :2]
    np.testing.assert_allclose(jnp.hypot(*between.T), np.hypot(*(POSES[1] - POSES[0])[:2]))
    np.testing.assert_allclose(paths.pose[0, 0], POSES[0], atol=1e-12)
    np.testing.assert_allclose(paths.pose[1, 0], POSES[1], atol=1e-12)
    # velocities are the rates of the places
    steps, place = jnp.diff(paths.time[0]), jnp.diff(paths.pose[1, :, :2], axis=0)
    mean = (paths.velocity[1, 1:, :2] + paths.velocity[1, :-1, :2]) / 2
    np.testing.assert_allclose(place[:40] / steps[:40, None], mean[:40], atol=0.02)
