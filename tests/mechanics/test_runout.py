"""The run-out against closed forms, SciPy, and the laws it must keep."""

import math
from collections.abc import Sequence
from functools import partial

import diffrax  # noqa: F401  first imported in a trace, it makes JAX compile that program twice
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from retrodict.constants import GRAVITY
from retrodict.mechanics import (
    Car,
    Ground,
    Incline,
    Wheels,
    Zone,
    rest,
    run_out,
    tyre,
    wheel_paths,
)
from retrodict.mechanics.integration import Paced, Steps, fixed_steps
from retrodict.mechanics.motion import PATCH, vector_field
from retrodict.mechanics.surface import TYRE_WIDTH
from retrodict.mechanics.tyre import SLIP, SLOW
from tests.shared import reference

CAR = Car(k2=1.8, front_axle=1.3, rear_axle=1.5, track=1.5)
_compiled = jax.jit(rest, static_argnames="steps")
_run_out = jax.jit(run_out)
_slopes = jax.jit(jax.jacrev(rest, argnums=(0, 1)))
_force = jax.jit(tyre.force)
_slope_of = jax.jit(lambda start, ground: jnp.stack(vector_field(CAR, ground)(start)))

thousand = settings(max_examples=1000, deadline=None)


def _rest(*scene: object, steps: int | None = None) -> jax.Array:
    """`rest`, with plain numbers as arrays: one program for both."""
    return _compiled(*jax.tree.map(lambda a: np.asarray(a, float), scene), steps=steps)


def plain(f: float, c: float = 0.0) -> Ground:
    """One surface everywhere."""
    return Ground(np.array([f]), np.array([c]), Zone(np.zeros((0, 2)), np.zeros((0, 2))))


def with_edge(f: float, beyond: float, point: tuple, inward: tuple, c: float = 0.0) -> Ground:
    """A surface and one more beyond an edge."""
    return Ground(
        np.array([f, beyond]), np.array([c, c]), Zone(np.array([point]), np.array([inward]))
    )


def rolling_force(y: np.ndarray, slip: np.ndarray, wheels: Wheels) -> np.ndarray:
    """Force of each wheel over friction times load, from slip angles, in NumPy."""
    drag, steer = np.array(wheels.drag), np.array(wheels.steer)
    ahead = np.stack([np.cos(y[2] + steer), np.sin(y[2] + steer)], axis=1)
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    along, across = (slip * ahead).sum(axis=1), (slip * left).sum(axis=1)
    patch = (PATCH * y[5]) ** 2 + 1e-18
    size = np.sqrt(along**2 + across**2 + patch)
    brake = drag * along / size
    # what the ellipse leaves, and the share of it that the slip angle takes up
    left_over = np.sqrt(1 - brake**2)
    stiff = SLIP**2 * (1 - drag**2) * (along**2 + SLOW**2)
    share = across / np.sqrt(across**2 + patch + stiff)
    return -brake[:, None] * ahead - (left_over * share)[:, None] * left


