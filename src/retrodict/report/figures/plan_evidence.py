"""What was measured, on the plan of a scene: poses, skids, directions, marks and the impact."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, FancyArrowPatch, Patch, Polygon, Wedge

from retrodict.report.figures import drawing
from retrodict.report.figures.plan_geometry import (
    Pose,
    contact_lines,
    ends_of_rotation,
    impact_pose,
    outline,
    rest_outline,
    skid_lines,
)
from retrodict.report.figures.plan_signs import write_name
from retrodict.scene.records import Scene, Vehicle

if TYPE_CHECKING:
    from matplotlib.artist import Artist


def draw_measured(axes: Axes, scene: Scene, worth: float) -> list[Artist]:
    """Draw what was measured in a scene.

    Args:
        axes: axes of the plan.
        scene: scene to draw.
        worth: length of the printed unit, m.

    Returns:
        Entries of the legend; what has a name beside it needs none.
    """
    handles = _vehicles(axes, scene, worth)
    _skids(axes, scene, worth)
    handles += _directions(axes, scene, worth)
    handles += _from_impact(axes, scene, worth)
    _marks(axes, scene, worth)
    handles += _rotations(axes, scene, worth)
    return handles + _contact(axes, scene, worth)


def measured_points(scene: Scene) -> list[np.ndarray]:
    """Points of a scene that its plan has to show, in m, each entry of shape (any, 2)."""
    points = [outline(scene.vehicles[v], impact_pose(scene, v)) for v in scene.vehicles]
    points += [rest_outline(scene, v) for v in scene.rest]
    points += [_rests_from_impact(scene, v) for v in scene.from_impact]
    points += [np.array([[m.x, m.y] for m in marks]) for marks in scene.marks.values()]
    points += [np.array([[x, y]]) for _, x, y, _ in ends_of_rotation(scene)]
    points += contact_lines(scene)
    return points + [lines.reshape(-1, 2) for _, lines in skid_lines(scene)]


def _vehicles(axes: Axes, scene: Scene, worth: float) -> list[Artist]:
    ink, evidence = drawing.INK, scene.evidence()
    for v in scene.vehicles:
        _outlined(axes, scene.vehicles[v], v, "impact", impact_pose(scene, v), worth)
    for v, rest in scene.rest.items():
        x, y = rest.x.value, rest.y.value
        size = [4 * evidence[f"rest_{axis}_{v}"].sd / worth for axis in "xy"]
        ellipse = Ellipse(
            (x / worth, y / worth), *size, fc=(1, 1, 1, 0.45), ec=ink, lw=1.1, zorder=5.5
        )
        axes.add_patch(ellipse)
        if rest.heading is not None:
            _outlined(axes, scene.vehicles[v], v, "rest", (x, y, rest.heading.value), worth)
            continue
        axes.plot(x / worth, y / worth, "+", color=ink, ms=5, mew=1.0, zorder=7)
        axes.annotate(
            f"{v.upper()} rest", (x / worth, y / worth), xytext=(6, 6), textcoords="offset points",
            color=drawing.OF_VEHICLE[v], size=8, weight="bold", zorder=8, path_effects=drawing.HALO,
        )  # fmt: skip
    if not (scene.rest or scene.contact.x.sd):
        return []
    look: dict[str, Any] = {"ls": "", "marker": "o", "mfc": "white", "mec": ink, "ms": 8}
    return [Line2D([], [], label="measured place ± 2 sd", **look)]


def _outlined(axes: Axes, vehicle: Vehicle, v: str, when: str, pose: Pose, worth: float) -> None:
    line, z = ((0, (4, 2)), 4.0) if when == "impact" else ("-", 5.0)
    colour, corners = drawing.OF_VEHICLE[v], outline(vehicle, pose) / worth
    axes.add_patch(Polygon(corners[:4], fill=False, ec=colour, lw=1.5, ls=line, zorder=z))
    axes.add_patch(Polygon(corners[4:], fc=colour, ec="none", zorder=z))
    cx, cy = pose[0] / worth, pose[1] / worth
    axes.plot(cx, cy, "+", color=drawing.INK, ms=5, mew=1.0, zorder=z + 2)
    # the name goes behind the centre of gravity, inside the outline
    back = 0.3 * vehicle.length / worth
    tx, ty = cx - back * np.cos(pose[2]), cy - back * np.sin(pose[2])
    axes.text(
        tx, ty, f"{v.upper()} {when}", ha="center", va="center", color=colour, size=8,
        weight="bold", zorder=z + 3, path_effects=drawing.HALO,
    )  # fmt: skip


def _skids(axes: Axes, scene: Scene, worth: float) -> None:
    """The measured skids up to the impact, along the direction of travel."""
    look: dict[str, Any] = {"lw": 3.5, "alpha": 0.35, "solid_capstyle": "butt"}
    for v, sides in skid_lines(scene):
        for begin, end in sides / worth:
            axes.plot(*zip(begin, end, strict=True), color=drawing.OF_VEHICLE[v], zorder=2, **look)
        write_name(
            axes, sides.mean(axis=(0, 1)) / worth, f"skid of {v.upper()}", drawing.OF_VEHICLE[v]
        )


def _directions(axes: Axes, scene: Scene, worth: float) -> list[Artist]:
    """The measured directions of travel, after impact and at marks."""
    look: dict[str, Any] = {"alpha": 0.35, "lw": 0}
    measured = [
        (v, impact_pose(scene, v)[:2], d.get("direction")) for v, d in scene.departure.items()
    ]
    measured += [(v, (m.x, m.y), m.course) for v, marks in scene.marks.items() for m in marks]
    drawn = []
    for v, (x, y), direction in measured:
        if direction is None:
            continue
        reach = min(2 * direction.sd, np.pi)  # all round, at most
        low, high = np.degrees([direction.value - reach, direction.value + reach])
        radius = 0.6 * scene.vehicles[v].length / worth
        colour = drawing.OF_VEHICLE[v]
        axes.add_patch(
            Wedge((x / worth, y / worth), radius, low, high, color=colour, zorder=3, **look)
        )
        drawn.append(v)
    handle = Patch(color=drawing.INK, label="direction of travel ± 2 sd", **look)
    return [handle] if drawn else []


def _rests_from_impact(scene: Scene, v: str) -> np.ndarray:
    """Where a vehicle may have come to rest by its distance and direction ± 2 sd: an arc, m."""
    seen = scene.from_impact[v]
    direction = seen.get("direction")
    turn = np.linspace(-np.pi, np.pi, 60)
    if direction is not None:
        turn = direction.value + min(2 * direction.sd, np.pi) / np.pi * turn
    around = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return impact_pose(scene, v)[:2] + seen["distance"].value * around


def _from_impact(axes: Axes, scene: Scene, worth: float) -> list[Artist]:
    """The rests that were measured from the impact."""
    look: dict[str, Any] = {"lw": 2.5, "alpha": 0.6}
    for v in scene.from_impact:
        arc = _rests_from_impact(scene, v) / worth
        axes.plot(*arc.T, color=drawing.OF_VEHICLE[v], zorder=3, **look)
        middle = arc[len(arc) // 2]
        write_name(axes, middle, f"{v.upper()} came to rest here", drawing.OF_VEHICLE[v])
    label = "rest by its distance, direction ± 2 sd"
    return [Line2D([], [], color=drawing.INK, label=label, **look)] if scene.from_impact else []


def _marks(axes: Axes, scene: Scene, worth: float) -> None:
    """The measured points on the way to rest, numbered as the evidence is."""
    look: dict[str, Any] = {"ls": "", "marker": "x", "ms": 5, "mew": 1.4}
    for v, marks in scene.marks.items():
        colour = drawing.OF_VEHICLE[v]
        for number, mark in enumerate(marks, start=1):
            place = (mark.x / worth, mark.y / worth)
            axes.plot(*place, color=colour, zorder=8, **look)
            axes.annotate(
                f"mark {v.upper()}{number}", place, xytext=(4, 4), textcoords="offset points", size=8,
                color=colour, zorder=8, path_effects=drawing.HALO,
            )  # fmt: skip


def _rotations(axes: Axes, scene: Scene, worth: float) -> list[Artist]:
    """The measured ends of rotation."""
    look: dict[str, Any] = {"ls": "", "marker": "D", "ms": 4.5, "mfc": "white", "mew": 1.2}
    ends = ends_of_rotation(scene)
    for v, x, y, heading in ends:
        colour = drawing.OF_VEHICLE[v]
        if heading:
            reach, angle = scene.vehicles[v].length / 2, heading.value
            tip = np.array([[x, y], [x + reach * np.cos(angle), y + reach * np.sin(angle)]])
            axes.plot(*tip.T / worth, color=colour, lw=1.2, zorder=8)
        axes.plot(x / worth, y / worth, mec=colour, zorder=8, **look)
    handle = Line2D([], [], mec=drawing.INK, label="end of rotation, measured", **look)
    return [handle] if ends else []


def _contact(axes: Axes, scene: Scene, worth: float) -> list[Artist]:
    x, y = scene.contact.x.value / worth, scene.contact.y.value / worth
    size = [4 * m.sd / worth for m in (scene.contact.x, scene.contact.y)]
    if min(size) > 0:
        axes.add_patch(Ellipse((x, y), *size, fc=(1, 1, 1, 0.45), ec=drawing.INK, lw=1.1, zorder=8))
    ink = drawing.INK
    axes.plot(x, y, "*", color="white", mec=ink, ms=10, mew=0.9, zorder=9)
    star = Line2D([], [], ls="", marker="*", color="white", mec=ink, ms=10, label="impact centre")
    if "impact.contact_line" in scene.unwritten:
        return [star]
    line, normal = (ends / worth for ends in contact_lines(scene))
    axes.plot(*line.T, "-.", color=ink, lw=1.0, zorder=8)
    axes.add_patch(
        FancyArrowPatch(
            *normal,
            arrowstyle="-|>",
            mutation_scale=8,
            color=ink,
            lw=1.0,
            shrinkA=0,
            shrinkB=0,
            zorder=8,
        )
    )
    label = "contact line (Γ), arrow: normal"
    return [star, Line2D([], [], ls="-.", color=ink, lw=1.0, label=label)]
