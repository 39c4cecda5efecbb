"""Surveyed points, the frame that they lie in, and the pose of a vehicle from points on it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from retrodict.scene.records import WHEELS, Vehicle

Compass = Literal["east", "north", "west", "south"]
Angles = Literal["counter-clockwise from east", "clockwise from north"]

_DIRECTIONS = {"east": (1.0, 0.0), "north": (0.0, 1.0), "west": (-1.0, 0.0), "south": (0.0, -1.0)}
_ENDS = ("front_left", "rear_left", "rear_right", "front_right")
SPOTS = (
    "centre",
    *WHEELS,
    *(f"{end}_corner" for end in _ENDS),
    "front_middle",
    "rear_middle",
)


@dataclass(frozen=True, slots=True)
class Point:
    """A point of a survey or a drawing.

    Args:
        name: name by which a map refers to the point.
        group: description (survey) or layer (drawing), which several points may share.
        x: x coordinate in the file's axes and unit.
        y: y coordinate in the file's axes and unit.
        where: origin in the file: the row of a table, or the kind of a drawing's entity.
        heading: heading of the object at the point, rad, in the file's own convention; None for none.
        fault: reason why the point cannot be used; empty where it can.
    """

    name: str
    group: str
    x: float
    y: float
    where: str
    heading: float | None = None
    fault: str = ""


@dataclass(frozen=True, slots=True)
class Frame:
    """How a file's coordinates become those of a scene.

    Args:
        unit: length of the file's unit, m.
        axes: compass directions of the file's x and y axes.
        angles: convention in which the file, or its map, counts angles.
        origin: origin of the scene, x and y in the file's axes, m.
        x_axis: direction of the scene's x axis, counter-clockwise from east, rad.
    """

    unit: float
    axes: tuple[Compass, Compass]
    angles: Angles = "counter-clockwise from east"
    origin: tuple[float, float] = (0.0, 0.0)
    x_axis: float = 0.0

    def position(self, point: Point) -> tuple[float, float]:
        """Where a point lies in the scene, m."""
        x, y = (
            self.unit * value - o for value, o in zip((point.x, point.y), self.origin, strict=True)
        )
        return self._turned(*self._east_north(x, y))

    def heading(self, angle: float) -> float:
        """A direction in the scene, counter-clockwise from its x axis, from -pi to pi, rad."""
        return _once(from_east(angle, self.angles) - self.x_axis)

    def drawn_heading(self, angle: float) -> float:
        """A direction as from `heading`, of an angle from the file's x axis towards its y axis, rad."""
        x, y = self._turned(*self._east_north(math.cos(angle), math.sin(angle)))
        return math.atan2(y, x)

    def _east_north(self, x: float, y: float) -> tuple[float, float]:
        (xe, xn), (ye, yn) = (_DIRECTIONS[axis] for axis in self.axes)
        return x * xe + y * ye, x * xn + y * yn

    def _turned(self, east: float, north: float) -> tuple[float, float]:
        c, s = math.cos(self.x_axis), math.sin(self.x_axis)
        return c * east + s * north, c * north - s * east


def from_east(angle: float, angles: Angles) -> float:
    """An angle counter-clockwise from east, rad."""
    return math.pi / 2 - angle if angles == "clockwise from north" else angle


class Pose(NamedTuple):
    """A vehicle's pose and its standard deviations (m, rad), and how far its points miss it (m)."""

    x: float
    y: float
    heading: float
    sd_x: float
    sd_y: float
    sd_heading: float
    misfit: float


def spots_of(vehicle: Vehicle) -> dict[str, tuple[float, float]]:
    """Where each of `SPOTS` lies: ahead and to the left of the centre of gravity, m.

    The body is taken to reach as far beyond the front axle as beyond the rear one.
    """
    front, rear = vehicle.front_axle.value, vehicle.rear_axle.value
    half, side = vehicle.track.value / 2, vehicle.width / 2
    middle = (front - rear) / 2
    nose, tail = middle + vehicle.length / 2, middle - vehicle.length / 2
    return {
        "centre": (0.0, 0.0),
        "front_left": (front, half),
        "front_right": (front, -half),
        "rear_left": (-rear, half),
        "rear_right": (-rear, -half),
        "front_left_corner": (nose, side),
        "front_right_corner": (nose, -side),
        "rear_left_corner": (tail, side),
        "rear_right_corner": (tail, -side),
        "front_middle": (nose, 0.0),
        "rear_middle": (tail, 0.0),
    }