def by_scipy(
    pose: np.ndarray, velocity: np.ndarray, car: Car, ground: Ground, slowest: float = 1e-5
) -> np.ndarray:
    """Rest pose by SciPy's DOP853 in time, with a right-hand side of its own in NumPy."""
    a, b = car.front_axle, car.rear_axle
    wheels = np.array(
        [[a, car.track / 2], [a, -car.track / 2], [-b, car.track / 2], [-b, -car.track / 2]]
    )
    rise, uphill = (0.0, 0.0) if ground.incline is None else map(float, ground.incline)
    normal = GRAVITY * math.cos(math.atan(rise))
    down = -GRAVITY * math.sin(math.atan(rise)) * np.array([math.cos(uphill), math.sin(uphill)])
    load = normal * np.array([b, b, a, a]) / (a + b) / 2
    f, c = (np.array(v) for v in ground[:2])
    edges = list(zip(np.array(ground.zones.point), np.array(ground.zones.inward), strict=True))

    def loads(turn: np.ndarray, per_load: np.ndarray) -> np.ndarray:
        """Four equations of statics for the loads under the wheels, per unit of mass."""
        force = per_load @ turn  # along and across the vehicle, per load
        rows = [
            np.ones(4),
            wheels[:, 0] + car.height * force[:, 0],  # no pitch about the centre of gravity
            wheels[:, 1] + car.height * force[:, 1],  # no roll
            [a, -a, -b, b],  # left less right: front to rear as the axles' weight, b to a
        ]
        return np.linalg.solve(rows, [normal, 0, 0, 0])

    def motion(_: float, y: np.ndarray) -> np.ndarray:
        turn = np.array([[math.cos(y[2]), -math.sin(y[2])], [math.sin(y[2]), math.cos(y[2])]])
        arms = wheels @ turn.T
        slip = y[3:5] + y[5] * np.stack([-arms[:, 1], arms[:, 0]], axis=1)
        speed = np.sqrt((slip**2).sum(axis=1) + (PATCH * y[5]) ** 2) + 1e-15
        grip = f[0] * np.exp(-c[0] * speed)
        for i, (point, inward) in enumerate(edges):
            s = np.clip((y[:2] + arms - point) @ inward / TYRE_WIDTH + 0.5, 0, 1)
            grip = grip + s * s * (3 - 2 * s) * (f[i + 1] * np.exp(-c[i + 1] * speed) - grip)
        per_load = -(grip / speed)[:, None] * slip
        if car.wheels is not None:
            per_load = grip[:, None] * rolling_force(y, slip, car.wheels)
        on = load if car.height is None else loads(turn, per_load)
        force = on[:, None] * per_load
        torque = (arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0]).sum()
        return np.array([*y[3:], *(force.sum(axis=0) + down), torque / car.k2])

    def stopped(_: float, y: np.ndarray) -> float:
        return y[3] ** 2 + y[4] ** 2 + car.k2 * y[5] ** 2 - slowest**2

    stopped.terminal = True
    run = solve_ivp(
        motion,
        (0, 100),
        [*pose, *velocity],
        "DOP853",
        rtol=1e-10,
        atol=1e-10,
        events=stopped,
        max_step=0.02,
    )
    return run.y[:3, -1]


@pytest.mark.parametrize("f", [0.05, 0.5, 0.9])
def test_stopping_distance_is_that_of_a_sliding_block(f: float) -> None:
    """Closed form: v² / (2 f g), straight on, whatever the heading."""
    end = np.array(_rest(jnp.array([1.0, 2.0, 0.3]), jnp.array([8.0, 6.0, 0.0]), CAR, plain(f)))
    far = 10.0**2 / (2 * f * GRAVITY)
    np.testing.assert_allclose(end, [1 + 0.8 * far, 2 + 0.6 * far, 0.3], atol=1e-6 * far)


@pytest.mark.parametrize("turn", [0.0, math.pi])
@pytest.mark.parametrize(("f", "grade"), [(0.5, 0.06), (0.2, 0.15)])
def test_straight_up_and_down_a_slope(f: float, grade: float, turn: float) -> None:
    """Closed form: v² = 2 g d (f cos θ ± sin θ)."""
    uphill, theta = 0.7, math.atan(grade)
    course = uphill + turn
    velocity = 12.0 * np.array([math.cos(course), math.sin(course), 0.0])
    ground = Ground(f, incline=Incline(grade, uphill))
    far = 12.0**2 / (2 * GRAVITY * (f * math.cos(theta) + math.cos(turn) * math.sin(theta)))
    expected = [far * math.cos(course), far * math.sin(course), 0.3]
    for steps in (None, 48):
        end = np.array(_rest(np.array([0.0, 0.0, 0.3]), velocity, CAR, ground, steps=steps))
        np.testing.assert_allclose(end, expected, atol=1e-6 * far)


