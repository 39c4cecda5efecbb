"""A view from above in the units of an SVG drawing: points, surfaces and a scale bar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from retrodict.report.figures.plan_geometry import area_of, barrier_outline
from retrodict.scene.quantities import Units, unit_of
from retrodict.scene.records import Scene

View = tuple[float, float, float, float]
SIZE = 720.0  # units of the drawing's longer side


def bounds_of(points: list[np.ndarray], margin: float) -> View:
    """The rectangle about points, each entry of shape (any, 2), with a margin; all in m."""
    both = np.concatenate(points)
    low, high = both.min(axis=0) - margin, both.max(axis=0) + margin
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


@dataclass(frozen=True, slots=True)
class Plan:
    """A rectangle of the road plane, drawn to scale.

    Args:
        view: bounds x0, x1, y0, y1 in m.
    """

    view: View

    @property
    def scale(self) -> float:
        """Units of the drawing in a metre."""
        x0, x1, y0, y1 = self.view
        return SIZE / max(x1 - x0, y1 - y0)

    @property
    def width(self) -> float:
        """Width in units of the drawing."""
        return (self.view[1] - self.view[0]) * self.scale

    @property
    def height(self) -> float:
        """Height in units of the drawing."""
        return (self.view[3] - self.view[2]) * self.scale

    def at(self, points: np.ndarray) -> str:
        """Points (n, 2 or more; m) as the coordinates of a polygon: "x,y x,y"."""
        origin, scale = [self.view[0], self.view[3]], [self.scale, -self.scale]
        placed = (np.atleast_2d(points)[:, :2] - origin) * scale
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in placed)

    def surfaces(self, scene: Scene) -> list[dict[str, str]]:
        """The surfaces other than the road that lie in the view, each with its name and its area."""
        return [
            {"name": surface.name, "area": self.at(corners)}
            for surface in scene.surfaces[1:]
            if len(corners := area_of(surface, self.view)) >= 3
        ]

    def barrier(self, scene: Scene) -> dict[str, str]:
        """Name and area of the barrier that A struck; empty where A struck a vehicle."""
        if scene.barrier is None:
            return {}
        reach = float(np.hypot(*np.subtract(self.view[1::2], self.view[::2])))
        return {"name": scene.barrier.name, "area": self.at(barrier_outline(scene, reach))}

    def scale_bar(self, units: Units) -> dict[str, Any]:
        """Length in units of the drawing, and text, of a bar shorter than a quarter of the width."""
        unit = unit_of("length", units)
        width = (self.view[1] - self.view[0]) / unit.worth
        fits = [s * 10.0**k for k in range(-1, 5) for s in (1, 2, 5) if s * 10.0**k < width / 4]
        length = max(fits, default=1.0)
        return {"length": length * unit.worth * self.scale, "text": f"{length:g} {unit.symbol}"}