def fitted_pose(
    body: Sequence[tuple[float, float]], road: Sequence[tuple[float, float]], sd: float
) -> Pose:
    """The pose by which points on a vehicle come closest to where they were surveyed.

    Least squares over rotations and shifts, in closed form; standard deviations are those of
    independent errors of each coordinate, to first order.

    Args:
        body: two points or more, ahead and to the left of the centre of gravity, m.
        road: positions of the same points in the scene, m.
        sd: standard deviation of each coordinate of a point, m.

    Returns:
        The pose of the centre of gravity; misfit is the root mean square distance that remains.

    Raises:
        ValueError: all points on the vehicle coincide.
    """
    count = len(body)
    (body_x, body_y), (road_x, road_y) = _mean(body), _mean(road)
    pairs = [
        ((u - body_x, v - body_y), (x - road_x, y - road_y))
        for (u, v), (x, y) in zip(body, road, strict=True)
    ]
    along = sum(u * x + v * y for (u, v), (x, y) in pairs)
    across = sum(u * y - v * x for (u, v), (x, y) in pairs)
    size = sum(u * u + v * v for (u, v), _ in pairs)
    if size < 1e-4:
        raise ValueError("one spot")
    heading = math.atan2(across, along)
    c, s = math.cos(heading), math.sin(heading)
    # from the centre of gravity to their mean
    lever_x, lever_y = c * body_x - s * body_y, s * body_x + c * body_y
    rest = [math.hypot(x - c * u + s * v, y - s * u - c * v) for (u, v), (x, y) in pairs]
    sd_heading, sd_mean = sd / math.sqrt(size), sd / math.sqrt(count)
    return Pose(
        road_x - lever_x,
        road_y - lever_y,
        heading,
        math.hypot(sd_mean, lever_y * sd_heading),
        math.hypot(sd_mean, lever_x * sd_heading),
        sd_heading,
        math.sqrt(sum(each * each for each in rest) / count),
    )


def posed(
    body: tuple[float, float],
    road: tuple[float, float],
    heading: float,
    sd: float,
    sd_heading: float,
) -> Pose:
    """The pose by one point on a vehicle and its heading.

    Args:
        body: position of the point ahead and to the left of the centre of gravity, m.
        road: position of the same point in the scene, m.
        heading: heading of the vehicle, rad.
        sd: standard deviation of each coordinate of the point, m.
        sd_heading: standard deviation of the heading, rad.
    """
    c, s = math.cos(heading), math.sin(heading)
    lever_x, lever_y = c * body[0] - s * body[1], s * body[0] + c * body[1]
    return Pose(
        road[0] - lever_x,
        road[1] - lever_y,
        heading,
        math.hypot(sd, lever_y * sd_heading),
        math.hypot(sd, lever_x * sd_heading),
        sd_heading,
        0.0,
    )


def fitted_line(
    points: Sequence[tuple[float, float]],
) -> tuple[tuple[float, float], float, float]:
    """The line closest to two points or more: a point of it (m), its direction (rad), the misfit (m).

    The direction is that from the first point towards the last.

    Raises:
        ValueError: all points coincide.
    """
    mx, my = _mean(points)
    centred = [(x - mx, y - my) for x, y in points]
    xx, yy = sum(x * x for x, _ in centred), sum(y * y for _, y in centred)
    xy = sum(x * y for x, y in centred)
    if xx + yy < 1e-6:
        raise ValueError("one place")
    direction = math.atan2(2 * xy, xx - yy) / 2
    c, s = math.cos(direction), math.sin(direction)
    if (points[-1][0] - points[0][0]) * c + (points[-1][1] - points[0][1]) * s < 0:
        direction = _once(direction + math.pi)
    off = sum((c * y - s * x) ** 2 for x, y in centred) / len(points)
    return (mx, my), direction, math.sqrt(off)


def named(points: Sequence[Point]) -> Mapping[str, list[Point]]:
    """Points by name, and by group where no point has that name."""
    names: dict[str, list[Point]] = {}
    groups: dict[str, list[Point]] = {}
    for point in points:
        names.setdefault(point.name, []).append(point)
        groups.setdefault(point.group, []).append(point)
    return {name: each for name, each in (groups | names).items() if name}


def _mean(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)


def _once(angle: float) -> float:
    return math.remainder(angle, math.tau)
