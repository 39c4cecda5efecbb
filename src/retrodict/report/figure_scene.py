"""The scene from above, to scale: what was measured, and a sample of run-outs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, FancyArrowPatch, Patch, Polygon, Rectangle, Wedge
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from retrodict.report import drawing
from retrodict.scene.quantities import Units, unit_of
from retrodict.scene.records import Edge, Measured, Scene, Surface, Vehicle

if TYPE_CHECKING:
    from matplotlib.artist import Artist

    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

CAPTION = (
    "The scene from above, to scale, in the scene's own axes. Dashed outlines: the vehicles at "
    "impact as measured, each centre of gravity (+) placed by its lever from the impact centre. "
    "Solid outlines: the measured rest poses. Ellipses: the impact centre and the rest positions "
    "within two standard deviations in x and y, a run-out's own error included; an ellipse alone "
    "where no heading was measured. Numbered crosses: marks on the way to rest. Wedges at the centres "
    "of gravity and at marks: measured directions of travel, within two standard deviations. Diamonds: "
    "measured ends of rotation, with a line along a measured heading. Thin lines: paths of the centres "
    "of gravity in run-outs of posterior draws, with the outlines at the end of a dozen of them. Of the "
    "draw whose speed before the impact (that of B, of two vehicles) is the median: outlines on the way "
    "at equal times, and dotted lines along which its wheels went. A dark triangle marks a vehicle's "
    "front; an outline's middle is taken to lie midway between the axles."
)
_THICK = 0.6  # m: of a wall, as it is drawn
_TALLEST = 0.9  # height over width of the plan
_ENDS = 12  # outlines drawn at the end of run-outs
_ON_THE_WAY = 6  # outlines of one draw between impact and rest, at most
_INTERVALS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # s, between them
_HATCHES = ("....", "////", "xxxx", "\\\\\\\\")
_HALO = [patheffects.withStroke(linewidth=2.5, foreground="white")]
Pose = tuple[float, float, float]


@drawing.styled
def scene_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """Scaled top view: surfaces, impact, measured poses and a fan of posterior run-outs.

    Args:
        findings: of the reconstruction.
        outcome: its draws.
        units: "si" or "us".

    Returns:
        The figure.
    """
    return _from_above(findings.scene, units, outcome)


def plan_figure(scene: Scene, units: Units = "si") -> Figure:
    """Scaled top view of what was measured, before any run: surfaces, impact, measured poses.

    Args:
        scene: what was measured.
        units: "si" or "us".

    Returns:
        The figure.
    """
    with mpl.rc_context(drawing.STYLE):
        return _from_above(scene, units)


def _from_above(scene: Scene, units: Units, outcome: Outcome | None = None) -> Figure:
    unit = unit_of("length", units)
    paths = _paths(outcome, unit.worth) if outcome else {}
    view = _view(scene, paths, unit.worth)
    width, height = view[1] - view[0], view[3] - view[2]
    figure = drawing.new_figure(7.2, float(np.clip(6.4 * height / width, 2.6, 7.4)) + 1.5)
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_xlim(view[0], view[1])
    axes.set_ylim(view[2], view[3])
    _surfaces(axes, scene, view, unit.worth)
    _barrier(axes, scene, view, unit.worth)
    # what has a name beside it needs no entry in the legend
    handles = _run_outs(axes, scene, paths, unit.worth)
    handles += _one_motion(axes, scene, outcome, unit.worth) if outcome else []
    handles += _vehicles(axes, scene, unit.worth)
    _skids(axes, scene, unit.worth)
    handles += _directions(axes, scene, unit.worth)
    _marks(axes, scene, unit.worth)
    handles += _rotations(axes, scene, unit.worth)
    handles += _contact(axes, scene, unit.worth)
    _scale_bar(axes, view, unit.symbol)
    _compass(axes, view)
    _uphill(axes, scene, view)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(9, steps=drawing.STEPS))
    axes.set_xlabel(f"x ({unit.symbol})")
    axes.set_ylabel(f"y ({unit.symbol})")
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=4, handlelength=2.2)
    return figure


def impact_pose(scene: Scene, vehicle: str) -> Pose:
    """A vehicle's measured pose at impact: the impact centre less the lever to it (m, rad)."""
    v = scene.vehicles[vehicle]
    angle = v.heading.value + v.impact_angle.value
    x = scene.contact.x.value - v.impact_distance.value * np.cos(angle)
    y = scene.contact.y.value - v.impact_distance.value * np.sin(angle)
    return float(x), float(y), v.heading.value


