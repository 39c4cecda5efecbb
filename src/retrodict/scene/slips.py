"""Slips of an author that leave an impossible crash, and the scene without each of them.

A crash is judged by the balance of momentum, with straight slides to rest, and by the sense in which
each vehicle turned. The errors of such crude mechanics were found on simulated crashes.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import permutations, product

import numpy as np

from retrodict.constants import GRAVITY
from retrodict.scene.discrepancy import freedom
from retrodict.scene.records import WHEELS, Approach, Measured, Rest, Scene, Vehicle

# simulated crashes without a slip and all of `benchmarks/users` have less (tests/scene/test_slips.py)
CONFLICT = 1.7
_USUAL, _SPREAD = 15.0, 20.0  # m/s: prior mean and sd of a speed along its direction
_UNKNOWN = 30.0  # m/s: prior sd of each component where the direction is unknown
_OF_MOMENTUM = 0.3  # m/s: error of the momentum balance over the sum of both masses
_SPINS = math.radians(15)  # a vehicle that turned less has no sense of rotation
_EITHER_WAY = math.radians(120)  # and one that turned more may have turned the other way round
_SPEEDS = {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704}
_LENGTHS = {"m": 1.0, "ft": 0.3048}
_SIGN = "had the other sign"


def misfit(scene: Scene) -> float:
    """Misfit of a crash of two vehicles: its distance from a possible one.

    Args:
        scene: measured scene with two vehicles.

    Returns:
        The residual of the momentum balance, or of a vehicle's rotation where that is larger, over the
        errors that such crude mechanics have.
    """
    before, after, missed = _balance(scene)
    return max(missed, *(_rotation(scene, v, after[v] - before[v]) for v in scene.vehicles))


def undone(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """The scene without each slip that its author may have made.

    Args:
        scene: measured scene with two vehicles.

    Yields:
        The slip, in words that follow "if", and the scene without it.
    """
    yield (
        f"the angles of both impact centres {_SIGN} (to the left of straight ahead it is positive)",
        with_centres(scene, "ab"),
    )
    line = replace(scene.contact, Gamma=_turned(scene.contact.Gamma, -math.pi / 2))
    yield (
        "the contact line was counted from the x axis, where it is from the y axis",
        replace(scene, contact=line),
    )
    yield "headings were compass bearings, clockwise from north", as_bearings(scene)
    a, b = scene.vehicles.values()
    headings = {"a": replace(a, heading=b.heading), "b": replace(b, heading=a.heading)}
    yield "the headings of A and B at impact were exchanged", _with_vehicles(scene, headings)
    if len(scene.rest) == 2:
        exchanged = {"a": scene.rest["b"], "b": scene.rest["a"]}
        yield "the rest positions of A and B were exchanged", replace(scene, rest=exchanged)
    for v in scene.vehicles:
        yield from _of_vehicle(scene, v)


def _of_vehicle(scene: Scene, v: str) -> Iterator[tuple[str, Scene]]:
    name, vehicle, approach = v.upper(), scene.vehicles[v], scene.approach[v]
    yield f"the angle of {name}'s impact centre {_SIGN}", with_centres(scene, v)
    yield (
        f"{name}'s impact centre lay at its other end",
        _with_vehicles(
            scene, {v: replace(vehicle, impact_angle=_turned(vehicle.impact_angle, math.pi))}
        ),
    )
    yield (
        f"{name}'s heading at impact was 180 deg off",
        _with_vehicles(scene, {v: replace(vehicle, heading=_turned(vehicle.heading, math.pi))}),
    )
    if v in scene.rest:
        for words, rest in _rests(scene.rest[v]):
            yield f"{words.format(name)}", replace(scene, rest=scene.rest | {v: rest})
    if approach.speed and not approach.record:
        for words, speed in _in_other_units(approach.speed, _SPEEDS):
            other = scene.approach | {v: replace(approach, speed=speed)}
            yield f"{name}'s speed {words}", replace(scene, approach=other)
    if approach.speed and approach.skid:
        held = scene.surfaces[0].friction.value
        held *= approach.skid_braking.value if approach.skid_braking else 1.0
        lost = 2 * held * GRAVITY * approach.skid.value
        slower = math.sqrt(max(approach.speed.value**2 - lost, 0.0))
        at_impact = replace(approach, speed=replace(approach.speed, value=slower))
        yield (
            f"{name}'s speed was that before its skid, where it is that at the impact",
            replace(scene, approach=scene.approach | {v: at_impact}),
        )
    measured = scene.departure.get(v, {})
    forward, left = measured.get("delta_v_forward"), measured.get("delta_v_left")
    if forward and left:
        exchanged = measured | {"delta_v_forward": left, "delta_v_left": forward}
        yield (
            f"{name}'s delta_v_forward and delta_v_left were exchanged",
            replace(scene, departure=scene.departure | {v: exchanged}),
        )
    for key, item in measured.items():
        if not key.startswith("delta_v_"):
            continue
        changes = [(_SIGN, replace(item, value=-item.value)), *_in_other_units(item, _SPEEDS)]
        for words, other_item in changes:
            other_departure = scene.departure | {v: measured | {key: other_item}}
            yield f"{name}'s {key} {words}", replace(scene, departure=other_departure)


def _rests(rest: Rest) -> Iterator[tuple[str, Rest]]:
    """Rest poses without each slip, and the slip in words."""
    yield f"x of {{}}'s rest position {_SIGN}", replace(rest, x=_scaled(rest.x, -1))
    yield f"y of {{}}'s rest position {_SIGN}", replace(rest, y=_scaled(rest.y, -1))
    yield "x and y of {}'s rest position were exchanged", replace(rest, x=rest.y, y=rest.x)
    pairs = zip(_in_other_units(rest.x, _LENGTHS), _in_other_units(rest.y, _LENGTHS), strict=False)
    for (words, x), (also, y) in pairs:
        if words == also:
            yield f"{{}}'s rest position {words}", replace(rest, x=x, y=y)


def _in_other_units(measured: Measured, units: dict[str, float]) -> Iterator[tuple[str, Measured]]:
    """The same number in other units, for each unit in which it looks like one that a person typed."""
    for written, meant in permutations(units, 2):
        number = measured.value / units[written]
        if abs(number - round(number, 2)) < 1e-6:
            yield (
                f"was in {meant}, not in {written}",
                _scaled(measured, units[meant] / units[written]),
            )


def with_centres(scene: Scene, which: str) -> Scene:
    """The scene with the impact centre of some vehicles on the other side of their length.

    Args:
        scene: measured scene.
        which: "a", "b" or "ab".

    Returns:
        The other scene.
    """
    mirrored = {
        v: replace(own, impact_angle=_scaled(own.impact_angle, -1))
        for v, own in scene.vehicles.items()
        if v in which
    }
    return _with_vehicles(scene, mirrored)


def as_bearings(scene: Scene) -> Scene:
    """The scene with headings and courses changed from angles to compass bearings, or back.

    Args:
        scene: measured scene.

    Returns:
        The other scene.
    """

    def turned(angle: Measured) -> Measured:
        return replace(angle, value=math.pi / 2 - angle.value)

    vehicles = {v: replace(own, heading=turned(own.heading)) for v, own in scene.vehicles.items()}
    approach = {
        v: replace(own, direction=own.direction and turned(own.direction))
        for v, own in scene.approach.items()
    }
    rest = {
        v: replace(own, heading=own.heading and turned(own.heading))
        for v, own in scene.rest.items()
    }
    return replace(scene, vehicles=vehicles, approach=approach, rest=rest)


def _with_vehicles(scene: Scene, vehicles: Mapping[str, Vehicle]) -> Scene:
    """The scene with other vehicles, which travel along their headings where that is assumed."""
    approach = dict(scene.approach)
    for v, vehicle in vehicles.items():
        course = approach[v].direction
        if course is not None and course.assumed == "value":
            along = replace(course, value=vehicle.heading.value)
            approach[v] = replace(approach[v], direction=along)
    return replace(scene, vehicles={**scene.vehicles, **vehicles}, approach=approach)


def _turned(angle: Measured, turn: float) -> Measured:
    return replace(angle, value=angle.value + turn)


def _scaled(measured: Measured, factor: float) -> Measured:
    return replace(measured, value=factor * measured.value, sd=abs(factor) * measured.sd)


def _slide(scene: Scene, v: str) -> tuple[complex, float, float]:
    """Direction of a straight slide from the impact to rest; the speed it began with, and its error."""
    rest, vehicle = scene.rest[v], scene.vehicles[v]
    chord = complex(rest.x.value, rest.y.value) - complex(*scene.at_impact(v))
    fast = math.sqrt(2 * scene.surfaces[0].friction.value * GRAVITY * abs(chord))
    if vehicle.wheels is None:
        # wheels that turn about the vertical axis hold less than those that only slide
        speed, unknown = 0.9 * fast, 0.0
    else:
        drags = [getattr(vehicle.wheels, wheel).value for wheel in WHEELS]
        free = freedom(vehicle.front_axle.value, vehicle.rear_axle.value, drags)
        rolled = math.sqrt(max(1 - free, 0.0))
        # sideways it slides as if locked, lengthwise it rolls
        speed, unknown = fast * (1 + rolled) / 2, fast * (1 - rolled) / 3
    along = chord / abs(chord) if chord else 1 + 0j
    return along, speed, math.hypot(0.15 * speed + 0.7, unknown)


# factors of some of eight unknown velocities, what they add up to, and its error
_Equation = tuple[dict[int, float], float, float]


def _balance(scene: Scene) -> tuple[dict[str, complex], dict[str, complex], float]:
    """Least-squares velocities before and after the impact (m/s), and the residual's norm."""
    equations: list[_Equation] = []
    ahead_only: list[int] = []
    courses: dict[str, complex] = {}
    momentum: tuple[dict[int, float], dict[int, float]] = ({}, {})
    for (v, vehicle), (i, j) in zip(scene.vehicles.items(), ((0, 4), (2, 6)), strict=True):
        # unknowns i: velocity along the course and to its left; j: velocity after, along x and y
        course = scene.approach[v].direction or vehicle.heading
        courses[v] = ahead = cmath.rect(1, course.value)
        equations += [*_before(scene.approach[v], i), *_after(scene, v, ahead, i, j)]
        ahead_only += [i] if scene.approach[v].direction else []
        mass = vehicle.mass.value
        momentum[0].update({i: mass * ahead.real, i + 1: -mass * ahead.imag, j: -mass})
        momentum[1].update({i: mass * ahead.imag, i + 1: mass * ahead.real, j + 1: -mass})
    total = sum(vehicle.mass.value for vehicle in scene.vehicles.values())
    equations += [(parts, 0, _OF_MOMENTUM * total) for parts in momentum]
    rows, right = np.zeros((len(equations), 8)), np.zeros(len(equations))
    for n, (parts, value, sd) in enumerate(equations):
        rows[n, list(parts)] = [factor / sd for factor in parts.values()]
        right[n] = value / sd
    x, missed = _least_squares(rows, right, ahead_only)
    before = {v: (x[2 * n] + 1j * x[2 * n + 1]) * own for n, (v, own) in enumerate(courses.items())}
    after = {v: complex(*x[4 + 2 * n : 6 + 2 * n]) for n, v in enumerate(courses)}
    return before, after, missed


