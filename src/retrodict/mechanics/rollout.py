"""Run-out along a measured path: speed from its length and drag factor, without integration.

V² = 2 g f L, f the mean of the drag factor over the path. After the impact the wheels slide sideways
and nearly all their friction decelerates the car; once its heading follows its course, only their drag
remains. The length of the first part therefore dominates; it follows from the rotation.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.constants import GRAVITY
from retrodict.mechanics.motion import PATCH, Car, Ground, Pose, Velocity, wheel_loads, wheel_places
from retrodict.mechanics.rotation import cos_sin
from retrodict.mechanics.surface import friction
from retrodict.mechanics.tyre import force

# Constants of the turning, found by `benchmarks/roll.py` against run-outs on wheels, from one locked to
# four rolling: the share of its friction that brakes a spinning car's yaw; its least drag factor while
# it turns, over friction; and the mean yaw rate over the initial one, were it to turn until it rests
# (0.5 if it slowed down evenly).
_YAW_BRAKING, _TURNING_DRAG, MEAN_YAW_RATE = 0.5, 0.6, 0.55
_POINTS = 12  # points of the sum, on the part where the vehicle turns and on the part after
_PASSES = 2  # passes of the sum, for the speeds along the path
_LEAST_SHARE = 0.02  # least share of the path on which the vehicle turns
_LEAST_DRAG = 0.02  # share of its wheels' drag straight ahead: smooths the mean drag factor near 0
_LEAST_TURN = 0.1  # rad: smooths the turning time where it hardly turns
_LEAST_SPEED2 = 0.01  # m²/s²
_TINY = 1e-18


class Way(NamedTuple):
    """Measured points of a vehicle's path after the impact, in order.

    Args:
        points: x and y of the centre of gravity, the last where the vehicle came to rest, m.
        heading: heading at each point, unwrapped, rad; NaN where unknown. The first known heading ends
            the turning; where none before rest is known, the share of the path with turning is computed.
    """

    points: Float[Array | np.ndarray, "points 2"]
    heading: Float[Array | np.ndarray, " points"]


class WayTaken(NamedTuple):
    """A measured path and the mean drag factor on it.

    Args:
        stations: shares of the path at its start and at each point, from 0 to 1.
        places: x and y of the stations from the start, m.
        length: length of the path, m.
        course: initial direction of travel, rad.
        share: share of the path on which the vehicle turns, from its start.
        turned: rotation on this share of the path, rad.
        turned_after: rotation on the remainder of the path, rad.
        drag: mean drag factor: mean deceleration over g.
    """

    stations: Float[Array, " stations"]
    places: Float[Array, "stations 2"]
    length: Float[Array, ""]
    course: Float[Array, ""]
    share: Float[Array, ""]
    turned: Float[Array, ""]
    turned_after: Float[Array, ""]
    drag: Float[Array, ""]


def drag_factor(
    place: Float[Array, "points 2"],
    course: Float[Array, " points"],
    heading: Float[Array, " points"],
    turning: Float[Array, " points"],
    speed: Float[Array, " points"],
    car: Car,
    ground: Ground,
) -> Float[Array, " points"]:
    """Deceleration along the course over g, at points of a path.

    The sum over the wheels of load share times friction times the tyre's force against the course.

    Args:
        place: x and y of the centre of gravity, m.
        course: direction of travel, rad.
        heading: heading of the vehicle, rad.
        turning: change of the heading along the path, rad/m.
        speed: speed of the centre of gravity, m/s.
        car: axles, track and wheels of the vehicle; loads are static.
        ground: friction of the surfaces and where they lie; taken as level.

    Source:
        The drag factor of reconstructionists, from wheels and crab angle: D. Struble, Automotive
        Accident Reconstruction (2nd edition, 2020), who averages it along the measured path.
    """
    u, v = wheel_places(car)
    crab = (course - heading)[:, None]
    c, s = cos_sin(heading)
    c, s = c[:, None], s[:, None]
    by_turning, speed = turning[:, None], speed[:, None]
    slip_u, slip_v = (
        speed * (jnp.cos(crab) - by_turning * v),
        speed * (jnp.sin(crab) + by_turning * u),
    )
    patch2 = (PATCH * by_turning * speed) ** 2 + _TINY
    slip = jnp.sqrt(slip_u**2 + slip_v**2 + patch2)
    x, y = place[:, :1] + c * u - s * v, place[:, 1:] + s * u + c * v
    grip = friction(x.ravel(), y.ravel(), slip.ravel(), *ground.surfaces).reshape(slip.shape)
    if car.wheels is None:
        along, across = -slip_u / slip, -slip_v / slip
    else:
        along, across = force(jnp.stack([slip_u, slip_v]), patch2, car.wheels)
    against = -(along * jnp.cos(crab) + across * jnp.sin(crab))
    return jnp.sum(wheel_loads(car) * grip * against, axis=1)


def way_taken(way: Way, start: Pose, car: Car, ground: Ground) -> WayTaken:
    """A measured path and the mean drag factor on it.

    The course is that of the straight lines between points, smoothed. The vehicle turns at a yaw rate
    that falls linearly, on the first part of the path, which is as long as friction at the wheels takes
    to end so much rotation; a car that rolls is then held back by its wheels' drag alone. Where no
    heading is known the vehicle is taken to end along its course.

    Args:
        way: measured points of the path after the impact.
        start: x, y, heading at the impact, m and rad.
        car: yaw inertia, axles, track and wheels of the vehicle.
        ground: friction of the surfaces and where they lie; taken as level.
    """
    start = jnp.asarray(start)
    places = jnp.concatenate([jnp.zeros((1, 2)), jnp.asarray(way.points) - start[:2]])
    legs = jnp.diff(places, axis=0)
    lengths = jnp.sqrt(jnp.sum(legs**2, axis=1) + _TINY)
    far = jnp.concatenate([jnp.zeros(1), jnp.cumsum(lengths)])
    length, stations = far[-1], far / far[-1]
    courses = _unwrapped(jnp.arctan2(legs[:, 1], legs[:, 0] + _TINY))
    middles = (stations[1:] + stations[:-1]) / 2

    known = ~jnp.isnan(jnp.asarray(way.heading))
    along = start[2] + _wrapped(courses[-1] - start[2], np.pi)
    heading = jnp.where(known, jnp.nan_to_num(jnp.asarray(way.heading)), along)
    last = len(way.heading) - 1
    first = jnp.where(known.any(), jnp.argmax(known), last)
    turned = heading[first] - start[2]
    turned_after = jnp.where(known[-1], heading[-1] - heading[first], 0.0)

    def place(shares: Float[Array, " points"]) -> Float[Array, "points 2"]:
        return jnp.stack([jnp.interp(shares, stations, places[:, i]) for i in (0, 1)], axis=1)

    even = (jnp.arange(_POINTS) + 0.5) / _POINTS
    x, y = (place(even) + start[:2]).T
    roughly = jnp.sqrt(GRAVITY * length * (1 - even))  # at half of g
    grip = friction(x, y, roughly, *ground.surfaces).mean()
    computed = turning(turned, length, grip, car)[0]
    share = jnp.where(first == last, computed, jnp.maximum(stations[first + 1], _LEAST_SHARE))

    shares = jnp.concatenate([share * even, share + (1 - share) * even])
    part = jnp.repeat(jnp.stack([share, 1 - share]), _POINTS) / _POINTS
    course = jnp.interp(shares, middles, courses)
    angle = start[2] + _heading(shares, share, turned, turned_after)
    early = shares < share
    by_length = (
        jnp.where(
            early,
            2 * turned / share * (1 - shares / share),
            turned_after / jnp.maximum(1 - share, _LEAST_SHARE),
        )
        / length
    )
    speed = jnp.sqrt(2 * GRAVITY * grip * length * (1 - shares) + _LEAST_SPEED2)
    for _ in range(_PASSES):
        drag = drag_factor(place(shares) + start[:2], course, angle, by_length, speed, car, ground)
        lost = drag * part
        left = jnp.cumsum(lost[::-1])[::-1] - lost / 2  # from here to rest
        speed = jnp.sqrt(jnp.maximum(2 * GRAVITY * length * left, 0.0) + _LEAST_SPEED2)
    # the mean may come out negative where a car turns round on a short way: keep it positive
    mean, least = jnp.sum(lost), _LEAST_DRAG * _own_drag(car) * grip
    mean = (mean + jnp.sqrt(mean**2 + 4 * least**2)) / 2
    return WayTaken(stations, places, length, courses[0], share, turned, turned_after, mean)


def rolled(
    velocity: Velocity, start: Pose, taken: WayTaken, shares: Float[Array, " rows"]
) -> Float[Array, "rows 3"]:
    """Poses along the run-out: the measured path, rotated and scaled in length.

    L = V² / (2 g f) and rotation = 0.55 Omega (2 L / V) (share of the path on which the vehicle turns).

    Args:
        velocity: Vx, Vy, Omega at the start, m/s and rad/s.
        start: x, y, heading at the start, m and rad.
        taken: the measured path.
        shares: shares of the path at which poses are given, 1 for rest.

    Returns:
        x, y, m, and heading, unwrapped, rad, at each share.
    """
    Vx, Vy, Omega = velocity
    speed2 = Vx**2 + Vy**2 + _TINY
    length = speed2 / (2 * GRAVITY * taken.drag)
    c, s = cos_sin(jnp.arctan2(Vy, Vx) - taken.course)
    x, y = (
        jnp.interp(shares, taken.stations, taken.places[:, i]) * length / taken.length
        for i in (0, 1)
    )
    turned = MEAN_YAW_RATE * Omega * 2 * length / jnp.sqrt(speed2) * taken.share
    angle = _heading(shares, taken.share, turned, taken.turned_after)
    return jnp.asarray(start) + jnp.stack([c * x - s * y, s * x + c * y, angle], axis=1)


def rolled_back(end: Pose, start: Pose, taken: WayTaken) -> Velocity:
    """The velocity from which `rolled` ends at a rest pose: its inverse.

    Args:
        end: x, y, heading at rest, unwrapped, m and rad.
        start: x, y, heading at the impact, m and rad.
        taken: the measured path.
    """
    x, y, turned = jnp.asarray(end) - jnp.asarray(start)
    chord_x, chord_y = taken.places[-1]
    length = taken.length * jnp.sqrt((x**2 + y**2 + _TINY) / (chord_x**2 + chord_y**2 + _TINY))
    speed = jnp.sqrt(2 * GRAVITY * taken.drag * length)
    c, s = cos_sin(taken.course + jnp.arctan2(y, x) - jnp.arctan2(chord_y, chord_x))
    time = MEAN_YAW_RATE * 2 * length / speed * taken.share
    return jnp.stack([speed * c, speed * s, (turned - taken.turned_after) / time])


def turning(
    turned: Float[Array | np.ndarray, ""] | float,
    length: Float[Array | np.ndarray, ""] | float,
    grip: Float[Array | np.ndarray, ""] | float,
    car: Car,
    xp: ModuleType = jnp,
) -> tuple[Any, Any]:
    """Share of the path on which the wheels end a rotation, and the initial speed.

    Friction at the wheels ends the rotation in the time T, turned = alpha T² / 2, at a drag factor f_1.
    The speed v left then, v T + g f_1 T² / 2 from the start, is lost on the remainder of the path at a
    drag factor f_2: v² / (2 g f_2).

    Args:
        turned: rotation, rad.
        length: length of the path, m.
        grip: mean friction on the path.
        car: yaw inertia, axles, track and wheels of the vehicle.
        xp: jax.numpy, or NumPy to compute without tracing or compiling.

    Returns:
        The share, 1 where the path is too short, and the initial speed V, m/s.
    """
    arm = xp.sqrt(car.front_axle * car.rear_axle + (car.track / 2) ** 2)
    size = xp.sqrt(turned**2 + _LEAST_TURN**2)
    T = xp.sqrt(2 * size * car.k2 / (_YAW_BRAKING * grip * GRAVITY * arm))
    own = _own_drag(car)
    f_1, f_2 = xp.maximum(_TURNING_DRAG, own) * grip, own * grip
    on_the_way = GRAVITY * f_1 * T**2 / 2
    rest = xp.maximum(length - on_the_way, 0.0)
    v = 2 * rest / (T + xp.sqrt(T**2 + 2 * rest / (GRAVITY * f_2) + _TINY))
    share = xp.where(rest > 0, (v * T + on_the_way) / length, 1.0)
    first = xp.where(rest > 0, v + GRAVITY * f_1 * T, xp.sqrt(2 * GRAVITY * f_1 * length))
    return xp.clip(share, _LEAST_SHARE, 1.0), first


def _own_drag(car: Car) -> Any:
    """Drag of the wheels straight ahead over friction, weighted by static loads."""
    if car.wheels is None:
        return 1.0
    front, drag = car.rear_axle / (car.front_axle + car.rear_axle) / 2, car.wheels.drag
    return front * (drag[0] + drag[1]) + (0.5 - front) * (drag[2] + drag[3])


def _heading(
    shares: Float[Array, " rows"], share: Array, turned: Array, turned_after: Array
) -> Float[Array, " rows"]:
    """Rotation at shares of the path, rad."""
    to_come = 1 - jnp.clip(shares / share, 0.0, 1.0)
    after = jnp.clip((shares - share) / jnp.maximum(1 - share, _LEAST_SHARE), 0.0, 1.0)
    return turned * (1 - to_come**2) + turned_after * after


def _wrapped(angle: Array, period: float) -> Array:
    """The equivalent angle within half a period of zero."""
    return angle - period * jnp.round(angle / period)


def _unwrapped(angle: Float[Array, " n"]) -> Float[Array, " n"]:
    """Equivalent angles, each within half a turn of the previous one."""
    steps = _wrapped(jnp.diff(angle), 2 * np.pi)
    return angle[0] + jnp.concatenate([jnp.zeros(1), jnp.cumsum(steps)])