@pytest.mark.slow
def test_no_grade_is_level_ground() -> None:
    scene = (np.array([0.0, 0.0, 0.2]), np.array([9.0, 3.0, 4.0]), CAR)
    level, flat = (
        np.array(_rest(*scene, ground, steps=48))
        for ground in (plain(0.6), plain(0.6)._replace(incline=Incline(0.0, 1.0)))
    )
    np.testing.assert_allclose(flat, level, rtol=0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("height", [None, 0.55])
@pytest.mark.parametrize("drag", [[1.0] * 4, [1.0, 0.4, 0.2, 0.2]])
def test_a_slope_agrees_with_scipy(drag: list[float], height: float | None) -> None:
    """Downhill and across, spinning, over an edge; on wheels to the speed at which they would creep."""
    car = rolling(drag, [0.0] * 4)._replace(height=height)
    car = car._replace(wheels=None) if min(drag) == 1 else car
    slow = 1e-5 if car.wheels is None else 0.03
    pose, velocity = np.array([0.0, 0.0, 0.2]), np.array([12.0, 3.0, 4.0])
    ground = with_edge(0.7, 0.5, (0.0, 4.0), (0.0, 1.0), 0.005)._replace(
        incline=Incline(0.06, math.radians(200))
    )
    end = np.array(_rest(pose, velocity, car, ground))
    np.testing.assert_allclose(
        end, by_scipy(pose, velocity, car, ground, slow), atol=2e-5 if slow < 1e-3 else 2e-3
    )
    level = np.array(_rest(pose, velocity, car, ground._replace(incline=None)))
    assert np.hypot(*(end - level)[:2]) > 0.5  # it matters


@pytest.mark.slow
def test_a_rolling_car_comes_to_rest_across_a_slope() -> None:
    """Along the contour it stops by its drag, v² = 2 g d f cos θ, and hardly drifts."""
    car, grade = rolling([0.2] * 4, [0.0] * 4), 0.08
    ground = Ground(0.7, incline=Incline(grade, math.pi / 2))
    end = np.array(rest(np.zeros(3), np.array([10.0, 0.0, 0.0]), car, ground, Paced()))
    far = 100 / (2 * GRAVITY * 0.2 * 0.7 * math.cos(math.atan(grade)))
    assert end[0] == pytest.approx(far, rel=0.01)
    assert -3.0 < end[1] < 0


@pytest.mark.slow
@pytest.mark.parametrize("steps", [48, Paced()])
def test_a_car_that_a_slope_drives_on_has_no_rest_pose(steps: int | Paced) -> None:
    """Rolling wheels hold 0.7 % of the weight, the slope adds 4 %."""
    car = rolling([0.01] * 4, [0.0] * 4)
    ground = Ground(0.7, incline=Incline(0.04, math.pi))
    end = rest(np.zeros(3), np.array([10.0, 0.0, 0.0]), car, ground, steps)
    assert np.isnan(np.array(end)).all()


@pytest.mark.slow
@thousand
@given(st.data())
def test_speed_falls_on_any_slope_that_friction_holds(data: st.DataObject) -> None:
    """The generalised speed of locked wheels, where tan θ is less than friction."""
    f = data.draw(st.floats(0.1, 1.0))
    incline = Incline(0.95 * f * data.draw(st.floats(0, 1)), data.draw(st.floats(-4, 4)))
    velocity = [data.draw(st.floats(-20, 20)) for _ in range(3)]
    if np.hypot(*velocity[:2]) + abs(velocity[2]) < 0.1:
        return
    start = (*np.array([0.0, 0.0, data.draw(st.floats(-4, 4))]), *np.array(velocity), np.zeros(()))
    by_W = np.array(_slope_of(start, Ground(np.float64(f), incline=incline)))
    assert by_W[6] < 0  # s per m/s


def test_stopping_distance_with_friction_that_falls_with_speed() -> None:
    """Closed form of dv/dx = -f g exp(-c v) / v: the integral of v exp(c v) / (f g)."""
    f, c, v = 0.6, 0.02, 15.0
    far = ((c * v - 1) * math.exp(c * v) + 1) / (c**2 * f * GRAVITY)
    end = _rest(jnp.zeros(3), jnp.array([v, 0.0, 0.0]), CAR, plain(f, c))
    assert float(end[0]) == pytest.approx(far, rel=1e-6)


def test_pure_spin_stops_after_the_closed_form_angle() -> None:
    """All wheels as far from the centre: constant torque f g r² / sqrt(r² + patch²) per mass."""
    car = Car(k2=1.7, front_axle=1.4, rear_axle=1.4, track=1.5)
    r = math.hypot(1.4, 0.75)
    torque = 0.6 * GRAVITY * r**2 / math.hypot(r, PATCH)
    end = np.array(_rest(jnp.zeros(3), jnp.array([0.0, 0.0, 8.0]), car, plain(0.6)))
    np.testing.assert_allclose(end, [0, 0, 1.7 * 8.0**2 / (2 * torque)], atol=1e-6)


def random_scene(seed: int) -> tuple[np.ndarray, np.ndarray, Car, Ground]:
    """Ordinary run-outs: friction 0.3 to 0.9, up to 15 m/s and 10 rad/s, an edge on the way."""
    rng = np.random.default_rng(seed)
    car = Car(
        rng.uniform(1.3, 2.3), rng.uniform(1.1, 1.5), rng.uniform(1.1, 1.5), rng.uniform(1.4, 1.6)
    )
    way = rng.uniform(-math.pi, math.pi)
    v = rng.uniform(3, 15)
    inward = way + rng.uniform(-1.2, 1.2)
    point = rng.uniform(1, 6) * np.array([math.cos(way), math.sin(way)])
    ground = with_edge(
        rng.uniform(0.3, 0.9),
        rng.uniform(0.3, 0.9),
        tuple(point),
        (math.cos(inward), math.sin(inward)),
        c=rng.uniform(0, 0.01),
    )
    velocity = np.array([v * math.cos(way), v * math.sin(way), rng.uniform(-10, 10)])
    return np.array([0.0, 0.0, rng.uniform(-3, 3)]), velocity, car, ground


def by_reference(
    pose: np.ndarray, velocity: np.ndarray, car: Car, ground: Ground
) -> reference.Scene:
    """The same for `tests.shared.reference`, which writes the motion down a second time."""
    surfaces = (*map(np.array, ground[:2]), *(np.array(a[0]) for a in ground.zones))
    turning = () if car.wheels is None else map(np.array, car.wheels)
    return reference.Scene(pose, velocity, *car[:4], *surfaces, *turning)


def test_both_right_hand_sides_of_the_reference_agree() -> None:
    rng = np.random.default_rng(3)
    for scene in (*reference.scenes(20), *reference.rolling_scenes(20)):
        for y in rng.normal(size=(5, 6)) * [5, 5, 3, 8, 8, 5]:
            one_by_one = reference.by_wheel(scene)(*y.tolist())
            np.testing.assert_allclose(one_by_one, reference.slope(y, scene), atol=1e-12)


def test_rest_pose_agrees_with_scipy() -> None:
    """Against an independent right-hand side: all within a hundredth of a millimetre by default.

    With 96 fixed steps half are within 3 mm, all within 15 cm; the worst are scenes whose wheels are
    the instant centre again and again.
    """
    adaptive, fixed, finer = [], [], []
    for seed in range(40):
        scene = random_scene(seed)
        expected = reference.run(by_reference(*scene)).rest
        for errors, steps in ((adaptive, None), (fixed, 96), (finer, 768)):
            errors.append(np.abs(np.array(_rest(*scene, steps=steps)) - expected)[:2].max())
    assert np.max(adaptive) < 1e-5
    assert np.median(fixed) < 3e-3
    assert np.max(fixed) < 0.15
    assert np.max(finer) < 5e-3  # the error is the step's, not the model's


def test_steps_may_be_an_argument_of_one_program() -> None:
    traces, scene = [], jax.tree.map(np.asarray, random_scene(0))

    @jax.jit
    def in_steps(steps: Steps) -> jax.Array:
        traces.append(steps)
        return rest(*scene, steps=steps)

    for count in (1, 96, 768):  # the latter are compiled for other tests too
        expected = _rest(*scene, steps=count)
        np.testing.assert_allclose(in_steps(fixed_steps(count)), expected, rtol=1e-12, atol=1e-12)
    assert len(traces) == 1
    with pytest.raises(ValueError, match="1 to 3072"):
        fixed_steps(4000)


def cars_that_roll(count: int) -> tuple[np.ndarray, np.ndarray, Car, Ground]:
    """From one wheel locked to none, on drags of 0.02 to 0.1, steered or not; a row for each."""
    rng = np.random.default_rng(3)
    drag = rng.uniform(0.02, 0.1, (count, 4))
    drag[np.arange(count) % 2 == 0, 0] = 1.0
    steer = rng.normal(0, 0.1, (count, 1)) * np.array([1.0, 1.0, 0.0, 0.0])
    pose = np.zeros((count, 3))
    velocity = np.stack([rng.uniform(3, 15, count), *rng.normal(0, 2, (2, count))], axis=1)
    same = [np.full(count, part) for part in (1.8, 1.3, 1.5, 1.5)]
    grounds = jax.tree.map(lambda a: np.broadcast_to(a, (count, *np.shape(a))), plain(0.7))
    return pose, velocity, Car(*same, Wheels(drag, steer)), grounds


@jax.jit
@partial(jax.vmap, in_axes=(None, 0, 0, 0, 0))
def paced(fineness: float, pose: jax.Array, velocity: jax.Array, car: Car, ground: Ground) -> tuple:
    """d(rest)/d(velocity) and the rest pose itself, by one program for both tests of it."""

    def end(V: jax.Array) -> tuple[jax.Array, jax.Array]:
        return (found := rest(pose, V, car, ground, Paced(fineness))), found

    return jax.jacfwd(end, has_aux=True)(velocity)


@pytest.mark.slow
def test_paced_steps_follow_cars_that_roll() -> None:
    """Against adaptive steps of order eight; fine ones are off by how the last motion is closed."""
    cars = cars_that_roll(16)
    exact = np.stack([_rest(*jax.tree.map(lambda a: a[i], cars)) for i in range(16)])  # noqa: B023

    def errors(fineness: float) -> np.ndarray:
        return np.hypot(*(np.asarray(paced(fineness, *cars)[1]) - exact)[:, :2].T)

    coarse, fine = errors(1.0), errors(4.0)
    assert np.median(coarse) < 5e-3
    assert np.max(coarse) < 0.1
    assert np.median(fine) < 1e-4
    assert np.max(fine) < 2e-3


@pytest.mark.slow
def test_jacobians_of_paced_steps_do_not_blow_up() -> None:
    """Uniform steps in W beyond a tyre's stability limit had them wrong by up to 1e11."""
    cars = cars_that_roll(16)
    coarse, fine = (np.asarray(paced(fineness, *cars)[0]) for fineness in (1.0, 4.0))
    off = np.abs(coarse - fine).max(axis=(1, 2)) / np.abs(fine).max(axis=(1, 2))
    assert np.median(off) < 0.01
    assert np.max(off) < 0.2


def test_gradient_agrees_with_complex_steps_of_scipy() -> None:
    for seed in range(6):
        pose, velocity, car, ground = scene = random_scene(seed)
        found = np.concatenate(slopes(*scene), axis=1)
        truth = reference.jacobian(by_reference(pose, velocity, car, ground))
        np.testing.assert_allclose(found, truth, atol=1e-4 * np.abs(truth).max())


def slopes(pose: np.ndarray, velocity: np.ndarray, car: Car, ground: Ground) -> tuple:
    """d(rest)/d(pose) and d(rest)/d(velocity), by one program for all tests."""
    return _slopes(*jax.tree.map(lambda a: np.asarray(a, float), (pose, velocity, car, ground)))


@pytest.mark.parametrize("velocity", [[12.0, 1.0, 8.0], [0.0, 0.0, 15.0], [20.0, -3.0, 0.0]])
def test_ice(velocity: list[float]) -> None:
    """Friction 0.05, up to dozens of turns over hundreds of metres, and an edge to ice at 0.07."""
    pose, ground = np.array([0.0, 0.0, 0.3]), with_edge(0.05, 0.07, (9.0, 0.0), (1.0, 0.0))
    scene = (pose, np.array(velocity), CAR, ground)
    expected = reference.run(by_reference(*scene)).rest
    np.testing.assert_allclose(_rest(*scene), expected, atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [None, 96])
def test_single_precision_is_computed_in_double(steps: int | None) -> None:
    """Within a micrometre for each metre and radian: what rounding of the inputs does."""
    for seed in range(5):
        scene = random_scene(seed)
        single = jax.tree.map(lambda a: jnp.asarray(a, jnp.float32), scene)
        found, expected = _compiled(*single, steps=steps), np.array(_rest(*scene, steps=steps))
        assert found.dtype == jnp.float64
        np.testing.assert_allclose(found, expected, atol=2e-6 * (1 + np.abs(expected).max()))


motion = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-10, 10))
drags = st.tuples(*[st.floats(0.05, 1) | st.just(1.0)] * 4)  # 1: locked
steers = st.tuples(*[st.floats(-0.5, 0.5)] * 4)
point = st.tuples(st.floats(-10, 10), st.floats(-10, 10))
angle = st.floats(-3, 3)


