"""How far a run-out model misses a real car: it grows with the way, and with how freely it rolled.

The error law of a place is normal with the length of the way from the impact as scale; that of a
heading stops growing where a car has turned into its course. Neither is known: `defaults` has them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

from retrodict.scene.defaults import DEFAULTS

Point = tuple[float, float]


def way(start: Point, passed: Iterable[Point], end: Point) -> float:
    """Length of a way through points, in whichever order they were written.

    Args:
        start: where it starts, m.
        passed: points of it, m; those that lie further from the start than its end are left out.
        end: where it ends, m.

    Returns:
        The length of the straight lines between them, m.
    """
    between = [p for p in passed if math.dist(start, p) < math.dist(start, end)]
    stations = [start, *sorted(between, key=lambda p: math.dist(start, p)), end]
    return sum(math.dist(p, q) for p, q in pairwise(stations))


def settled(way: float) -> float:
    """Share of its final size that the error of a heading has after a way (m)."""
    return min(1.0, way / DEFAULTS["run_out_settled"].amount(0.0))


def freedom(front_axle: float, rear_axle: float, drags: Sequence[float]) -> float:
    """How freely a vehicle rolled: 1 with free wheels, 0 with locked ones.

    Args:
        front_axle: from the centre of gravity, m.
        rear_axle: likewise.
        drags: braking force of the front left, front right, rear left and rear right wheel over the
            available friction.

    Returns:
        1 less the mean of the drags, weighted by the static loads.
    """
    front = rear_axle / (front_axle + rear_axle)
    loads = (front, front, 1 - front, 1 - front)
    return 1 - sum(load * drag for load, drag in zip(loads, drags, strict=True)) / 2
