"""A drawing of the road plane as named layers of shapes, for any CAD format."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

Place = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Line:
    """Straight lines from point to point (m), closed to the first one or not."""

    points: Float[np.ndarray, "points 2"]
    closed: bool = False


@dataclass(frozen=True, slots=True)
class Ellipse:
    """An ellipse whose axes are x and y: its centre and its half-axes along them, both above 0 (m)."""

    centre: Place
    half_axes: Place


@dataclass(frozen=True, slots=True)
class Point:
    """A point (m)."""

    at: Place


@dataclass(frozen=True, slots=True)
class Text:
    """A line of text whose lower left corner is at a point (m)."""

    at: Place
    text: str


Shape = Line | Ellipse | Point | Text


@dataclass(frozen=True, slots=True)
class Layer:
    """Shapes that are shown, hidden and coloured together.

    Args:
        name: name in letters, digits and hyphens.
        colour: RGB colour in hexadecimal, such as "#0072B2".
        shapes: shapes in the order in which they are drawn.
        dashed: whether the layer's lines are dashed.
    """

    name: str
    colour: str
    shapes: tuple[Shape, ...]
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Drawing:
    """Layers, the lowest first.

    Args:
        title: title of the drawing.
        layers: layers, the lowest first, none of them empty.
        text_height: height of the texts, m.
    """

    title: str
    layers: tuple[Layer, ...]
    text_height: float = 0.35

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x0, x1, y0, y1 of a rectangle that holds all shapes, m; texts are taken to be wide."""
        corners = [
            c for layer in self.layers for shape in layer.shapes for c in self._corners(shape)
        ]
        x, y = zip(*corners, strict=True)
        return min(x), max(x), min(y), max(y)

    def _corners(self, shape: Shape) -> list[Place]:
        match shape:
            case Line(points):
                low, high = points.min(axis=0).tolist(), points.max(axis=0).tolist()
                return [(low[0], low[1]), (high[0], high[1])]
            case Ellipse((x, y), (a, b)):
                return [(x - a, y - b), (x + a, y + b)]
            case Point(at):
                return [at]
            case Text((x, y), text):
                return [(x, y), (x + 0.75 * self.text_height * len(text), y + self.text_height)]


def on_one_line(text: str) -> str:
    """A text with spaces for line breaks and other characters that do not print."""
    return "".join(c if c.isprintable() else " " for c in text)


def edge_within(
    place: Place, direction: float, bounds: tuple[float, float, float, float]
) -> Line | None:
    """The part of an endless straight line that lies in the circle about a rectangle.

    Args:
        place: a point of the line, m.
        direction: direction of the line, counter-clockwise from the x axis, rad.
        bounds: x0, x1, y0, y1 of the rectangle, m.

    Returns:
        The part; None where the line passes the circle by.
    """
    x0, x1, y0, y1 = bounds
    centre, radius = np.array([x0 + x1, y0 + y1]) / 2, math.hypot(x1 - x0, y1 - y0) / 2
    along = np.array([math.cos(direction), math.sin(direction)])
    nearest = np.array(place) + along * ((centre - place) @ along)
    half = radius**2 - float(np.sum((nearest - centre) ** 2))
    if half <= 0:
        return None
    return Line(nearest + np.outer([-1.0, 1.0], math.sqrt(half) * along))