def _before(approach: Approach, i: int) -> Iterator[_Equation]:
    """Equations of a velocity before the impact, along the course and to its left."""
    if (course := approach.direction) is None:
        yield {i: 1}, 0, _UNKNOWN
        yield {i + 1: 1}, 0, _UNKNOWN
    else:
        usual = approach.speed.value if approach.speed else _USUAL
        yield {i: 1}, _USUAL, _SPREAD
        yield {i + 1: 1}, 0, max(course.sd, math.radians(3)) * max(usual, 5) + 0.3
    if approach.speed:
        yield {i: 1}, approach.speed.value, approach.speed.sd + 0.2


def _after(scene: Scene, v: str, ahead: complex, i: int, j: int) -> Iterator[_Equation]:
    """Equations of a velocity after the impact, along x and y, and of its change."""
    departure = scene.departure.get(v, {})
    if v in scene.rest:
        along, speed, sd = _slide(scene, v)
        yield {j: along.real, j + 1: along.imag}, speed, sd
        yield {j: -along.imag, j + 1: along.real}, 0, 0.2 * speed + 0.7
    if direction := departure.get("direction"):
        along, speed_after = cmath.rect(1, direction.value), departure.get("speed")
        usual = speed_after.value if speed_after else _USUAL / 2
        yield {j: -along.imag, j + 1: along.real}, 0, direction.sd * usual + 0.5
        if speed_after:
            yield {j: along.real, j + 1: along.imag}, speed_after.value, speed_after.sd + 0.3
    forward = cmath.rect(1, scene.vehicles[v].heading.value)
    for key, axis in (("delta_v_forward", forward), ("delta_v_left", 1j * forward)):
        if item := departure.get(key):
            less = -ahead * axis.conjugate()  # parts of the velocity before along the axis
            parts = {j: axis.real, j + 1: axis.imag, i: less.real, i + 1: -less.imag}
            yield parts, item.value, item.sd + 0.5


