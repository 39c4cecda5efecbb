"""Crashes of two cars with and without a second contact, by SciPy: impulses and locked wheels.

Nothing of the package's mechanics is used. An impact is an impulse at a point, with restitution along
the normal and Coulomb friction; between impacts each car slides on four locked wheels.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.80665
_LOOKS = 0.005  # s between looks at the outlines
_TOUCH = 0.02  # m², area of an overlap at which the structure pushes back
_PARTED = 1e-4  # m²
_CLOSING = 0.3  # m/s: slower contacts are not distinguished from none, nor counted
_SMOOTH = 0.05  # m/s below which friction of a wheel fades
_STOPPED = 0.06  # m/s and rad/s
_MOST = 8  # impacts of a crash

Array = np.ndarray


@dataclass(frozen=True)
class Car:
    """A car: kg, kg m², m."""

    mass: float
    inertia: float
    front: float
    rear: float
    track: float
    length: float
    width: float

    @property
    def ahead(self) -> float:
        """How far the middle of the outline is ahead of the centre of gravity, m."""
        return (self.front - self.rear) / 2


CARS = (
    Car(1600.0, 2850.0, 1.20, 1.50, 1.52, 4.60, 1.80),
    Car(1400.0, 2350.0, 1.15, 1.45, 1.48, 4.40, 1.75),
)


@dataclass(frozen=True)
class Crash:
    """A crash from impact to rest.

    Args:
        point: place of the first impulse, m.
        normal: direction of the first normal on A, rad.
        poses: poses x, y, heading of A and B at the impact, shape (2, 3).
        speeds: speeds of A and B before it, m/s.
        after: velocities after it, shape (2, 3).
        rests: rest poses, headings counted on from the impact, shape (2, 3).
        friction: friction of the road.
        slaps: times of the later impacts, s, and their closing speeds, m/s.
    """

    point: Array
    normal: float
    poses: Array
    speeds: tuple[float, float]
    after: Array
    rests: Array
    friction: float
    slaps: tuple[tuple[float, float], ...]


def crossing(rng: np.random.Generator) -> Crash | None:
    """A crossing in which A's right front corner strikes B's left side by the front wheel.

    Both turn fast, in opposite senses, and about half of these pairs strike each other again with their
    rear sides.

    Args:
        rng: random numbers.

    Returns:
        The crash; None where the cars do not close in, or do not come to rest.
    """
    headings = np.array([rng.normal(0.0, 0.1), rng.normal(rng.uniform(1.0, 1.9), 0.05)])
    of_a = rng.uniform(9, 17)
    speeds = of_a, of_a * rng.uniform(0.5, 1.1)
    along_b, aside_a = rng.uniform(0.8, 2.2), rng.uniform(-0.85, -0.4)
    crush = rng.uniform(0.15, 0.35)
    a, b = CARS
    point = np.zeros(2)
    levers = [
        _turned([a.ahead + a.length / 2 - crush / 2, aside_a], headings[0]),
        _turned([along_b, b.width / 2 - crush / 2], headings[1]),
    ]
    poses = np.array([[*(point - lever), h] for lever, h in zip(levers, headings, strict=True)])
    before = np.array(
        [[v * math.cos(h), v * math.sin(h), 0.0] for v, h in zip(speeds, headings, strict=True)]
    )
    normal = headings[1] + math.pi / 2  # out of B's left side
    e, mu = rng.uniform(0.0, 0.2), rng.uniform(0.4, 1.2)
    after, closing = impact(poses, before, point, normal, e, mu)
    if closing < 3.0:
        return None
    friction = rng.uniform(0.6, 0.8)
    run = _to_rest(poses, after, friction, rng)
    if run is None:
        return None
    rests, slaps = run
    return Crash(point, normal, poses, speeds, after, rests, friction, slaps)


def crashes(count: int, slapped: bool, seed: int) -> Iterator[Crash]:
    """Crossings with a clear second contact, or with none.

    Args:
        count: number of crashes.
        slapped: whether the cars touch again.
        seed: integer seed of the random numbers.
    """
    rng = np.random.default_rng(seed)
    while count:
        crash = crossing(rng)
        if crash is not None and bool(crash.slaps) == slapped:
            count -= 1
            yield crash


def impact(
    poses: Array, before: Array, point: Array, normal: float, e: float, mu: float
) -> tuple[Array, float]:
    """Velocities after an impulse with restitution e and friction mu at a point.

    Args:
        poses: poses of A and B, shape (2, 3).
        before: their velocities, shape (2, 3).
        point: where they touch, m.
        normal: direction in which A is pushed, rad.
        e: coefficient of restitution.
        mu: friction of the contact, by which sliding may end.

    Returns:
        Velocities after, and the closing speed along the normal, m/s.
    """
    n = np.array([math.cos(normal), math.sin(normal)])
    t = np.array([-n[1], n[0]])
    levers = point - poses[:, :2]

    def at_contact(velocity: Array) -> Array:
        places = [
            v[:2] + v[2] * np.array([-r[1], r[0]]) for v, r in zip(velocity, levers, strict=True)
        ]
        return places[0] - places[1]

    def per_impulse(P: Array) -> Array:
        """Change of both velocities by an impulse P on A and -P on B."""
        rows = []
        for car, r, sign in zip(CARS, levers, (1, -1), strict=True):
            turn = sign * (r[0] * P[1] - r[1] * P[0]) / car.inertia
            rows.append([*(sign * P / car.mass), turn])
        return np.array(rows)

    slip = at_contact(before)
    closing = -slip @ n
    if closing <= 0:
        return before, float(closing)
    # response of the contact's relative velocity to unit impulses along n and t
    C = np.array([[at_contact(per_impulse(d)) @ axis for d in (n, t)] for axis in (n, t)])
    wanted = np.array([(1 + e) * closing, -(slip @ t)])
    P_n, P_t = np.linalg.solve(C, wanted)  # sliding ends
    if abs(P_t) > mu * P_n or P_n <= 0:
        side = -math.copysign(mu, slip @ t)
        P_n = wanted[0] / (C[0, 0] + side * C[0, 1])
        P_t = side * P_n
    return before + per_impulse(P_n * n + P_t * t), float(closing)


def _to_rest(
    poses: Array, velocity: Array, friction: float, rng: np.random.Generator
) -> tuple[Array, tuple[tuple[float, float], ...]] | None:
    """Rest poses, and the later impacts; None where there are too many, or the cars never part."""
    slaps: list[tuple[float, float]] = []
    clock, parted = 0.0, False
    for _ in range(_MOST):
        run = _slide(poses, velocity, friction)
        times = np.arange(0.0, run.t[-1], _LOOKS)
        touching = None
        for time in times[1:]:
            state = run.sol(time).reshape(2, 6)
            area, centre, axis = overlap(state[:, :3])
            parted = parted or area < _PARTED
            if parted and area > _TOUCH:
                e, mu = rng.uniform(0.0, 0.2), rng.uniform(0.3, 0.6)
                after, closing = impact(state[:, :3], state[:, 3:], centre, axis, e, mu)
                if closing > _CLOSING:
                    touching = state[:, :3], after
                    slaps.append((clock + float(time), closing))
                    clock += float(time)
                    break
        if touching is None:
            if not (parted or slaps):
                return None  # the outlines go through each other: no crash
            return run.y[:, -1].reshape(2, 6)[:, :3], tuple(slaps)
        poses, velocity = touching
        parted = False
    return None


def _slide(poses: Array, velocity: Array, friction: float):  # type: ignore[no-untyped-def]
    """The motion of both cars on locked wheels until they stop."""

    def vector_field(_: float, y: Array) -> Array:
        state = y.reshape(2, 6)
        return np.concatenate(
            [
                np.concatenate([own[3:], _deceleration(car, own, friction)])
                for car, own in zip(CARS, state, strict=True)
            ]
        )

    def stops(_: float, y: Array) -> float:
        return float(np.abs(y.reshape(2, 6)[:, 3:]).max() - _STOPPED)

    stops.terminal = True  # type: ignore[attr-defined]
    start = np.concatenate([poses, velocity], axis=1).ravel()
    return solve_ivp(
        vector_field, (0, 30), start, events=stops, dense_output=True, rtol=1e-5, atol=1e-6
    )


def _deceleration(car: Car, state: Array, friction: float) -> Array:
    """Accelerations of a car on locked wheels with static loads."""
    heading, velocity, yaw_rate = state[2], state[3:5], state[5]
    base = car.front + car.rear
    force, moment = np.zeros(2), 0.0
    for along, share in ((car.front, car.rear / base), (-car.rear, car.front / base)):
        for aside in (car.track / 2, -car.track / 2):
            r = _turned([along, aside], heading)
            slip = velocity + yaw_rate * np.array([-r[1], r[0]])
            load = car.mass * GRAVITY * share / 2
            F = -friction * load * slip / math.sqrt(slip @ slip + _SMOOTH**2)
            force += F
            moment += r[0] * F[1] - r[1] * F[0]
    return np.array([*(force / car.mass), moment / car.inertia])


def overlap(poses: Array) -> tuple[float, Array, float]:
    """Overlap of both outlines: area, m², its centre, m, and the direction that pushes A out, rad."""
    outlines = [_corners(car, pose) for car, pose in zip(CARS, poses, strict=True)]
    both = _clipped(*outlines)
    if len(both) < 3:
        return 0.0, np.zeros(2), 0.0
    x, y = both.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2
    if area < 1e-9:
        return 0.0, np.zeros(2), 0.0
    centre = np.array([((c + np.roll(c, -1)) * cross).sum() / (6 * area) for c in (x, y)])
    # out of the side that is penetrated the least
    best = (math.inf, 0.0)
    for pose, (own, other), sign in (
        (poses[0], (outlines[0], outlines[1]), -1), (poses[1], (outlines[1], outlines[0]), 1)
    ):  # fmt: skip
        for quarter in range(4):
            angle = pose[2] + quarter * math.pi / 2
            axis = np.array([math.cos(angle), math.sin(angle)])
            depth = (own @ axis).max() - (other @ axis).min()
            # a normal out of A's side pushes A back, one out of B's pushes it on
            best = min(best, (depth, angle if sign > 0 else angle + math.pi))
    return float(area), centre, best[1]


def _corners(car: Car, pose: Array) -> Array:
    half, side = car.length / 2, car.width / 2
    own = [(half, side), (-half, side), (-half, -side), (half, -side)]
    return np.array([pose[:2] + _turned([car.ahead + x, y], pose[2]) for x, y in own])


def _clipped(polygon: Array, by: Array) -> Array:
    """The part of a convex polygon inside another, both counter-clockwise (Sutherland-Hodgman)."""
    points = list(polygon)
    for start, end in zip(by, np.roll(by, -1, axis=0), strict=True):
        way = end - start

        def left(p: Array, start: Array = start, way: Array = way) -> float:
            return float(way[0] * (p[1] - start[1]) - way[1] * (p[0] - start[0]))

        kept: list[Array] = []
        for i, p in enumerate(points):
            before = points[i - 1]
            one, two = left(before), left(p)
            if (one < 0) != (two < 0):
                kept.append(before + (p - before) * one / (one - two))
            if two >= 0:
                kept.append(p)
        points = kept
        if not points:
            break
    return np.array(points).reshape(-1, 2)


def _turned(place: list[float], angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * place[0] - s * place[1], s * place[0] + c * place[1]])


def scene_text(crash: Crash, rng: np.random.Generator) -> str:
    """The scene file that somebody writes who measured the crash and knows nothing of a second contact.

    Args:
        crash: the crash.
        rng: random numbers of the errors of measurement.
    """

    def off(value: float, sd: float) -> float:
        return value + sd * rng.standard_normal()

    lines = ["schema = 1", 'title = "Crossing"']
    for i, (car, v) in enumerate(zip(CARS, "AB", strict=True)):
        heading = crash.poses[i, 2]
        lever = crash.point - crash.poses[i, :2]
        angle = math.degrees(math.atan2(lever[1], lever[0]) - heading)
        rest, turned = crash.rests[i], math.degrees(crash.rests[i, 2] - heading)
        lines += [
            f"[vehicles.{v}]",
            f'mass = "{car.mass:.0f} ± {0.02 * car.mass:.0f} kg"',
            f'yaw_inertia = "{car.inertia:.0f} ± {0.05 * car.inertia:.0f} kg m^2"',
            f'cg_to_front_axle = "{car.front} m"',
            f'cg_to_rear_axle = "{car.rear} m"',
            f'track = "{car.track} m"',
            f'length = "{car.length} m"',
            f'width = "{car.width} m"',
            f'impact_centre = {{ distance = "{off(math.hypot(*lever), 0.05):.3f} ± 0.05 m", '
            f'angle = "{math.remainder(off(angle, 2.0), 360):.2f} ± 2 deg" }}',
            f'impact = {{ heading = "{off(math.degrees(heading), 2.0):.2f} ± 2 deg" }}',
            f'rest = {{ position = ["{off(rest[0], 0.1):.3f} ± 0.1 m", '
            f'"{off(rest[1], 0.1):.3f} ± 0.1 m"], '
            f'heading = "{math.remainder(off(math.degrees(rest[2]), 2.0), 360):.2f} ± 2 deg", '
            f'rotation = "{turned:.0f} deg" }}',
        ]
    gamma = math.degrees(crash.normal)  # the contact line is at right angles to the normal
    lines += [
        "[impact]",
        f'point = ["{off(crash.point[0], 0.1):.3f} ± 0.1 m", "{off(crash.point[1], 0.1):.3f} ± 0.1 m"]',
        f'contact_line = "{math.remainder(off(gamma, 4.0), 180):.2f} ± 4 deg"',
        "[surfaces.road]",
        f'friction = "{off(crash.friction, 0.03):.3f} ± 0.03"',
    ]
    return "\n".join(lines) + "\n"
