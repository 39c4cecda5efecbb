"""The replay: motions of a few posterior draws, to play and scrub in the HTML report."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from retrodict.findings.rounding import format_value
from retrodict.findings.run_outs import Motion, motions
from retrodict.report.figures.plan import Plan, View, bounds_of
from retrodict.report.figures.plan_geometry import impact_pose, outline, rest_outline
from retrodict.report.templates import template
from retrodict.scene.names import vehicle_of
from retrodict.scene.quantities import Units, unit_of
from retrodict.scene.records import Scene

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

_DRAWS = 9  # draws to choose from: odd, so that the median is among them
_ROWS = 33  # rows of each path, which is straight between them to a centimetre or so
_BEFORE = 1.0  # s of approach that are shown
_LEAD = 20  # rows of the approach along a skid
_MARGIN = 1.0  # m about what is drawn
_GHOSTS = 4  # outlines of the still picture between impact and rest


def replay_fragment(findings: Findings, outcome: Outcome, units: Units = "si") -> str:
    """A replay of a few posterior draws as an HTML fragment with a script of its own.

    Without scripts, and on paper, the fragment is a still picture of the median draw. It loads
    nothing. A page with a content security policy has to allow `replay_script_hash`.

    Args:
        findings: findings of the reconstruction.
        outcome: outcome of the reconstruction, with its draws.
        units: "si" or "us".

    Returns:
        The fragment; empty where no run-outs are recorded. Every text of the scene is escaped.
    """
    found = motions(outcome, _DRAWS)
    if not found:
        return ""
    scene, median = findings.scene, found[len(found) // 2]
    plan = Plan(_view(scene, found))
    placed = plan.at
    speed = unit_of("speed", units)
    content: dict[str, Any] = {
        "passed": findings.checks.passed,
        "width": plan.width,
        "height": plan.height,
        "surfaces": plan.surfaces(scene),
        "impact": placed(np.array([scene.contact.x.value, scene.contact.y.value])).split(","),
        "bar": plan.scale_bar(units),
        "vehicles": [
            {
                "name": v,
                "title": scene.vehicles[v].name,
                "paths": [placed(m.pose[v]) for m in found],
                "path": placed(median.pose[v]),
                "still": [placed(corners) for corners in _still(scene, median, v)],
                "label": placed(median.pose[v][-1]).split(","),
                "rest": placed(rest_outline(scene, v)[:4]) if v in scene.rest else "",
                # the moving outline, about its centre of gravity and heading to the right
                "body": _body(scene, v, plan.scale),
            }
            for v in scene.vehicles
        ],
        "barrier": plan.barrier(scene),
        "sought": str(vehicle_of(scene.sought)).upper(),
        "draws": [_in_words(m, units) for m in found],
        "chosen": len(found) // 2,
        "before": _BEFORE,
        "data": _data(found, plan.view, plan.scale, speed.worth, speed.symbol),
        "script": Markup(_script()),
    }
    return template("replay.html.j2").render(content)


def replay_script_hash() -> str:
    """The replay's script as a source of `script-src` in a content security policy."""
    digest = hashlib.sha256(_script().encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"


def _data(found: tuple[Motion, ...], view: View, scale: float, worth: float, symbol: str) -> Markup:
    """Times (s), places (units of the drawing) and headings (degrees) as JSON for a script element."""

    def rows(motion: Motion, v: str) -> list[list[float]]:
        pick = np.linspace(0, len(motion.time[v]) - 1, _ROWS).round().astype(int)
        time, (x, y, heading) = motion.time[v][pick], motion.pose[v][pick].T
        # a vehicle comes in straight, and slows down along its skid
        lead = np.linspace(-_BEFORE, 0.0, _LEAD if v in motion.skid else 1, endpoint=False)
        x0, y0, heading0 = motion.poses(v, lead).T
        x, y, heading = np.append(x0, x), np.append(y0, y), np.append(heading0, heading)
        columns = (
            np.append(lead, time).round(3),
            ((x - view[0]) * scale).round(1),
            ((view[3] - y) * scale).round(1),
            np.degrees(-heading).round(1),
        )
        return [column.tolist() for column in columns]

    content = {
        "before": _BEFORE,
        "scale": scale * worth,
        "unit": symbol,
        "draws": [
            {"lasts": round(m.lasts, 3), "rows": {v: rows(m, v) for v in m.pose}} for m in found
        ],
    }
    text = json.dumps(content, allow_nan=False, separators=(",", ":"))
    # no text in it is a user's, and yet none could end the element
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _in_words(motion: Motion, units: Units) -> str:
    unit = unit_of("speed", units)
    speeds = (
        f"{v.upper()} {format_value(motion.speed[v] / unit.worth, 1)} {unit.symbol}"
        for v in motion.speed
    )
    return ", ".join(speeds)


def _view(scene: Scene, found: tuple[Motion, ...]) -> View:
    """Bounds of the picture, in m: the paths of all draws, and the vehicles at both ends."""
    points = [rest_outline(scene, v) for v in scene.rest]
    for v in scene.vehicles:
        points.append(outline(scene.vehicles[v], impact_pose(scene, v)))
        for m in found:
            points += [m.pose[v][:, :2], outline(scene.vehicles[v], m.pose_at(v, m.lasts))]
        # half of the approach: all of it would shrink the rest of the picture
        median = found[len(found) // 2]
        points.append(median.poses(v, np.array([-_BEFORE / 2]))[:, :2])
    return bounds_of(points, _MARGIN)


def _still(scene: Scene, motion: Motion, v: str) -> list[np.ndarray]:
    """Outlines of a draw from impact to rest."""
    times = np.linspace(0, motion.time[v][-1], _GHOSTS + 2)
    return [outline(scene.vehicles[v], motion.pose_at(v, t))[:4] for t in times]


def _body(scene: Scene, v: str, scale: float) -> dict[str, str]:
    corners = outline(scene.vehicles[v], (0.0, 0.0, 0.0)) * [scale, -scale]
    texts = [f"{x:.1f},{y:.1f}" for x, y in corners]
    return {"box": " ".join(texts[:4]), "front": " ".join(texts[4:])}


@cache
def _script() -> str:
    return files("retrodict.report").joinpath("replay.js").read_text("utf-8")