@given(motion, drags, steers, st.floats(0.1, 1.0), st.floats(0.1, 1.0), st.floats(0, 0.02))
# a locked wheel that the car turns about while the others hold little: 8422 steps
@example(
    (0.5, 2.0, 0.0), (1.0, 0.0625, 0.0625, 0.0625), (0.0, -0.25, 0.5, 0.0), 0.1015625, 1.0, 0.0
)
# slow wheels that hold nearly nothing to the side: from 5 mm/s to 1e-5 of it in over 100 000 steps
@example(
    (0.0033198913, -0.0048678217, -0.0033540112),
    (0.0625, 0.76448080, 0.05, 0.05),
    (0.25,) * 4,
    0.5064665,
    0.96236186,
    0.01,
)
@example((0.0, 0.0, 0.0), (0.398, 0.904, 0.5825, 0.418), (0.25, 0.0, 0.41, 0.0), 0.1, 0.849, 0.02)
def test_friction_never_adds_energy_and_time_goes_on(
    velocity: tuple, drag: tuple, steer: tuple, f: float, beyond: float, c: float
) -> None:
    ground, car = with_edge(f, beyond, (2.0, 0.0), (1.0, 0.0), c), rolling(drag, steer)
    path = _run_out(np.zeros(3), np.array(velocity), car, ground)
    energy = np.array(path.velocity**2 @ np.array([1.0, 1.0, CAR.k2]))
    assert np.isfinite(np.array(path.pose)).all()
    assert (np.diff(energy) <= 1e-9 * energy[0]).all()
    assert (np.diff(np.array(path.time)) >= 0).all()
    # from where it is closed: 1e-5 of its speed, or 0.1 mm/s
    assert np.sqrt(energy[-2]) <= 1.01 * max(1e-5 * np.sqrt(energy[0]), 1e-4)


