"""The scene from above as the layers of a drawing: what was measured, and the posterior's motions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from retrodict.findings.run_outs import Motion, motion_of, motions
from retrodict.findings.sentences import NOT_TO_BE_RELIED_ON
from retrodict.interchange.plan_drawing import (
    Drawing,
    Ellipse,
    Layer,
    Line,
    Point,
    Shape,
    Text,
    edge_within,
)
from retrodict.report.figures import drawing
from retrodict.report.figures.plan_geometry import (
    barrier_outline,
    contact_lines,
    ends_of_rotation,
    impact_pose,
    outline,
    wheel_paths,
)
from retrodict.scene.records import Scene, Surface

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

_WITHIN = 2  # standard deviations, of ellipses
_WALL = 5.0  # m, length of a wall on each side of the impact
_ASIDE = 0.25  # m, offset of a label from its point in x and y
_SOIL = "#8a8468"


def scene_drawing(
    findings: Findings, outcome: Outcome, draw: str | int = "median", before: float = 1.0
) -> Drawing:
    """The scene with measured poses and errors, and paths of vehicles and wheels in posterior draws.

    Args:
        findings: findings of the reconstruction.
        outcome: outcome of the reconstruction, with its draws.
        draw: draw whose approach, run-out and wheel paths have layers of their own, as `which` of
            `motion_of`.
        before: duration of the approach that is drawn, s.

    Returns:
        The drawing, in the scene's axes; without paths where no motion is recorded. Names of a
        vehicle's layers begin with its letter.

    Raises:
        NoMotion: motions are recorded, but there is no such draw.
    """
    scene, found = findings.scene, motions(outcome)
    chosen = motion_of(found, draw) if found else None
    layers: list[Layer] = []
    if chosen:
        layers += [each for v in scene.vehicles for each in _moved(scene, v, chosen, found, before)]
    layers += [each for v in scene.vehicles for each in _measured(scene, v)]
    if scene.barrier:
        area = barrier_outline(scene, _WALL)
        layers.append(Layer("BARRIER", drawing.INK, (Line(area, closed=True),)))
    layers += [_contact(scene), Layer("LABELS", drawing.INK, tuple(_labels(scene)))]
    layers = [layer for layer in layers if layer.shapes]
    bounds = Drawing("", tuple(layers)).bounds
    if surfaces := [shape for each in scene.surfaces for shape in _surface(each, bounds)]:
        layers.insert(0, Layer("SURFACES", _SOIL, tuple(surfaces)))
    layers.append(_notes(findings, chosen, Drawing("", tuple(layers)).bounds))
    return Drawing(scene.title, tuple(layers))


def _surface(surface: Surface, bounds: tuple[float, float, float, float]) -> list[Shape]:
    """A surface's edge within the circle about a rectangle, or its whole outline, with a label."""
    if surface.outline is not None:
        corners = surface.outline.corners
        label = Text(corners[0], f"{surface.name}: within this outline")
        return [Line(np.array(corners), closed=True), label]
    if (edge := surface.edge) is None:
        return []
    side = math.pi / 2 if edge.side == "left" else -math.pi / 2
    inward = np.array([math.cos(edge.direction + side), math.sin(edge.direction + side)])
    x, y = (np.array([edge.x, edge.y]) + edge.offset.value * inward).tolist()
    if (line := edge_within((x, y), edge.direction, bounds)) is None:
        return []
    tx, ty = line.points[0].tolist()
    return [line, Text((tx, ty), f"{surface.name}: {edge.side} of this edge")]


