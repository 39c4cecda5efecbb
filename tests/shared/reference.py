"""Random run-outs and where they end, by other means than retrodict's: NumPy and SciPy, in time.

The equations of motion are written a second time here, and integrated over time by DOP853 at a
tolerance of 1e-12 until a millionth of the motion is left: once for arrays (`slope`), and once more
for single numbers (`by_wheel`), because hundreds of scenes at this tolerance take long.
"""

from __future__ import annotations

import cmath
import math
import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.80665  # m/s²
PATCH = 0.08  # m, radius of gyration of a contact patch: smooths friction as retrodict does
TYRE_WIDTH = 0.2  # m: friction passes over an edge in it
TINY = 1e-18  # m²/s²
SLIP, SLOW = 0.1, 2.0  # of a rolling tyre: slope at which friction is all but reached; m/s
ICE, DRY = 0.05, 0.9  # friction, from least to most
DRAG, STEER = (0.05, 0.3), 0.3  # of wheels that roll; of front wheels, rad, to either side
IMAGINARY = 1e-8  # step of the complex derivative: m, rad, m/s, rad/s; its error is of order 1e-16

Array = np.ndarray[Any, np.dtype[Any]]


class Scene(NamedTuple):
    """A vehicle that starts to skid, the ground and one edge to a second surface."""

    pose: Array  # x, y, heading
    velocity: Array  # Vx, Vy, Omega
    k2: float
    front_axle: float
    rear_axle: float
    track: float
    coefficients: Array  # of the two surfaces
    speed_dependence: Array  # s/m
    point: Array  # of the edge
    inward: Array  # its normal, into the second surface
    drag: Array | None = None  # of each wheel, braking force over friction; None: all are locked
    steer: Array | None = None  # of each wheel from the heading, rad


CAR = Scene(
    pose=np.zeros(3),
    velocity=np.zeros(3),
    k2=1.8,
    front_axle=1.3,
    rear_axle=1.5,
    track=1.5,
    coefficients=np.array([0.7, 0.35]),
    speed_dependence=np.zeros(2),
    point=np.array([500.0, 0.0]),
    inward=np.array([1.0, 0.0]),
)


class Run(NamedTuple):
    """Where a run-out ends, and what kind it was."""

    rest: Array
    evaluations: int  # of the right-hand side
    length: float  # of the centre of gravity's path, m
    crossings: int  # wheels that changed surface at least once
    edge_distance: float  # of the wheel nearest to the edge at rest, m


def scenes(number: int, seed: int = 0) -> list[Scene]:
    """Random scenes, about half of which cross the edge."""
    return [_scene(rng) for rng in [np.random.default_rng(seed)] for _ in range(number)]


def rolling_scenes(number: int, seed: int = 1) -> list[Scene]:
    """Random scenes whose wheels roll with some drag, a quarter of them locked."""
    rng = np.random.default_rng(seed)
    found = []
    for scene in scenes(number, seed):
        drag = np.where(rng.random(4) < 0.25, 1.0, rng.uniform(*DRAG, 4))
        front = np.array([1.0, 1.0, 0.0, 0.0]) * rng.uniform(-STEER, STEER)
        found.append(scene._replace(drag=drag, steer=front))
    return found


def _scene(rng: np.random.Generator) -> Scene:
    front, rear, track = rng.uniform(1.0, 1.5), rng.uniform(1.1, 1.7), rng.uniform(1.3, 1.7)
    speed, course = rng.uniform(1.0, 20.0), rng.uniform(-np.pi, np.pi)
    first = np.exp(rng.uniform(np.log(ICE), np.log(DRY)))
    second = np.clip(first * rng.uniform(0.5, 1.3), ICE, DRY)
    normal = rng.uniform(-np.pi, np.pi)
    inward = np.array([np.cos(normal), np.sin(normal)])
    return Scene(
        pose=np.array([0.0, 0.0, rng.uniform(-3.0, 3.0)]),
        velocity=np.array(
            [speed * np.cos(course), speed * np.sin(course), rng.uniform(-15.0, 15.0)]
        ),
        k2=rng.uniform(0.85, 1.25) * front * rear,
        front_axle=front,
        rear_axle=rear,
        track=track,
        coefficients=np.array([first, second]),
        speed_dependence=rng.uniform(0.0, 0.02, 2) * (rng.random() < 0.7),
        point=rng.uniform(0.0, 12.0) * inward,
        inward=inward,
    )


def wheels(y: Array, scene: Scene) -> tuple[Array, Array]:
    """Wheels from the centre of gravity, in the ground's axes; y may have leading axes."""
    wheel_x = np.array([scene.front_axle, scene.front_axle, -scene.rear_axle, -scene.rear_axle])
    wheel_y = np.array([0.5, -0.5, 0.5, -0.5]) * scene.track
    c, s = np.cos(y[..., 2:3]), np.sin(y[..., 2:3])
    return c * wheel_x - s * wheel_y, s * wheel_x + c * wheel_y