@pytest.mark.slow
@thousand
@given(motion, drags, steers, point, angle, angle, st.booleans())
def test_turning_or_mirroring_the_scene_does_so_to_the_run_out(
    velocity: tuple, drag: tuple, steer: tuple, edge: tuple, inward: float, turn: float, flip: bool
) -> None:
    """Across an edge, with wheels of all kinds; a mirror changes left for right."""
    c, s = math.cos(turn), math.sin(turn)
    side = -1.0 if flip else 1.0
    R = np.array([[c, -s], [s, c]]) @ np.diag([1.0, side])
    normal = np.array([math.cos(inward), math.sin(inward)])
    V = np.array(velocity)
    here = np.array(
        _rest(np.zeros(3), V, rolling(drag, steer), with_edge(0.7, 0.4, edge, tuple(normal)))
    )
    order = [1, 0, 3, 2] if flip else [0, 1, 2, 3]
    car = rolling(np.array(drag)[order], side * np.array(steer)[order])
    ground = with_edge(0.7, 0.4, tuple(R @ edge), tuple(R @ normal))
    moved = np.array([*(R @ V[:2]), side * V[2]])
    there = np.array(_rest(np.array([0, 0, turn]), moved, car, ground))
    expected = [*(R @ here[:2]), side * here[2] + turn]
    np.testing.assert_allclose(there, expected, atol=1e-6 * (1 + np.abs(here).max()))


