"""The measured scene from above as a small SVG, quick enough to follow a slider."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from retrodict.report.figures.plan import Plan, View, bounds_of
from retrodict.report.figures.plan_geometry import (
    contact_lines,
    ends_of_rotation,
    impact_pose,
    outline,
    rest_outline,
)
from retrodict.report.templates import template
from retrodict.scene.quantities import Units
from retrodict.scene.records import Scene

_MARGIN = 1.5  # m about what is drawn
# vehicle's lengths behind its centre of gravity: both ends of a direction's arrow
_ARROW = (1.3, 0.6)


def view_of(scene: Scene, at_least: View | None = None) -> View:
    """The rectangle of the road plane that holds all that was measured.

    Args:
        scene: scene whose measurements are to be in view.
        at_least: rectangle to be in view too, such as that of the previous picture; None for none.

    Returns:
        Bounds x0, x1, y0, y1 in m.
    """
    points = [outline(scene.vehicles[v], impact_pose(scene, v)) for v in scene.vehicles]
    points += [rest_outline(scene, v) for v in scene.rest]
    points += [_arrow(scene, v) for v in scene.vehicles]
    points += [np.array([[m.x, m.y]]) for marks in scene.marks.values() for m in marks]
    points += [np.array([[x, y]]) for _, x, y, _ in ends_of_rotation(scene)]
    x0, x1, y0, y1 = bounds_of(points, _MARGIN)
    if at_least is None:
        return x0, x1, y0, y1
    a0, a1, b0, b1 = at_least
    return min(x0, a0), max(x1, a1), min(y0, b0), max(y1, b1)


def scene_svg(scene: Scene, units: Units = "si", view: View | None = None) -> str:
    """A scene from above, to scale, without any reconstruction.

    Args:
        scene: scene to draw.
        units: "si" or "us", the system of units of the scale bar.
        view: bounds x0, x1, y0, y1 in m; None for all that was measured.

    Returns:
        An SVG element. Every text of the scene is escaped.
    """
    plan = Plan(view or view_of(scene))
    evidence = scene.evidence()
    contact = scene.contact

    def ellipse(x: float, y: float, sd_x: float, sd_y: float) -> dict[str, Any]:
        place = plan.at(np.array([x, y])).split(",")
        return {"at": place, "radii": [2 * sd * plan.scale for sd in (sd_x, sd_y)]}

    content = {
        "width": plan.width,
        "height": plan.height,
        "surfaces": plan.surfaces(scene),
        "road": scene.surfaces[0].name,
        "vehicles": [
            {
                "name": v,
                "title": scene.vehicles[v].name,
                "impact": _drawn(plan, outline(scene.vehicles[v], impact_pose(scene, v))),
                "label": plan.at(np.array(impact_pose(scene, v))).split(","),
                "arrow": plan.at(arrow) if len(arrow := _arrow(scene, v)) else "",
                "rest": _drawn(plan, rest_outline(scene, v)) if v in scene.rest else None,
                "at_rest": ellipse(
                    scene.rest[v].x.value,
                    scene.rest[v].y.value,
                    evidence[f"rest_x_{v}"].sd,
                    evidence[f"rest_y_{v}"].sd,
                )
                if v in scene.rest
                else None,
                "marks": [plan.at(np.array([m.x, m.y])).split(",") for m in scene.marks.get(v, ())],
                "ends": [
                    plan.at(np.array([x, y])).split(",")
                    for w, x, y, _ in ends_of_rotation(scene)
                    if w == v
                ],
            }
            for v in scene.vehicles
        ],
        "barrier": plan.barrier(scene),
        "impact": ellipse(contact.x.value, contact.y.value, contact.x.sd, contact.y.sd),
        "line": plan.at(contact_lines(scene)[0])
        if "impact.contact_line" not in scene.unwritten
        else None,
        "bar": plan.scale_bar(units),
    }
    return template("scene.svg.j2").render(content)


def _drawn(plan: Plan, corners: np.ndarray) -> dict[str, str]:
    """The body and the forward mark; a point has neither."""
    return {"body": plan.at(corners[:4]), "front": plan.at(corners[4:])} if len(corners) > 1 else {}


def _arrow(scene: Scene, v: str) -> np.ndarray:
    """The measured direction of travel before the impact, shape (2, 2); (0, 2) where there is none."""
    if (direction := scene.approach[v].direction) is None:
        return np.empty((0, 2))
    ahead = np.array([math.cos(direction.value), math.sin(direction.value)])
    length = scene.vehicles[v].length
    return np.array([impact_pose(scene, v)[:2] - each * length * ahead for each in _ARROW])