def depth(y: Array, scene: Scene) -> Array:
    """How far each wheel is beyond the edge, m."""
    arm_x, arm_y = wheels(y, scene)
    x, y_ = y[..., 0:1] + arm_x - scene.point[0], y[..., 1:2] + arm_y - scene.point[1]
    return x * scene.inward[0] + y_ * scene.inward[1]


def slope(y: Array, scene: Scene) -> Array:
    """d(x, y, heading, Vx, Vy, Omega)/dt of one state or many: what one would write first."""
    base = scene.front_axle + scene.rear_axle
    share = np.array([scene.rear_axle, scene.rear_axle, scene.front_axle, scene.front_axle])
    load = GRAVITY * share / base / 2
    arm_x, arm_y = wheels(y, scene)
    spin = y[..., 5:6]
    slip_x, slip_y = y[..., 3:4] - spin * arm_y, y[..., 4:5] + spin * arm_x
    slip = np.sqrt(slip_x**2 + slip_y**2 + (PATCH * spin) ** 2 + TINY)
    first, second = (
        scene.coefficients[i] * np.exp(-scene.speed_dependence[i] * slip) for i in (0, 1)
    )
    u = depth(y, scene) / TYRE_WIDTH + 0.5
    u = np.clip(u, 0.0, 1.0)
    force = (first + u * u * (3 - 2 * u) * (second - first)) * load
    if scene.drag is None:
        force_x, force_y = -force / slip * slip_x, -force / slip * slip_y
    else:
        force_x, force_y = force * rolling(y, slip_x, slip_y, slip, scene)
    moment = arm_x * force_y - arm_y * force_x
    out = np.empty_like(y)
    out[..., :3] = y[..., 3:]
    out[..., 3], out[..., 4] = force_x.sum(-1), force_y.sum(-1)
    out[..., 5] = moment.sum(-1) / scene.k2
    return out


def rolling(y: Array, slip_x: Array, slip_y: Array, slip: Array, scene: Scene) -> Array:
    """Force of wheels that roll over friction times load, in the ground's axes.

    Along a wheel its drag brakes; across, the slip angle takes up a share of what the friction
    ellipse leaves. A locked wheel has no angle to roll at, and the share is that of its slip.
    """
    assert scene.drag is not None
    assert scene.steer is not None
    points = y[..., 2:3] + scene.steer
    c, s = np.cos(points), np.sin(points)
    along, across = c * slip_x + s * slip_y, c * slip_y - s * slip_x
    brake = scene.drag * along / slip
    patch = (PATCH * y[..., 5:6]) ** 2 + TINY
    free = 1 - scene.drag**2
    left_over = np.sqrt(across**2 + patch + free * along**2) / slip  # sqrt(1 - brake²), exactly
    needed = SLIP * np.sqrt(free * (along**2 + SLOW**2))  # of the speed across
    share = across / np.sqrt(across**2 + patch + needed**2)
    side = left_over * share
    return np.stack([side * s - brake * c, -side * c - brake * s])


def by_wheel(scene: Scene, of: Any = math) -> Callable[..., tuple[Any, ...]]:
    """`slope` of one state, a wheel after the other in Python's numbers: several times as fast.

    Args:
        scene: of the run-out.
        of: `math`, or `cmath` for complex steps.

    Returns:
        A function of x, y, heading, Vx, Vy, Omega.
    """
    front, rear, half = scene.front_axle, scene.rear_axle, scene.track / 2
    load = GRAVITY / (front + rear) / 2
    places = [(front, half), (front, -half), (-rear, half), (-rear, -half)]
    loads = [load * rear, load * rear, load * front, load * front]
    drag = [1.0] * 4 if scene.drag is None else scene.drag.tolist()
    steer = [0.0] * 4 if scene.steer is None else scene.steer.tolist()
    all_wheels = list(zip(places, loads, drag, steer, strict=True))
    (f, f_beyond), (c, c_beyond) = scene.coefficients.tolist(), scene.speed_dependence.tolist()
    (edge_x, edge_y), (in_x, in_y) = scene.point.tolist(), scene.inward.tolist()
    sqrt, exp, cos, sin = of.sqrt, of.exp, of.cos, of.sin

    def rate(x: Any, y: Any, heading: Any, Vx: Any, Vy: Any, spin: Any) -> tuple[Any, ...]:
        cosine, sine = cos(heading), sin(heading)
        patch = (PATCH * spin) ** 2 + TINY
        A_x = A_y = moment = 0.0
        for (u, v), load, drag, steer in all_wheels:
            arm_x, arm_y = cosine * u - sine * v, sine * u + cosine * v
            slip_x, slip_y = Vx - spin * arm_y, Vy + spin * arm_x
            slip = sqrt(slip_x * slip_x + slip_y * slip_y + patch)
            grip = f * exp(-c * slip)
            beyond = ((x + arm_x - edge_x) * in_x + (y + arm_y - edge_y) * in_y) / TYRE_WIDTH + 0.5
            if beyond.real > 0:
                part = beyond * beyond * (3 - 2 * beyond) if beyond.real < 1 else 1.0
                grip += part * (f_beyond * exp(-c_beyond * slip) - grip)
            if drag == 1.0:
                a_x, a_y = -grip * load / slip * slip_x, -grip * load / slip * slip_y
            else:
                to_x, to_y = cos(heading + steer), sin(heading + steer)
                along, across = to_x * slip_x + to_y * slip_y, to_x * slip_y - to_y * slip_x
                free, side2 = 1 - drag * drag, across * across + patch
                needed2 = SLIP * SLIP * free * (along * along + SLOW * SLOW)
                brake = grip * load / slip * drag * along
                side = grip * load / slip * across
                side *= sqrt((side2 + free * along * along) / (side2 + needed2))
                a_x, a_y = side * to_y - brake * to_x, -side * to_x - brake * to_y
            A_x, A_y = A_x + a_x, A_y + a_y
            moment += arm_x * a_y - arm_y * a_x
        return Vx, Vy, spin, A_x, A_y, moment / scene.k2

    return rate


