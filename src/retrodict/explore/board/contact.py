"""A proposal of the contact line, from the outlines of what touched."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from itertools import combinations

from retrodict.explore.board.plan import Car, Plan

# judgement: how far the line along which two crushed outlines cross may be off the contact line, and
# that along a side of one vehicle
_SD_CROSSING, _SD_SIDE = math.radians(5), math.radians(8)
_SHORT = 0.3  # m: outlines that cross so near each other give no direction


@dataclass(frozen=True, slots=True)
class Proposal:
    """A contact line that outlines suggest.

    Args:
        angle: angle from the y axis, rad, from -90 deg to 90 deg.
        sd: standard deviation, rad.
        why: reason for the line, in words.
    """

    angle: float
    sd: float
    why: str


def proposed(plan: Plan) -> Proposal | None:
    """The contact line that the outlines at the impact suggest; None where too little is placed.

    Outlines of vehicles that stand as they did at the greatest crush cross at two points, and the line
    through these parts the vehicles. Where they do not cross, the line runs along the side that is
    nearest to the impact point.

    Args:
        plan: plan of the present state.
    """
    placed = [car for car in plan.cars.values() if car.at is not None and car.heading is not None]
    if plan.barrier == "wall" or not placed:  # the line is the wall's face, which somebody draws
        return None
    if len(placed) == 2:
        points = _crossings(corners(placed[0]), corners(placed[1]))
        pair = max(combinations(points, 2), key=lambda ends: abs(ends[0] - ends[1]), default=None)
        if pair and abs(pair[0] - pair[1]) > _SHORT:
            return Proposal(
                _from_y(pair[1] - pair[0]),
                _SD_CROSSING,
                "through the points where the outlines cross",
            )
    if plan.point is None:
        return None
    struck, car, side = complex(*plan.point), None, 0j
    nearest = math.inf
    for each in placed:
        around = corners(each)
        for one, other in zip(around, around[1:] + around[:1], strict=True):
            if (off := _distance(struck, one, other)) < nearest:
                nearest, car, side = off, each, other - one
    assert car is not None
    return Proposal(_from_y(side), _SD_SIDE, f"along the side of {car.letter} that was hit")


def corners(car: Car) -> list[complex]:
    """Corners of a vehicle at the impact, m: front left, front right, rear right, rear left.

    Args:
        car: vehicle that is placed at the impact.
    """
    assert car.at is not None
    assert car.heading is not None
    ahead, half = car.length / 2, car.width / 2
    turn = cmath.rect(1, car.heading)
    middle = complex(*car.at) + car.middle * turn
    body = (
        complex(ahead, half),
        complex(ahead, -half),
        complex(-ahead, -half),
        complex(-ahead, half),
    )
    return [middle + each * turn for each in body]


def _crossings(one: list[complex], other: list[complex]) -> list[complex]:
    """Points in which two outlines cross."""
    found = []
    for a, b in zip(one, one[1:] + one[:1], strict=True):
        for c, d in zip(other, other[1:] + other[:1], strict=True):
            across = _cross(b - a, d - c)
            if abs(across) < 1e-12:
                continue
            s, t = _cross(c - a, d - c) / across, _cross(c - a, b - a) / across
            if 0 <= s <= 1 and 0 <= t <= 1:
                found.append(a + s * (b - a))
    return found


def _cross(one: complex, other: complex) -> float:
    return one.real * other.imag - one.imag * other.real


def _distance(point: complex, one: complex, other: complex) -> float:
    """Distance of a point from the line between two others."""
    along = other - one
    share = ((point - one) * along.conjugate()).real / abs(along) ** 2
    return abs(point - one - min(max(share, 0.0), 1.0) * along)


def _from_y(along: complex) -> float:
    """Angle of a line from the y axis, counter-clockwise, from -90 deg to 90 deg."""
    return math.remainder(cmath.phase(along) - math.pi / 2, math.pi)