@pytest.mark.slow
@thousand
@given(motion, st.floats(0.1, 1.0), st.floats(1.5, 4.0))
def test_friction_times_lambda_is_speed_times_its_root(
    velocity: tuple, f: float, factor: float
) -> None:
    """With one constant friction the rest pose depends on v / sqrt(f) alone."""
    V, still = np.array(velocity), np.zeros(3)
    slow = np.array(_rest(still, V, CAR, plain(f / factor), steps=96))
    fast = np.array(_rest(still, V * math.sqrt(factor), CAR, plain(f), steps=96))
    np.testing.assert_allclose(slow, fast, atol=1e-6 * (1 + np.abs(slow).max()))


@pytest.mark.slow
@thousand
@given(st.floats(0.1, 30), angle, angle, st.floats(0.05, 1.0), st.floats(0.1, 10))
def test_without_spin_the_distance_goes_as_the_square_of_speed(
    v: float, way: float, heading: float, f: float, factor: float
) -> None:
    V, pose = v * np.array([math.cos(way), math.sin(way), 0]), np.array([0, 0, heading])
    once, more = (np.array(_rest(pose, V * by, CAR, plain(f))) for by in (1.0, factor))
    np.testing.assert_allclose(more[:2], factor**2 * once[:2], atol=1e-6 * np.abs(more).max())
    assert more[2] == pytest.approx(heading, abs=1e-9)


@pytest.mark.slow
def test_a_standing_vehicle_stays_with_finite_derivatives() -> None:
    still, ground = np.array([1.0, 2.0, 0.5]), with_edge(0.5, 0.5, (9.0, 0.0), (1.0, 0.0))
    for steps in (None, 96):
        end = _rest(still, np.zeros(3), CAR, ground, steps=steps)
        np.testing.assert_allclose(end, still, atol=1e-6)
    assert np.isfinite(np.concatenate(slopes(still, np.zeros(3), CAR, ground))).all()
    forward = jax.jacfwd(lambda v: rest(jnp.array(still), v, CAR, ground, 96))
    assert np.isfinite(forward(jnp.zeros(3))).all()