def outline(vehicle: Vehicle, pose: Pose) -> np.ndarray:
    """Corners of a vehicle, then the three of its forward mark, shape (7, 2), in m."""
    # the record has no overhangs: the middle of the body is taken midway between the axles
    middle = (vehicle.front_axle.value - vehicle.rear_axle.value) / 2
    front, rear = middle + vehicle.length / 2, middle - vehicle.length / 2
    half = vehicle.width / 2
    body = np.array([
        [front, half], [rear, half], [rear, -half], [front, -half],
        [front, 0], [front - half, 0.3 * half], [front - half, -0.3 * half],
    ])  # fmt: skip
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return body @ np.array([[c, s], [-s, c]]) + np.array(pose[:2])


def barrier_outline(scene: Scene, reach: float) -> np.ndarray:
    """Corners of the barrier that A struck, in m: of a pole, or of a wall that reaches so far."""
    barrier, contact = scene.barrier, scene.contact
    assert barrier, "asked of a scene that has one"
    struck = np.array([contact.x.value, contact.y.value])
    normal = np.array([np.cos(contact.Gamma.value), np.sin(contact.Gamma.value)])
    normal *= np.copysign(1.0, (struck - impact_pose(scene, "a")[:2]) @ normal)  # away from A
    if barrier.kind == "pole":
        turn = np.linspace(0, 2 * np.pi, 36, endpoint=False)
        around = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return struck + barrier.diameter / 2 * (normal + around)
    along = reach * np.array([-normal[1], normal[0]])
    behind = _THICK * normal
    return struck + np.array([along, -along, behind - along, behind + along])


def area_of(surface: Surface, view: tuple[float, float, float, float]) -> np.ndarray:
    """Corners of what is to be drawn of a surface in a view (x0, x1, y0, y1 in m), shape (any, 2).

    None of the road, nor of a surface that lies beyond the view. An outline is drawn as measured, and
    reaches as far as it does.
    """
    if surface.edge is not None:
        return half_plane(surface.edge, view)
    x0, x1, y0, y1 = view
    corners = np.array(surface.outline.corners if surface.outline else []).reshape(-1, 2)
    seen = len(corners) and Path(corners).intersects_bbox(Bbox([[x0, y0], [x1, y1]]))
    return corners if seen else corners[:0]


def half_plane(edge: Edge, view: tuple[float, float, float, float]) -> np.ndarray:
    """The part of a view (x0, x1, y0, y1 in m) beyond an edge, as a polygon's corners."""
    x0, x1, y0, y1 = view
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    sign = 1.0 if edge.side == "left" else -1.0
    inward = sign * np.array([-np.sin(edge.direction), np.cos(edge.direction)])
    origin = np.array([edge.x, edge.y]) + edge.offset.value * inward
    depth = (corners - origin) @ inward
    kept = []
    for i in range(4):
        j = (i + 1) % 4
        if depth[i] >= 0:
            kept.append(corners[i])
        if depth[i] * depth[j] < 0:
            share = depth[i] / (depth[i] - depth[j])
            kept.append(corners[i] + share * (corners[j] - corners[i]))
    return np.array(kept).reshape(-1, 2)


def _paths(outcome: Outcome, worth: float) -> dict[str, np.ndarray]:
    """Finite run-outs (path, step, pose) of each vehicle, lengths in the printed unit."""
    tree = outcome.idata
    # the variable has the name of its first dimension, so xarray counts it as a coordinate
    if "trajectories" not in tree.children or "path" not in tree["trajectories"]:
        return {}
    data = tree["trajectories"]["path"].transpose("vehicle", "run", "step", "pose").values
    data = data / np.array([worth, worth, 1.0])
    found = dict(zip(outcome.scene.vehicles, data, strict=True))
    return {v: paths[np.isfinite(paths).all(axis=(1, 2))] for v, paths in found.items()}


