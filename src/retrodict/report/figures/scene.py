"""The scene from above, to scale: what was measured, and a sample of run-outs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from matplotlib.ticker import MaxNLocator

from retrodict.report.figures import drawing
from retrodict.report.figures.photograph import draw_photograph
from retrodict.report.figures.plan_evidence import draw_measured, measured_points
from retrodict.report.figures.plan_geometry import (
    WALL,
    area_of,
    barrier_outline,
    outline,
    wheel_paths,
)
from retrodict.report.figures.plan_signs import compass, scale_bar, uphill, write_name
from retrodict.scene.quantities import Units, unit_of
from retrodict.scene.records import Scene

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
_TALLEST = 0.9  # height over width of the plan
_ENDS = 12  # outlines drawn at the end of run-outs
_ON_THE_WAY = 6  # outlines of one draw between impact and rest, at most
_INTERVALS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # s, between these outlines
_GROUND = "#f1efe6"
_HATCHES = ("....", "////", "xxxx", "\\\\\\\\")


@drawing.styled
def scene_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """Scaled top view: surfaces, impact, measured poses and a fan of posterior run-outs."""
    return _from_above(findings.scene, units, outcome)


def plan_figure(scene: Scene, units: Units = "si") -> Figure:
    """Scaled top view of what was measured, before any run: surfaces, impact, measured poses.

    Args:
        scene: scene to draw.
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
    photographed = draw_photograph(axes, unit.worth)
    _surfaces(axes, scene, view, unit.worth, "none" if photographed else _GROUND)
    _barrier(axes, scene, view, unit.worth)
    # what has a name beside it needs no entry in the legend
    handles = _run_outs(axes, scene, paths, unit.worth)
    handles += _one_motion(axes, scene, outcome, unit.worth) if outcome else []
    handles += _second_contact(axes, outcome, unit.worth) if outcome else []
    handles += draw_measured(axes, scene, unit.worth)
    scale_bar(axes, view, unit.symbol)
    compass(axes, view)
    uphill(axes, scene, view)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(9, steps=drawing.STEPS))
    axes.set_xlabel(f"x ({unit.symbol})")
    axes.set_ylabel(f"y ({unit.symbol})")
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=4, handlelength=2.2)
    return figure


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
    points = [each / worth for each in measured_points(scene)]
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


def _surfaces(
    axes: Axes, scene: Scene, view: tuple[float, float, float, float], worth: float, colour: str
) -> None:
    in_metres = tuple(bound * worth for bound in view)
    for surface, hatch in zip(scene.surfaces[1:], _HATCHES * 9, strict=False):
        corners = area_of(surface, in_metres) / worth  # type: ignore[arg-type]
        if len(corners) >= 3:
            look: dict[str, Any] = {
                "facecolor": colour,
                "edgecolor": "#b5b09a",
                "hatch": hatch,
                "lw": 0.8,
            }
            axes.add_patch(Polygon(corners, zorder=0.1, **look))
            seen = np.clip(corners, [view[0], view[2]], [view[1], view[3]])
            write_name(axes, seen.mean(axis=0), _plain(surface.name))


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
        place = (
            struck
            + WALL / 2 / worth * away
            + 0.3 * (view[1] - view[0]) * np.array([-away[1], away[0]])
        )
    else:
        place = struck + (scene.barrier.diameter + 0.6) / worth * away
    write_name(axes, place, _plain(scene.barrier.name))


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
    """Outlines and wheel paths of the median draw between impact and rest."""
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


def _second_contact(axes: Axes, outcome: Outcome, worth: float) -> list[Artist]:
    """Where the vehicles touch again in the recorded motions."""
    from retrodict.findings.second_contact import second_contact  # a plan does not wait for it

    if (again := second_contact(outcome)) is None:
        return []
    look: dict[str, Any] = {"ls": "", "marker": "X", "ms": 7, "color": drawing.INK, "alpha": 0.45}
    axes.plot(*np.transpose(again.places) / worth, mew=0, zorder=8, **look)
    label = f"second contact, in {again.share:.0%} of the motions"
    return [Line2D([], [], label=label, **look)]


def _plain(text: str) -> str:
    """A name from the scene, so that matplotlib reads no formula and no hidden label in it."""
    return " " + text.replace("$", r"\$")
