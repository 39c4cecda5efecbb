"""The end of rotation, against closed forms and events of SciPy's integrator."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from retrodict.mechanics import Car, Ground, Path, Wheels, Zone, end_of_rotation, run_out
from retrodict.mechanics.end_of_rotation import _CREEP, ROLLING, SIDEWAYS
from tests.shared import reference

CAR = Car(k2=1.8, front_axle=1.3, rear_axle=1.5, track=1.5)
STILL = np.zeros(3)
_end = jax.jit(end_of_rotation)
_follow = jax.jit(run_out, static_argnames="steps")


def slipping(degrees: np.ndarray, backwards: bool = False) -> Path:
    """Along x at 10 m/s without yaw, a metre a row, with these slip angles."""
    x = np.arange(len(degrees), dtype=float)
    along, across = 10.0 - _CREEP, 10.0 * np.tan(np.radians(degrees))
    ahead = np.full_like(x, -along if backwards else along)
    still = np.zeros_like(x)
    pose = np.stack([x, 2 * x, still], axis=1)
    return Path(pose, np.stack([ahead, across, still], axis=1), x)


@pytest.mark.parametrize("backwards", [False, True])
def test_slip_that_falls_evenly_ends_halfway_between_the_thresholds(backwards: bool) -> None:
    path = slipping(np.linspace(30.0, 0.0, 31), backwards)  # a degree a row
    np.testing.assert_allclose(_end(path, CAR), [20.0, 40.0, 0.0], atol=1e-9)


def test_only_the_last_fall_counts() -> None:
    once = np.linspace(30.0, 0.0, 31)
    path = slipping(np.concatenate([once, once[10:]]))  # out to 20 deg once more
    np.testing.assert_allclose(_end(path, CAR), [41.0, 82.0, 0.0], atol=1e-9)


def test_it_moves_continuously_as_a_vehicle_swings_out_once_more() -> None:
    """From the first fall to the second, evenly with the thresholds that the second reaches."""

    def end(most: float) -> float:
        """x of the end, after a swing to so many degrees on row 40."""
        slip = np.interp(np.arange(61), [0, 30, 35, 40, 45, 60], [30, 0, 0, most, 0, 0])
        return float(_end(slipping(slip), CAR)[0])

    tops = np.linspace(7.0, 13.0, 601)
    found = np.array([end(top) for top in tops])
    assert found[0] == pytest.approx(20.0)
    assert found[-1] > 40
    assert np.abs(np.diff(found)).max() < 0.1  # of 21 m in 401 steps between 8 and 12 deg


def test_one_that_never_slides_sideways_ends_where_it_starts_and_a_spinning_one_at_rest() -> None:
    ground = Ground(np.array([0.6]), None, Zone(np.zeros((0, 2)), np.zeros((0, 2))))
    straight = _follow(STILL, np.array([12.0, 0.0, 0.0]), CAR, ground, steps=96)
    np.testing.assert_allclose(_end(straight, CAR), STILL, atol=1e-9)
    aside = _follow(STILL, np.array([3.0, 9.0, 0.0]), CAR, ground, steps=96)
    np.testing.assert_allclose(_end(aside, CAR), aside.pose[-1], atol=2e-3)


def crossings(scene: reference.Scene) -> np.ndarray:
    """Poses at which the rear axle's slip last falls below each of many thresholds, by SciPy."""

    def slip(y: np.ndarray) -> np.ndarray:
        c, s = np.cos(y[2]), np.sin(y[2])
        across = c * y[4] - s * y[3] - scene.rear_axle * y[5]
        return np.arctan2(np.abs(across), np.abs(c * y[3] + s * y[4]) + _CREEP)

    def stopped(_: float, y: np.ndarray) -> float:
        return float(np.hypot(y[3], y[4])) - 1e-3

    stopped.terminal = True
    run = solve_ivp(
        lambda _, y: reference.slope(y, scene),
        (0, 200),
        [*scene.pose, *scene.velocity],
        "DOP853",
        rtol=1e-9,
        atol=1e-9,
        events=stopped,
        dense_output=True,
    )
    time = np.linspace(0, run.t[-1], 200_001)
    angle = slip(run.sol(time))
    most = np.maximum.accumulate(angle[::-1])[::-1]
    thresholds = np.linspace(ROLLING, SIDEWAYS, 401)
    last = [time[np.flatnonzero(most >= threshold)[-1]] for threshold in thresholds]
    return run.sol(np.array(last))[:3].T


@pytest.mark.parametrize("locked", [(1, 0, 0, 0), (1, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 0)])
def test_it_is_where_scipy_has_it(locked: tuple[int, ...]) -> None:
    """Of cars that were struck aside and then roll, with one, two or no wheels locked."""
    drag, steer = np.where(locked, 1.0, 0.08), np.array([0.05, 0.05, 0.0, 0.0])
    pose, velocity = np.array([0.0, 0.0, 0.3]), np.array([13.0, 6.0, 2.0])
    scene = reference.Scene(
        *(pose, velocity, *CAR[:4], np.array([0.7, 0.7]), np.zeros(2)),
        *(np.array([500.0, 0.0]), np.array([1.0, 0.0]), drag, steer),
    )
    ground = Ground(np.array([0.7]), None, Zone(np.zeros((0, 2)), np.zeros((0, 2))))
    car = CAR._replace(wheels=Wheels(drag, steer))
    path = _follow(pose, velocity, car, ground, steps=3072)
    expected = crossings(scene).mean(axis=0)
    np.testing.assert_allclose(_end(path, car), expected, atol=1e-3)
    far = np.linalg.norm(np.asarray(path.pose[-1, :2]) - expected[:2])
    assert far > 1  # it rolled on


@pytest.mark.slow
def test_derivatives_are_those_of_difference_quotients() -> None:
    ground = Ground(np.array([0.7]), None, Zone(np.zeros((0, 2)), np.zeros((0, 2))))
    car = CAR._replace(wheels=Wheels(np.array([1.0, 0.08, 0.08, 0.08]), np.zeros(4)))

    @jax.jit
    def end(velocity: jax.Array) -> jax.Array:
        return end_of_rotation(run_out(jnp.array([0.0, 0.0, 0.3]), velocity, car, ground, 768), car)

    velocity = np.array([13.0, 6.0, 2.0])
    slope = jax.jit(jax.jacrev(end))
    step = 1e-5
    quotients = [
        (end(velocity + step * e) - end(velocity - step * e)) / (2 * step) for e in np.eye(3)
    ]
    np.testing.assert_allclose(slope(velocity), np.stack(quotients, axis=1), rtol=1e-3, atol=1e-3)
    for V in ([10.0, 0.0, 0.0], [0.0, 8.0, 0.0], [1e-3, 0.0, 0.0], [0.0, 0.0, 0.0]):
        assert np.isfinite(slope(np.array(V))).all()