def _view(
    scene: Scene, paths: dict[str, np.ndarray], worth: float
) -> tuple[float, float, float, float]:
    points = [outline(scene.vehicles[v], impact_pose(scene, v)) / worth for v in scene.vehicles]
    points += [_rest_points(scene, v) / worth for v in scene.rest]
    points += [np.array([[m.x, m.y] for m in marks]) / worth for marks in scene.marks.values()]
    points += [np.array([[x, y]]) / worth for _, x, y, _ in _ends_of_rotation(scene)]
    points += [each / worth for each in _contact_lines(scene)]
    points += [lines.reshape(-1, 2) / worth for _, lines in skid_lines(scene)]
    points += [barrier_outline(scene, 0.0) / worth] if scene.barrier else []
    # the odd run-out that ends far away must not shrink the rest to a dot
    for v, runs in paths.items():
        if runs.size:
            ends = np.quantile(runs[..., :2], [0.02, 0.98], axis=(0, 1))
            # a measured outline makes room for those at the end of run-outs; else their length does
            outlined = v in scene.rest and scene.rest[v].heading
            room = 0.0 if outlined else 0.5 * scene.vehicles[v].length / worth
            points.append(ends + np.array([[-room], [room]]))
    both = np.concatenate(points)
    low, high = both.min(axis=0), both.max(axis=0)
    # as wide as the paper, and no taller than a page
    lacking = max(0.0, (high - low)[1] / _TALLEST - (high - low)[0]) / 2
    aside = np.array([lacking, 0.0])
    low, high = low - aside, high + aside
    margin = 0.07 * (high - low).max() + 1.0 / worth
    return low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin


def _rest_points(scene: Scene, v: str) -> np.ndarray:
    """The corners at rest, or the centre of gravity alone where no heading was measured."""
    rest = scene.rest[v]
    if rest.heading is None:
        return np.array([[rest.x.value, rest.y.value]])
    return outline(scene.vehicles[v], (rest.x.value, rest.y.value, rest.heading.value))


def _name(axes: Axes, at: np.ndarray, text: str, colour: str = drawing.INK) -> None:
    """Write what a thing is beside it; nothing of it reaches beyond the axes."""
    axes.text(
        float(at[0]), float(at[1]), text, color=colour, size=8, ha="center", va="center", zorder=9.2,
        path_effects=_HALO, clip_on=True,
    )  # fmt: skip


def _surfaces(
    axes: Axes, scene: Scene, view: tuple[float, float, float, float], worth: float
) -> None:
    in_metres = tuple(bound * worth for bound in view)
    for surface, hatch in zip(scene.surfaces[1:], _HATCHES * 9, strict=False):
        corners = area_of(surface, in_metres) / worth  # type: ignore[arg-type]
        if len(corners) >= 3:
            look: dict[str, Any] = {
                "facecolor": "#f1efe6",
                "edgecolor": "#b5b09a",
                "hatch": hatch,
                "lw": 0.8,
            }
            axes.add_patch(Polygon(corners, zorder=0.1, **look))
            seen = np.clip(corners, [view[0], view[2]], [view[1], view[3]])
            _name(axes, seen.mean(axis=0), _plain(surface.name))


