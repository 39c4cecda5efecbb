"""Outlines: the corners of a surface, three or more that make a polygon; where a body lies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from retrodict.scene.records import Vehicle

MOST_CORNERS = 100
_SAME = 1e-4  # m: corners closer than this are one
_LEAST_AREA = 0.01  # m²: about that of a tyre's contact patch

Place = tuple[float, float]


def body_middle(vehicle: Vehicle) -> float:
    """How far a body's middle lies ahead of the centre of gravity, m; midway between the axles.

    Args:
        vehicle: vehicle, whose record has no overhangs.
    """
    return (vehicle.front_axle.value - vehicle.rear_axle.value) / 2


def outline_fault(corners: Sequence[Place]) -> str:
    """The fault of an outline, and what to write instead; empty where there is none.

    Args:
        corners: corners in order, m; the last is joined to the first.
    """
    count = len(corners)
    if not 3 <= count <= MOST_CORNERS:
        return f"an outline of {count} corners; write 3 to {MOST_CORNERS}"
    for i in range(count):
        for j in range(i):
            if math.dist(corners[i], corners[j]) < _SAME:
                fix = "write each once (the last is joined to the first)"
                return f"corner {i + 1} is corner {j + 1} again; {fix}"
    sides = [(corners[i], corners[(i + 1) % count]) for i in range(count)]
    for i in range(count):
        for j in range(i):
            if _meet(sides[j], sides[i]):
                names = (f"from corner {k + 1} to {(k + 1) % count + 1}" for k in (j, i))
                return f"its sides {' and '.join(names)} meet; write the corners in order"
    twice = sum(x * y_next - x_next * y for (x, y), (x_next, y_next) in sides)
    if abs(twice) / 2 < _LEAST_AREA:
        return f"an outline around less than {_LEAST_AREA} m²; check its corners and their units"
    return ""


def _meet(one: tuple[Place, Place], other: tuple[Place, Place]) -> bool:
    """Whether two sides have a point in common, but for the corner between neighbours."""
    (a, b), (c, d) = one, other
    if b == c or d == a:  # neighbours: does the second lead back along the first?
        before, corner, after = (a, b, d) if b == c else (c, d, b)
        ahead = (corner[0] - before[0]) * (after[0] - corner[0])
        ahead += (corner[1] - before[1]) * (after[1] - corner[1])
        return _turn(before, corner, after) == 0 and ahead < 0
    turns = (_turn(a, b, c), _turn(a, b, d), _turn(c, d, a), _turn(c, d, b))
    if turns[0] * turns[1] < 0 and turns[2] * turns[3] < 0:
        return True
    return any(
        turn == 0 and _between(p, *side)
        for turn, p, side in zip(turns, (c, d, a, b), (one, one, other, other), strict=True)
    )


def _turn(a: Place, b: Place, c: Place) -> float:
    """Twice the area of a triangle: above 0 counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _between(p: Place, a: Place, b: Place) -> bool:
    """Whether a point on the line through two others lies between them."""
    return all(min(u, v) <= w <= max(u, v) for w, u, v in zip(p, a, b, strict=True))