def _least_squares(
    rows: np.ndarray, right: np.ndarray, positive: Sequence[int]
) -> tuple[np.ndarray, float]:
    """The solution of rows x = right with some of x not below 0, and its distance.

    At most two of x are bound: with each of them at 0 or not, the best that keeps the bounds is the
    solution. SciPy's takes 0.4 s to import, as long as all else that `retrodict check` does.
    """
    best, distance = np.zeros(rows.shape[1]), math.inf
    for free in product((True, False), repeat=len(positive)):
        at_zero = [i for i, is_free in zip(positive, free, strict=True) if not is_free]
        left = np.delete(np.arange(rows.shape[1]), at_zero)
        x = np.zeros(rows.shape[1])
        x[left] = np.linalg.lstsq(rows[:, left], right)[0]
        off = float(np.linalg.norm(rows @ x - right))
        if off < distance and (x[list(positive)] >= 0).all():
            best, distance = x, off
    return best, distance


def _rotation(scene: Scene, v: str, change: complex) -> float:
    """Misfit of a change of velocity (m/s) to the rotation of a vehicle; 0 if that is uncertain."""
    vehicle, rest = scene.vehicles[v], scene.rest.get(v)
    if rest is None or rest.heading is None or vehicle.wheels is not None:
        return 0.0
    turned = rest.heading.value - vehicle.heading.value
    if not rest.turns_known:
        turned = math.remainder(turned, math.tau)
    if abs(turned) < _SPINS or not (rest.turns_known or abs(turned) < _EITHER_WAY):
        return 0.0
    lever = cmath.rect(
        vehicle.impact_distance.value, vehicle.heading.value + vehicle.impact_angle.value
    )
    impulse = vehicle.mass.value * change
    chord = math.dist(scene.at_impact(v), (rest.x.value, rest.y.value))
    _, speed, _ = _slide(scene, v)
    gained = vehicle.yaw_inertia.value * turned * speed / max(chord, 0.5)
    by_force = (lever.conjugate() * impulse).imag
    return abs(gained - by_force) / (0.6 * abs(gained) + 0.5 * abs(impulse) + vehicle.mass.value)