def generalised_speed(y: Array, scene: Scene) -> Array:
    """W, m/s."""
    return np.sqrt(y[..., 3] ** 2 + y[..., 4] ** 2 + scene.k2 * y[..., 5] ** 2)


def solve(
    scene: Scene,
    method: str = "DOP853",
    rtol: float = 1e-12,
    last: float = 1e-6,
    first_written: bool = False,
) -> tuple[Array, Array, int]:
    """The rest pose, the states before it, and how often the right-hand side was asked.

    Args:
        scene: of the run-out.
        method: of `solve_ivp`.
        rtol: relative tolerance; the absolute one is a tenth of it, in units of W.
        last: share of W at which the solver stops; the rest follows in closed form.
        first_written: whether the right-hand side is `slope`, and not the faster `by_wheel`.
    """
    start = np.concatenate([scene.pose, scene.velocity])
    rate = by_wheel(scene)
    field = (lambda y: slope(y, scene)) if first_written else (lambda y: rate(*y.tolist()))
    end, states, evaluations = _integrate(start[None], scene, field, method, rtol, last)
    return end[0], states[0], evaluations


def jacobian(scene: Scene) -> Array:
    """d(rest)/d(start pose, start velocity), shape (3, 6), by complex steps, all in one run."""
    start = np.concatenate([scene.pose, scene.velocity]) + 1j * IMAGINARY * np.eye(6)
    rate = by_wheel(scene, cmath)

    def field(flat: Array) -> list[complex]:
        y = flat.tolist()
        return [k for i in range(0, 36, 6) for k in rate(*y[i : i + 6])]

    end, _, _ = _integrate(start, scene, field, "DOP853", 1e-12, 1e-6)
    return end.imag.T / IMAGINARY


def _integrate(
    start: Array,
    scene: Scene,
    field: Callable[[Array], Sequence[Any] | Array],
    method: str,
    rtol: float,
    last: float,
) -> tuple[Array, Array, int]:
    """All rows of `start` together, to where the first has `last` of its W left, then to rest."""
    shape = start.shape
    W_0 = float(generalised_speed(start[0].real, scene))

    def stops(_: float, flat: Array) -> float:
        return float(generalised_speed(flat[:6].real, scene)) / W_0 - last

    stops.terminal = True  # type: ignore[attr-defined]
    solution = solve_ivp(
        lambda _, flat: field(flat),
        (0.0, 1e4),
        start.ravel(),
        method=method,
        rtol=rtol,
        atol=0.1 * rtol * W_0,
        events=stops,
    )
    states = np.moveaxis(solution.y.reshape(*shape, -1), -1, 1)
    y = states[:, -1]
    W = generalised_speed(y, scene)
    motion, rate = y[:, 3:], np.reshape(field(y.ravel()), shape)[:, 3:]
    dW_dt = (motion * rate * np.array([1.0, 1.0, scene.k2])).sum(-1) / W
    return y[:, :3] - motion * (W / dW_dt)[:, None] / 2, states, solution.nfev


def run(scene: Scene) -> Run:
    """The reference's run-out of a scene."""
    rest, states, evaluations = solve(scene)
    beyond = depth(states, scene) > 0
    return Run(
        rest,
        evaluations,
        float(np.hypot(*np.diff(states[:, :2], axis=0).T).sum()),
        int((beyond.any(0) & ~beyond.all(0)).sum()),
        float(np.abs(depth(rest, scene)).min()),
    )


def runs(of: Sequence[Scene]) -> list[Run]:
    """The reference's run-outs, on all cores."""
    return _on_all_cores(run, of)


def jacobians(of: Sequence[Scene]) -> Array:
    """Their derivatives, likewise."""
    return np.array(_on_all_cores(jacobian, of))


def _on_all_cores[R](function: Callable[[Scene], R], of: Sequence[Scene]) -> list[R]:
    """The function of each scene, on all cores."""
    context = multiprocessing.get_context("spawn")  # JAX has threads that a fork would break
    with ProcessPoolExecutor(mp_context=context) as pool:
        return list(pool.map(function, of, chunksize=5))