def _barrier(
    axes: Axes, scene: Scene, view: tuple[float, float, float, float], worth: float
) -> None:
    if scene.barrier is None:
        return
    look: dict[str, Any] = {"facecolor": drawing.PALE, "edgecolor": drawing.INK, "lw": 0.8}
    reach = float(np.hypot(view[1] - view[0], view[3] - view[2])) * worth
    corners = barrier_outline(scene, reach) / worth
    axes.add_patch(Polygon(corners, zorder=1.5, **look))
    struck = np.array([scene.contact.x.value, scene.contact.y.value]) / worth
    behind = corners.mean(axis=0) - struck
    away = behind / max(float(np.hypot(*behind)), 1e-9)
    if scene.barrier.kind == "wall":
        normal = np.array([np.cos(scene.contact.Gamma.value), np.sin(scene.contact.Gamma.value)])
        away = normal * np.copysign(1.0, normal @ behind)
        at = (
            struck
            + _THICK / 2 / worth * away
            + 0.3 * (view[1] - view[0]) * np.array([-away[1], away[0]])
        )
    else:
        at = struck + (scene.barrier.diameter + 0.6) / worth * away
    _name(axes, at, _plain(scene.barrier.name))


def _run_outs(axes: Axes, scene: Scene, paths: dict[str, np.ndarray], worth: float) -> list[Artist]:
    handles: list[Artist] = []
    for v, runs in paths.items():
        if not runs.size:
            continue
        colour, line = drawing.OF_VEHICLE[v], drawing.LINE_OF_VEHICLE[v]
        axes.add_collection(
            LineCollection(
                list(runs[..., :2]), colors=colour, linestyles=[line], lw=0.6, alpha=0.35, zorder=2
            ),
            autolim=False,
        )
        few = np.linspace(0, len(runs) - 1, min(_ENDS, len(runs))).astype(int)
        ends = [
            outline(scene.vehicles[v], (x * worth, y * worth, heading))[:4] / worth
            for x, y, heading in runs[few, -1]
        ]
        axes.add_collection(
            PolyCollection(
                ends, facecolors="none", edgecolors=colour, lw=0.5, alpha=0.45, zorder=2
            ),
            autolim=False,
        )
        label = f"paths of {v.upper()} in draws"
        handles.append(Line2D([], [], color=colour, ls=line, lw=1.0, label=label))
    return handles


def _one_motion(axes: Axes, scene: Scene, outcome: Outcome, worth: float) -> list[Artist]:
    """Outlines and wheels of the median draw on its way."""
    from retrodict.findings.run_outs import motions  # a plan does not wait for it

    found = motions(outcome, 1)
    if not found:
        return []
    motion = found[0]
    lasts = motion.lasts
    wanted = (each for each in _INTERVALS if lasts / each <= _ON_THE_WAY + 1)
    interval = next(wanted, lasts / (_ON_THE_WAY + 1))
    for v, time in motion.time.items():
        vehicle, colour = scene.vehicles[v], drawing.OF_VEHICLE[v]
        wheels = wheel_paths(vehicle, motion.pose[v]) / worth
        axes.add_collection(
            LineCollection(
                list(wheels), colors=drawing.INK, linestyles=[(0, (1, 1.6))], lw=0.7, zorder=2.5
            ),
            autolim=False,
        )
        between = [
            outline(vehicle, motion.pose_at(v, t)) / worth
            for t in np.arange(interval, time[-1] - interval / 4, interval)
        ]
        bodies = [corners[:4] for corners in between]
        fronts = [corners[4:] for corners in between]
        look: dict[str, Any] = {"edgecolors": colour, "lw": 0.9, "zorder": 3}
        axes.add_collection(PolyCollection(bodies, facecolors="none", **look), autolim=False)
        axes.add_collection(PolyCollection(fronts, facecolors="none", **look), autolim=False)
    every = f"one draw, every {interval:.1g} s"
    return [
        Patch(fill=False, ec=drawing.INK, lw=0.9, label=every),
        Line2D([], [], color=drawing.INK, ls=(0, (1, 1.6)), lw=0.9, label="wheels of that draw"),
    ]


def wheel_paths(vehicle: Vehicle, pose: np.ndarray) -> np.ndarray:
    """Where the four wheels went, shape (4, steps, 2) for poses (steps, 3), in m."""
    front, rear, half = vehicle.front_axle.value, vehicle.rear_axle.value, vehicle.track.value / 2
    places = np.array([[front, half], [front, -half], [-rear, half], [-rear, -half]])
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    ahead, left = np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)
    return np.array([pose[:, :2] + u * ahead + w * left for u, w in places])


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
            color=drawing.OF_VEHICLE[v], size=8, weight="bold", zorder=8, path_effects=_HALO,
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
        weight="bold", zorder=z + 3, path_effects=_HALO,
    )  # fmt: skip