def test_derivatives_without_spin_and_without_translation() -> None:
    """Closed forms: d(v² / 2 f g)/dv = v / f g, and likewise for the angle."""
    car = Car(k2=1.7, front_axle=1.4, rear_axle=1.4, track=1.5)
    r, ground = math.hypot(1.4, 0.75), with_edge(0.6, 0.6, (99.0, 0.0), (1.0, 0.0))
    _, slid = slopes(np.zeros(3), np.array([12.0, 0, 0]), car, ground)
    assert float(slid[0, 0]) == pytest.approx(12 / (0.6 * GRAVITY), rel=1e-6)
    _, spun = slopes(np.zeros(3), np.array([0, 0, 8.0]), car, ground)
    torque = 0.6 * GRAVITY * r**2 / math.hypot(r, PATCH)
    assert float(spun[2, 2]) == pytest.approx(1.7 * 8 / torque, rel=1e-6)
    assert np.isfinite(slid).all()
    assert np.isfinite(spun).all()


@pytest.mark.slow
def test_wheel_paths_are_those_of_a_rigid_body() -> None:
    pose, velocity, car, ground = random_scene(7)
    path = _run_out(jnp.array(pose), jnp.array(velocity), car, ground)
    np.testing.assert_allclose(
        path.pose[-1], _rest(jnp.array(pose), jnp.array(velocity), car, ground), atol=1e-5
    )
    wheels = np.array(wheel_paths(path.pose, car))
    assert wheels.shape == (len(path.pose), 4, 2)
    a, b = car.front_axle, car.rear_axle
    along = (wheels[:, 0] + wheels[:, 1] - wheels[:, 2] - wheels[:, 3]) / 2 / (a + b)
    np.testing.assert_allclose(along[:, 0], np.cos(path.pose[:, 2]), atol=1e-12)
    np.testing.assert_allclose(along[:, 1], np.sin(path.pose[:, 2]), atol=1e-12)
    np.testing.assert_allclose(np.hypot(*(wheels[:, 0] - wheels[:, 1]).T), car.track)
    weight = np.array([b, b, a, a]) / (a + b) / 2
    np.testing.assert_allclose(weight @ wheels, path.pose[:, :2], atol=1e-12)


@pytest.mark.slow
def test_what_cannot_be_followed_is_not_a_number() -> None:
    """A wheel that rolls freely takes nothing from W: the clock stands still."""
    free = rolling([0.0] * 4, [0.0] * 4)
    assert np.isnan(np.array(_rest(jnp.zeros(3), jnp.array([10.0, 0, 0]), free, plain(0.7)))).all()


def test_an_edge_nobody_reaches_changes_nothing_and_one_behind_is_all_there_is() -> None:
    v = jnp.array([6.0, 1.0, 2.0])
    far = _rest(jnp.zeros(3), v, CAR, with_edge(0.6, 0.2, (500.0, 0.0), (1.0, 0.0)))
    np.testing.assert_allclose(np.array(far), np.array(_rest(jnp.zeros(3), v, CAR, plain(0.6))))
    behind = _rest(jnp.zeros(3), v, CAR, with_edge(0.6, 0.2, (-500.0, 0.0), (1.0, 0.0)))
    np.testing.assert_allclose(np.array(behind), np.array(_rest(jnp.zeros(3), v, CAR, plain(0.2))))


def wheels(drag: Sequence[float], steer: Sequence[float]) -> Wheels:
    return Wheels(np.array(drag), np.array(steer))


def rolling(drag: Sequence[float], steer: Sequence[float]) -> Car:
    return CAR._replace(wheels=wheels(drag, steer))


def test_wheels_that_are_all_locked_change_nothing() -> None:
    start, velocity, ground = jnp.zeros(3), jnp.array([9.0, 4.0, 5.0]), plain(0.6, 0.01)
    locked = rolling([1.0] * 4, [0.3, 0.3, 0.0, 0.0])
    np.testing.assert_allclose(
        np.array(_rest(start, velocity, locked, ground)),
        np.array(_rest(start, velocity, CAR, ground)),
        atol=1e-9,
    )


