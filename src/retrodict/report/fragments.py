"""Fragments of HTML for notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from retrodict.findings.inputs import ASSUMED, InputRow
from retrodict.findings.sentences import MARK, NOT_TO_BE_RELIED_ON
from retrodict.findings.statistics import LEVELS
from retrodict.report.results import result_rows
from retrodict.report.templates import template
from retrodict.scene.quantities import Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.scene.records import Scene


def scene_html(scene: Scene, units: Units = "si") -> str:
    """A scene as a small HTML table, for notebooks.

    Args:
        scene: scene to show.
        units: "si" or "us".

    Returns:
        A fragment; every text of the scene is escaped.
    """
    rows = []
    for name, m in (scene.stated() | scene.evidence()).items():
        row = InputRow(name, "input", m)
        of_model = f" (a run-out misses {row.format_model(units)})" if m.model_sd else ""
        measured = f"{row.format_measured(units)}{of_model}"
        rows.append((row.label, measured, row.unit(units), m.source, ASSUMED[m.assumed]))
    return template("scene.html.j2").render(scene=scene, rows=rows)


def findings_html(findings: Findings, units: Units = "si") -> str:
    """A reconstruction's results and verdict as a small HTML table, for notebooks.

    Args:
        findings: findings of the reconstruction.
        units: "si" or "us".

    Returns:
        A fragment; every text of the scene is escaped.
    """
    return template("findings.html.j2").render(
        findings=findings,
        scene=findings.scene,
        description=findings.description,
        checks=findings.checks,
        answer=findings.answers[units],
        levels=LEVELS,
        mark=MARK,
        warning=NOT_TO_BE_RELIED_ON,
        rows=result_rows(findings, units),
    )
