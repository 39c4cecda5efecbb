"""Error of a run-out model: it grows with the length of the path, and with how freely the car rolled.

The error of a position is normal, its scale proportional to the length of the path from the impact; the
error of a heading stops growing once a car has turned into its direction of travel. The size of neither
is known: `defaults` has the assumed ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

from retrodict.scene.defaults import DEFAULTS

Point = tuple[float, float]


def path_length(start: Point, passed: Iterable[Point], end: Point) -> float:
    """Length of a path through points, in whichever order they were written.

    Args:
        start: first point of the path, m.
        passed: points on the path, m; points further from its start than its end is are left out.
        end: last point of the path, m.

    Returns:
        The length of the straight lines between them, m.
    """
    between = [p for p in passed if math.dist(start, p) < math.dist(start, end)]
    stations = [start, *sorted(between, key=lambda p: math.dist(start, p)), end]
    return sum(math.dist(p, q) for p, q in pairwise(stations))


def settled(length: float) -> float:
    """Error of a heading after a path of this length (m), as a share of its final size."""
    return min(1.0, length / DEFAULTS["run_out_settled"].amount(0.0))


def freedom(front_axle: float, rear_axle: float, drags: Sequence[float]) -> float:
    """How freely a vehicle rolled: 1 with free wheels, 0 with locked ones.

    Args:
        front_axle: distance from the centre of gravity to the front axle, m.
        rear_axle: distance from the centre of gravity to the rear axle, m.
        drags: braking force of the front left, front right, rear left and rear right wheel over the
            available friction.

    Returns:
        1 less the mean of the drags, weighted by the static loads.
    """
    front = rear_axle / (front_axle + rear_axle)
    loads = (front, front, 1 - front, 1 - front)
    return 1 - sum(load * drag for load, drag in zip(loads, drags, strict=True)) / 2