def test_a_rolling_car_stops_by_its_drag() -> None:
    """Closed form: straight ahead only drag brakes, over v² / (2 drag f g)."""
    car = rolling([0.1, 0.1, 0.3, 0.3], [0.0] * 4)
    end = np.array(_rest(jnp.zeros(3), jnp.array([12.0, 0.0, 0.0]), car, plain(0.7)))
    a, b = CAR.front_axle, CAR.rear_axle
    drag = (0.1 * b + 0.3 * a) / (a + b)  # weighted by the axles' loads
    far = 12.0**2 / (2 * drag * 0.7 * GRAVITY)
    np.testing.assert_allclose(end, [far, 0, 0], atol=1e-6 * far)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("drag", "steer", "velocity"),
    [
        ([0.5, 0.5, 0.5, 0.5], [0.0, 0.0, 0.0, 0.0], [12.0, 3.0, 2.0]),
        ([1.0, 0.15, 0.15, 0.15], [0.2, 0.0, 0.0, 0.0], [9.0, -4.0, 6.0]),
        ([0.1, 0.1, 0.1, 0.1], [0.1, 0.1, 0.0, 0.0], [14.0, 1.0, 0.5]),
        ([0.2, 1.0, 0.3, 0.1], [-0.1, 0.15, 0.0, 0.0], [-5.0, 7.0, -4.0]),
    ],
)
def test_rolling_and_braked_wheels_agree_with_scipy(
    drag: list[float], steer: list[float], velocity: list[float]
) -> None:
    pose, ground = np.array([0.0, 0.0, 0.2]), with_edge(0.7, 0.5, (0.0, 4.0), (0.0, 1.0), 0.005)
    scene = (pose, np.array(velocity), rolling(drag, steer), ground)
    expected = by_scipy(*scene)
    np.testing.assert_allclose(_rest(*scene), expected, atol=2e-5)
    np.testing.assert_allclose(_rest(*scene, steps=1500), expected, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("drag", [[1.0] * 4, [1.0, 0.15, 0.15, 0.15]])
def test_load_transfer_agrees_with_scipy(drag: list[float]) -> None:
    car = rolling(drag, [0.1, 0.1, 0.0, 0.0])
    pose, velocity = np.array([0.0, 0.0, 0.2]), np.array([12.0, 3.0, 4.0])
    ground = with_edge(0.8, 0.5, (0.0, 4.0), (0.0, 1.0), 0.005)
    end = np.array(_rest(pose, velocity, car._replace(height=0.55), ground))
    expected = by_scipy(pose, velocity, car._replace(height=0.55), ground)
    np.testing.assert_allclose(end, expected, atol=2e-5)
    assert np.abs(end - _rest(pose, velocity, car, ground)).max() > 0.05  # it matters


def test_a_polygon_is_crossed_as_its_edges_are() -> None:
    """A strip of ice on the way: as a polygon, and as two half-planes."""
    start, velocity = jnp.array([0.0, 0.0, 0.3]), jnp.array([11.0, 1.0, 3.0])
    far = 500.0
    strip = np.array([[5.0, -far], [9.0, -far], [9.0, far], [5.0, far]])
    none = Zone(jnp.zeros((0, 2)), jnp.zeros((0, 2)))
    as_polygon = Ground(jnp.array([0.7, 0.1]), None, none, (strip,))
    edges = Zone(jnp.array([[5.0, 0], [9.0, 0]]), jnp.array([[1.0, 0], [1.0, 0]]))
    as_edges = Ground(jnp.array([0.7, 0.1, 0.7]), None, edges)
    found = (np.array(_rest(start, velocity, CAR, g, steps=400)) for g in (as_polygon, as_edges))
    np.testing.assert_allclose(*found, atol=1e-9)


@given(
    drag=st.floats(0, 1),
    steer=st.floats(-0.6, 0.6),
    slip=st.tuples(st.floats(-20, 20), st.floats(-20, 20)),
)
def test_a_tyre_stays_within_the_friction_ellipse_and_never_pushes(
    drag: float, steer: float, slip: tuple[float, float]
) -> None:
    slips = np.repeat(np.array(slip)[:, None], 4, axis=1)
    of_wheels = wheels([drag] * 4, [steer] * 4)
    acts = np.array(_force(slips, 1e-12, of_wheels))
    assert np.hypot(*acts).max() <= 1 + 1e-9
    assert (acts * slips).sum(axis=0).max() <= 1e-9