def skid_lines(scene: Scene) -> list[tuple[str, np.ndarray]]:
    """Where the wheels of each side of a vehicle skidded up to the impact: both ends, m, (2, 2, 2)."""
    found = []
    for v in scene.skidded:
        own, vehicle = scene.approach[v], scene.vehicles[v]
        assert own.skid is not None, "it skidded"
        angle = (own.direction or vehicle.heading).value
        ahead = np.array([np.cos(angle), np.sin(angle)])
        aside = np.array([-ahead[1], ahead[0]]) * vehicle.track.value / 2
        centre = np.array(scene.at_impact(v))
        begin = centre - own.skid.value * ahead
        found.append((v, np.array([[begin + side, centre + side] for side in (aside, -aside)])))
    return found


def _skids(axes: Axes, scene: Scene, worth: float) -> None:
    """The measured skids up to the impact, along the direction of travel."""
    look: dict[str, Any] = {"lw": 3.5, "alpha": 0.35, "solid_capstyle": "butt"}
    for v, sides in skid_lines(scene):
        for begin, end in sides / worth:
            axes.plot(*zip(begin, end, strict=True), color=drawing.OF_VEHICLE[v], zorder=2, **look)
        _name(axes, sides.mean(axis=(0, 1)) / worth, f"skid of {v.upper()}", drawing.OF_VEHICLE[v])


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


def _marks(axes: Axes, scene: Scene, worth: float) -> None:
    """The measured points on the way to rest, numbered as the evidence is."""
    look: dict[str, Any] = {"ls": "", "marker": "x", "ms": 5, "mew": 1.4}
    for v, marks in scene.marks.items():
        colour = drawing.OF_VEHICLE[v]
        for number, mark in enumerate(marks, start=1):
            at = (mark.x / worth, mark.y / worth)
            axes.plot(*at, color=colour, zorder=8, **look)
            axes.annotate(
                f"mark {v.upper()}{number}", at, xytext=(4, 4), textcoords="offset points", size=8,
                color=colour, zorder=8, path_effects=_HALO,
            )  # fmt: skip


def _ends_of_rotation(scene: Scene) -> list[tuple[str, float, float, Measured | None]]:
    """Vehicle, x, y and heading of each of which both coordinates were measured."""
    ends = scene.end_of_rotation.items()
    return [(v, e.x.value, e.y.value, e.heading) for v, e in ends if e.x and e.y]


def _rotations(axes: Axes, scene: Scene, worth: float) -> list[Artist]:
    """The measured ends of rotation."""
    look: dict[str, Any] = {"ls": "", "marker": "D", "ms": 4.5, "mfc": "white", "mew": 1.2}
    ends = _ends_of_rotation(scene)
    for v, x, y, heading in ends:
        colour = drawing.OF_VEHICLE[v]
        if heading:
            reach, angle = scene.vehicles[v].length / 2, heading.value
            tip = np.array([[x, y], [x + reach * np.cos(angle), y + reach * np.sin(angle)]])
            axes.plot(*tip.T / worth, color=colour, lw=1.2, zorder=8)
        axes.plot(x / worth, y / worth, mec=colour, zorder=8, **look)
    handle = Line2D([], [], mec=drawing.INK, label="end of rotation, measured", **look)
    return [handle] if ends else []


