"""The run-out along a measured way: closed forms, and run-outs on wheels that it follows."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import (
    Car,
    Ground,
    Way,
    Wheels,
    Zone,
    drag_factor,
    rolled,
    rolled_back,
    run_out,
    way_taken,
)

MU, G = 0.6, 9.80665
NOWHERE = Zone(np.zeros((0, 2)), np.zeros((0, 2)))
ROAD = Ground(jnp.array([MU]), None, NOWHERE)


def car(drags: tuple[float, ...] | None, steer: float = 0.0) -> Car:
    wheels = drags and Wheels(jnp.array(drags), steer * jnp.array([1.0, 1.0, 0.0, 0.0]))
    return Car(1.9, 1.2, 1.4, 1.5, wheels)


def drag(drags, crab: float, turning: float = 0.0, ground: Ground = ROAD) -> float:
    """At one point, 8 m/s."""
    point = (jnp.zeros((1, 2)), jnp.array([0.4 + crab]), jnp.array([0.4]))
    return float(drag_factor(*point, jnp.array([turning]), jnp.array([8.0]), car(drags), ground)[0])


@pytest.mark.parametrize("crab", [0.0, 0.7, np.pi / 2, 2.5])
@pytest.mark.parametrize("drags", [None, (1.0, 1.0, 1.0, 1.0)])
def test_locked_wheels_hold_back_by_friction_at_any_crab_angle(drags, crab) -> None:
    assert drag(drags, crab) == pytest.approx(MU, rel=1e-9)


def test_rolling_straight_ahead_holds_back_by_the_mean_drag_by_load() -> None:
    front = 1.4 / 2.6 / 2
    mean = front * (0.1 + 0.3) + (0.5 - front) * (0.02 + 1.0)
    assert drag((0.1, 0.3, 0.02, 1.0), 0.0) == pytest.approx(MU * mean, rel=1e-9)


@pytest.mark.parametrize("drags", [(0.0, 0.0, 0.0, 0.0), (0.1, 0.9, 0.05, 0.05)])
def test_sideways_any_wheels_hold_back_by_friction(drags) -> None:
    assert drag(drags, np.pi / 2) == pytest.approx(MU, rel=2e-3)  # but for the slip's softening


def test_spinning_on_locked_wheels_holds_back_the_less() -> None:
    """The left wheels slip aside only, the right ones forward by twice the speed besides."""
    turning = 1 / 0.75  # about a point between the left wheels
    front, rear = 1.4 / 2.6 / 2, 1.2 / 2.6 / 2
    on_the_right = front / np.hypot(1, 1.2 * turning / 2) + rear / np.hypot(1, 1.4 * turning / 2)
    assert drag(None, 0.0, turning) == pytest.approx(MU * on_the_right, rel=2e-3)


def test_friction_is_that_of_the_surface_under_each_wheel() -> None:
    """An edge along the course through the middle: a side on each surface, sliding without yaw."""
    edge = Zone(np.array([[0.0, 0.0]]), np.array([[-np.sin(0.4), np.cos(0.4)]]))
    two = Ground(jnp.array([MU, 0.2]), None, edge)
    assert drag(None, 0.0, 0.0, two) == pytest.approx((MU + 0.2) / 2, rel=1e-9)


@pytest.mark.slow
def test_speed_dependent_friction_is_summed_as_the_slide_is_integrated() -> None:
    """Straight on locked wheels, V dV = -g f exp(-c V) ds has a closed form."""
    c, V = 0.03, 15.0
    length = (1 - np.exp(c * V) * (1 - c * V)) / c**2 / (G * MU)
    ground = Ground(jnp.array([MU]), jnp.array([c]), NOWHERE)
    way = Way(jnp.array([[length, 0.0]]), jnp.array([0.0]))
    taken = way_taken(way, jnp.zeros(3), car(None), ground)
    assert np.sqrt(2 * G * float(taken.drag) * length) == pytest.approx(V, rel=3e-3)


@pytest.mark.slow
def test_the_measured_way_is_followed_by_the_velocity_of_its_length_and_course() -> None:
    """A polyline; speed, course and yaw rate by the laws it states; then a quarter slower, turned."""
    start = jnp.array([2.0, 1.0, 0.3])
    points = jnp.array([[8.0, 2.0], [15.0, 6.0]])
    heading = jnp.array([jnp.nan, 1.5])
    taken = way_taken(Way(points, heading), start, car((0.1, 1.0, 0.1, 0.1)), ROAD)
    length = np.hypot(6, 1) + np.hypot(7, 4)
    assert float(taken.length) == pytest.approx(length)
    V, course = np.sqrt(2 * G * float(taken.drag) * length), np.arctan2(1, 6)
    Omega = 1.2 / (0.55 * float(taken.share) * 2 * length / V)
    velocity = jnp.array([V * np.cos(course), V * np.sin(course), Omega])
    at = taken.stations
    found = np.asarray(rolled(velocity, start, taken, at))
    np.testing.assert_allclose(rolled_back(found[-1], start, taken), velocity, atol=1e-9)
    expected = np.array([[0.0, 0.0], [6.0, 1.0], [13.0, 5.0]])
    np.testing.assert_allclose(found[:, :2] - start[:2], expected, atol=1e-6)
    np.testing.assert_allclose(found[[0, -1], 2], [0.3, 1.5], atol=1e-6)
    turned = jnp.array([-velocity[1], velocity[0], 2 * Omega]) / 2
    found = np.asarray(rolled(turned, start, taken, at))
    np.testing.assert_allclose(rolled_back(found[-1], start, taken), turned, atol=1e-9)
    np.testing.assert_allclose(
        found[:, :2] - start[:2], expected[:, ::-1] * np.array([-1.0, 1.0]) / 4, atol=1e-6
    )


def test_known_ends_of_the_rotation_take_the_place_of_the_computed_one() -> None:
    points, start = jnp.array([[6.0, 0.0], [30.0, 0.0]]), jnp.zeros(3)
    at_end = Way(points, jnp.array([1.0, 1.1]))
    taken = way_taken(at_end, start, car((0.02,) * 4), ROAD)
    assert float(taken.share) == pytest.approx(0.2)
    assert float(taken.turned) == pytest.approx(1.0)
    assert float(taken.turned_after) == pytest.approx(0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("drags", "within"), [((1.0, 1.0, 1.0, 0.05), 0.05), ((1.0, 0.05, 0.05, 0.05), 0.18)]
)
def test_speed_is_that_of_run_outs_on_wheels(drags, within) -> None:
    """In the median of crab angles and yaw rates that ordinary impacts leave."""
    rng = np.random.default_rng(1)
    headings, Omegas, V = rng.uniform(-0.8, 0.8, 24), rng.uniform(-4, 4, 24), 12.0

    @jax.jit
    @jax.vmap
    def error(heading, Omega):
        start = jnp.array([0.0, 0.0, 1.0]) * heading
        path = run_out(start, jnp.array([V, 0.0, Omega]), car(drags), ROAD, 512)
        end = path.pose[-1]
        taken = way_taken(Way(end[None, :2], end[None, 2]), start, car(drags), ROAD)
        return jnp.log(V**2 / (2 * G * taken.drag * taken.length)) / 2

    off = np.asarray(error(jnp.asarray(headings), jnp.asarray(Omegas)))
    assert abs(np.median(off)) < within / 2
    assert np.quantile(np.abs(off), 0.8) < within


def test_a_car_that_only_turned_about_has_a_velocity_that_leads_there() -> None:
    start, end = jnp.array([2.2, 0.9, 3.2]), jnp.array([2.1, 0.4, 6.5])
    taken = way_taken(Way(end[None, :2], end[None, 2]), start, car((1.0, 0.05, 1.0, 0.05)), ROAD)
    velocity = rolled_back(end, start, taken)
    np.testing.assert_allclose(rolled(velocity, start, taken, jnp.ones(1))[0], end, atol=1e-9)