def _measured(scene: Scene, v: str) -> list[Layer]:
    name, colour, vehicle = v.upper(), drawing.OF_VEHICLE[v], scene.vehicles[v]
    at_impact = _outlined(outline(vehicle, impact_pose(scene, v)))
    at_rest: list[Shape] = []
    error: list[Shape] = []
    if (rest := scene.rest.get(v)) is not None:
        x, y = rest.x.value, rest.y.value
        evidence = scene.evidence()
        error += _within((x, y), evidence[f"rest_x_{v}"].sd, evidence[f"rest_y_{v}"].sd)
        at_rest.append(Point((x, y)))
        if rest.heading is not None:
            at_rest += _outlined(outline(vehicle, (x, y, rest.heading.value)))
    marks: list[Shape] = []
    for number, mark in enumerate(scene.marks.get(v, ()), start=1):
        marks += [Point((mark.x, mark.y)), _label((mark.x, mark.y), f"{name}{number}")]
    for whose, x, y, _ in ends_of_rotation(scene):
        if whose == v:
            marks += [Point((x, y)), _label((x, y), f"{name} end of rotation")]
    return [
        Layer(f"{name}-IMPACT", colour, tuple(at_impact), dashed=True),
        Layer(f"{name}-REST", colour, tuple(at_rest)),
        Layer(f"{name}-REST-ERROR", drawing.INK, tuple(error)),
        Layer(f"{name}-MARKS", colour, tuple(marks)),
    ]


def _moved(
    scene: Scene, v: str, chosen: Motion, found: tuple[Motion, ...], before: float
) -> list[Layer]:
    name, colour = v.upper(), drawing.OF_VEHICLE[v]
    run_out = chosen.pose[v]
    approach = chosen.poses(v, np.array([-before, 0.0]))[:, :2]
    wheels = tuple(Line(path) for path in wheel_paths(scene.vehicles[v], run_out))
    others = tuple(Line(motion.pose[v][:, :2]) for motion in found)
    return [
        Layer(f"{name}-RUN-OUTS", drawing.PALE, others),
        Layer(f"{name}-WHEELS", drawing.GREY, wheels),
        Layer(f"{name}-APPROACH", colour, (Line(approach),) if before else ()),
        Layer(f"{name}-RUN-OUT", colour, (Line(run_out[:, :2]),)),
    ]


def _contact(scene: Scene) -> Layer:
    """The impact centre with its error, and the contact line."""
    contact = scene.contact
    place = (contact.x.value, contact.y.value)
    shapes: tuple[Shape, ...] = (
        Point(place),
        *_within(place, contact.x.sd, contact.y.sd),
    )
    if "impact.contact_line" not in scene.unwritten:
        shapes += (Line(contact_lines(scene)[0]),)
    return Layer("IMPACT-POINT", drawing.INK, shapes)


def _within(place: tuple[float, float], sd_x: float, sd_y: float) -> list[Shape]:
    """Two standard deviations about a point: an ellipse, or a line where one of them is 0."""
    half = np.array([_WITHIN * sd_x, _WITHIN * sd_y])
    if half.min() > 0:
        return [Ellipse(place, (float(half[0]), float(half[1])))]
    return [Line(np.array(place) + np.outer([-1.0, 1.0], half))] if half.max() > 0 else []


def _outlined(corners: np.ndarray) -> list[Shape]:
    return [Line(corners[:4], closed=True), Line(corners[4:], closed=True)]


def _labels(scene: Scene) -> list[Shape]:
    labels = [_label((scene.contact.x.value, scene.contact.y.value), "impact")]
    for v in scene.vehicles:
        x, y, _ = impact_pose(scene, v)
        labels.append(_label((x, y), f"{v.upper()} impact"))
        if v in scene.rest:
            place = (scene.rest[v].x.value, scene.rest[v].y.value)
            labels.append(_label(place, f"{v.upper()} rest"))
    return labels


def _label(place: tuple[float, float], text: str) -> Shape:
    return Text((place[0] + _ASIDE, place[1] + _ASIDE), text)


def _notes(
    findings: Findings, chosen: Motion | None, bounds: tuple[float, float, float, float]
) -> Layer:
    """Notes below the drawing on what it shows."""
    lines = [findings.scene.title]
    lines += [f"{v.upper()}: {vehicle.name}" for v, vehicle in findings.scene.vehicles.items()]
    lines += [findings.scene.barrier.name] if findings.scene.barrier else []
    lines.append(f"metres; ellipses within {_WITHIN} standard deviations")
    if chosen:
        lines.append(f"run-out, approach and wheels of draw {chosen.number}")
    if not findings.checks.passed:
        lines.insert(0, f"{NOT_TO_BE_RELIED_ON}: checks of the draws failed")
    x, y = bounds[0], bounds[2]
    texts = tuple(Text((x, y - 0.6 * (row + 1)), line) for row, line in enumerate(lines))
    return Layer("NOTES", drawing.INK, texts)