def _contact_lines(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """The contact line and its normal, from end to end, in m."""
    at = np.array([scene.contact.x.value, scene.contact.y.value])
    c, s = np.cos(scene.contact.Gamma.value), np.sin(scene.contact.Gamma.value)
    half = 0.45 * max(v.length for v in scene.vehicles.values())
    return at + half * np.array([[s, -c], [-s, c]]), at + half * np.array([[0, 0], [c, s]])


def _contact(axes: Axes, scene: Scene, worth: float) -> list[Artist]:
    x, y = scene.contact.x.value / worth, scene.contact.y.value / worth
    size = [4 * m.sd / worth for m in (scene.contact.x, scene.contact.y)]
    if min(size) > 0:
        axes.add_patch(Ellipse((x, y), *size, fc=(1, 1, 1, 0.45), ec=drawing.INK, lw=1.1, zorder=8))
    line, normal = (ends / worth for ends in _contact_lines(scene))
    ink = drawing.INK
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
    axes.plot(x, y, "*", color="white", mec=ink, ms=10, mew=0.9, zorder=9)
    return [
        Line2D([], [], ls="", marker="*", color="white", mec=ink, ms=10, label="impact centre"),
        Line2D([], [], ls="-.", color=ink, lw=1.0, label="contact line (Γ), arrow: normal"),
    ]


def _scale_bar(axes: Axes, view: tuple[float, float, float, float], symbol: str) -> None:
    width = view[1] - view[0]
    fits = [step * 10.0**k for k in range(-1, 5) for step in (1, 2, 5) if step * 10**k < width / 4]
    length = max(fits, default=1.0)
    x = view[0] + 0.03 * width
    y = view[2] + 0.03 * width
    _on_white(axes, (x - 0.012 * width, y - 0.015 * width), length + 0.024 * width, 0.06 * width)
    axes.plot([x, x + length], [y, y], color=drawing.INK, lw=2.5, solid_capstyle="butt", zorder=10)
    axes.text(
        x + length / 2, y + 0.008 * width, f"{length:g} {symbol}", ha="center", va="bottom",
        zorder=10, path_effects=_HALO,
    )  # fmt: skip


def _compass(axes: Axes, view: tuple[float, float, float, float]) -> None:
    """The scene's axes, in the upper right corner."""
    reach = 0.07 * (view[1] - view[0])
    x, y = view[1] - 1.7 * reach, view[3] - 1.7 * reach
    _on_white(axes, (x - 0.2 * reach, y - 0.2 * reach), 1.7 * reach, 1.7 * reach)
    look: dict[str, Any] = {"ha": "center", "va": "center", "zorder": 10}
    for name, (along_x, along_y) in {"x": (reach, 0.0), "y": (0.0, reach)}.items():
        arrow = FancyArrowPatch(
            (x, y), (x + along_x, y + along_y), arrowstyle="-|>", mutation_scale=8,
            color=drawing.INK, lw=1.2, shrinkA=0, shrinkB=0, zorder=10,
        )  # fmt: skip
        axes.add_patch(arrow)
        axes.text(x + 1.25 * along_x, y + 1.25 * along_y, name, **look)


def _uphill(axes: Axes, scene: Scene, view: tuple[float, float, float, float]) -> None:
    """Where the road rises, and how steeply, in the upper left corner."""
    if scene.slope is None:
        return
    reach = 0.07 * (view[1] - view[0])
    x, y, turn = view[0] + 1.2 * reach, view[3] - 1.2 * reach, scene.slope.uphill.value
    along = np.array([np.cos(turn), np.sin(turn)]) * reach / 2
    _on_white(axes, (x - reach, y - 1.2 * reach), 2 * reach, 2 * reach)
    arrow = FancyArrowPatch(
        (x - along[0], y - along[1]), (x + along[0], y + along[1]), arrowstyle="-|>",
        mutation_scale=8, color=drawing.INK, lw=1.2, shrinkA=0, shrinkB=0, zorder=10,
    )  # fmt: skip
    axes.add_patch(arrow)
    text = f"uphill {100 * scene.slope.grade.value:.2g} %"
    axes.text(x, y - 0.6 * reach, text, ha="center", va="top", zorder=10)


def _on_white(axes: Axes, corner: tuple[float, float], width: float, height: float) -> None:
    """A white ground, so that no hatch runs through what is drawn on it."""
    axes.add_patch(Rectangle(corner, width, height, fc="white", ec="none", alpha=0.85, zorder=9.5))


def _plain(text: str) -> str:
    """A name from the scene, so that matplotlib reads no formula and no hidden label in it."""
    return " " + text.replace("$", r"\$")
