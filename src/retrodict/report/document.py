"""The report: one HTML file that needs nothing else, and fragments for notebooks."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from retrodict.findings.inputs import InputRow
from retrodict.findings.rounding import NOTHING, format_value, format_with_sd
from retrodict.findings.sentences import MARK, NOT_TO_BE_RELIED_ON, WITHHELD
from retrodict.findings.statistics import LEVELS, scaled
from retrodict.inference.digits import decimals_of, rhat_text
from retrodict.report.files import write_whole
from retrodict.report.ladder import headings, ladder_rows
from retrodict.report.results import marked, result_rows
from retrodict.scene.quantities import Units, label_and_unit, unit_of
from retrodict.scene.records import VEHICLES
from retrodict.studies.conflict import MIN_PROBABILITY

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.findings.statistics import Quantity
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Scene

Drawn = Callable[[], dict[str, bytes]]  # figures' images by name

_SYSTEMS: dict[Units, str] = {"si": "SI", "us": "US customary"}
_ASSUMED = {"": "", "sd": "uncertainty assumed", "value": "value and uncertainty assumed"}

_MAX_NARROWING = 8  # quantities that would narrow an answer

COMMAND = "retrodict reconstruct scene.toml"  # and the options that make the same numbers

# left to the expert: these are never invented
FIELDS = (
    "Name, position and organisation",
    "Qualifications, and publications of the last ten years",
    "Testimony given in the last four years",
    "Compensation",
    "Instructed by, and the question put",
    "Propositions compared, and the likelihood ratio",
    "Duty to the court and declaration of truth",
    "Place and date",
    "Signature",
)


def report_html(
    findings: Findings,
    outcome: Outcome,
    units: Units = "si",
    drawn: Drawn | None = None,
) -> str:
    """The whole report as one HTML page with its figures in it.

    Args:
        findings: of the reconstruction.
        outcome: its draws, for the figures.
        units: which come first, and which the inputs and figures are printed in.
        drawn: gives the figures' images, where they are drawn elsewhere; called last.

    Returns:
        The page; it has no scripts and loads nothing.
    """
    # matplotlib is slow to import, and notebooks' fragments do without it
    from retrodict.report.figures import FIGURES, images

    other: Units = "us" if units == "si" else "si"
    system_order: tuple[Units, ...] = (units, other)
    ladder = findings.ladder
    content = _common(findings, units) | {
        "systems": [_SYSTEMS[system] for system in system_order],
        "results": _side_by_side(findings, system_order, findings.quantities),
        "derived": _side_by_side(findings, system_order, findings.derived),
        "inputs": _input_cells(findings, units, "input"),
        "evidence": _input_cells(findings, units, "evidence"),
        "assumptions": findings.assumptions,
        "marks": _marks(findings.scene, units),
        "left_out": _left_out(findings, units),
        "min_probability": MIN_PROBABILITY,
        "narrowed": _narrowed(findings, units),
        "speed_unit": unit_of("speed", units).symbol,
        "size": _size(findings),
        "max_rhat": rhat_text(findings.checks.max_rhat),
        "min_ess_bulk": format_value(findings.checks.min_ess_bulk, 0),
        "min_ess_tail": format_value(findings.checks.min_ess_tail, 0),
        "format_value": format_value,
        "command": _command(findings),
        "sha256": hashlib.sha256(findings.scene.text.encode()).hexdigest(),
        "fields": FIELDS,
        "ladder": ladder,
        "ladder_headings": headings(ladder, units) if ladder else (),
        "ladder_rows": ladder_rows(ladder, units) if ladder else (),
    }
    template = _template("report.html.j2")
    of_figure = drawn() if drawn else images(findings, outcome, units)
    figures = [
        {
            "title": figure.title,
            "caption": figure.caption,
            "image": base64.b64encode(of_figure[name]).decode("ascii"),
        }
        for name, figure in FIGURES.items()
    ]
    return template.render(**content, figures=figures)


def write_report(findings: Findings, outcome: Outcome, path: Path, units: Units = "si") -> Path:
    """Write the report, whole or not at all.

    Args:
        findings: of the reconstruction.
        outcome: its draws, for the figures.
        path: of the HTML file.
        units: as for `report_html`.

    Returns:
        The path.

    Raises:
        OSError: the file could not be written; one that was there is as it was.
    """
    return write_whole(path, report_html(findings, outcome, units).encode())


def scene_html(scene: Scene, units: Units = "si") -> str:
    """A scene as a small HTML table, for notebooks.

    Args:
        scene: what was measured.
        units: "si" or "us".

    Returns:
        A fragment; every text of the scene is escaped.
    """
    rows = []
    for name, m in (scene.inputs() | scene.evidence()).items():
        row = InputRow(name, "input", m)
        of_model = f" (a run-out misses {row.format_model(units)})" if m.model_sd else ""
        measured = f"{row.format_measured(units)}{of_model}"
        rows.append((row.label, measured, row.unit(units), m.source, _ASSUMED[m.assumed]))
    return _template("scene.html.j2").render(scene=scene, rows=rows, vehicles=VEHICLES)


def findings_html(findings: Findings, units: Units = "si") -> str:
    """A reconstruction's results and verdict as a small HTML table, for notebooks.

    Args:
        findings: of the reconstruction.
        units: "si" or "us".

    Returns:
        A fragment; every text of the scene is escaped.
    """
    return _template("findings.html.j2").render(
        **_common(findings, units), rows=result_rows(findings, units)
    )


def _common(findings: Findings, units: Units) -> dict[str, Any]:
    return {
        "findings": findings,
        "scene": findings.scene,
        "description": findings.description,
        "checks": findings.checks,
        "answer": findings.answers[units],
        "levels": LEVELS,
        "mark": MARK,
        "withheld": WITHHELD,
        "warning": NOT_TO_BE_RELIED_ON,
        "vehicles": VEHICLES,
    }


def _side_by_side(
    findings: Findings, systems: tuple[Units, ...], quantities: Mapping[str, Quantity]
) -> list[dict[str, Any]]:
    """Results in each system of units; once where a quantity's unit is the same in all."""
    columns = [result_rows(findings, system, quantities.values()) for system in systems]
    rows = []
    for in_each in zip(*columns, strict=True):
        same = len({row.unit for row in in_each}) == 1
        rows.append({"row": in_each[0], "printed": in_each[:1] if same else in_each})
    return rows


def _input_cells(findings: Findings, units: Units, kind: str) -> list[dict[str, str]]:
    return [
        {
            "label": row.label,
            "unit": row.unit(units),
            "measured": row.format_measured(units),
            "model": row.format_model(units),
            "law": _law(findings.scene, row),
            "found": "" if row.mean is None else marked(findings, row.format_found(units)),
            "shift": "" if row.shift is None else marked(findings, row.format_shift()),
            "far": "yes" if row.shift is not None and abs(row.shift) > 2 else "",
            "source": row.source,
            "assumed": _ASSUMED[row.assumed],
        }
        for row in findings.measured
        if row.kind == kind
    ]


def _left_out(findings: Findings, units: Units) -> list[dict[str, Any]]:
    """Each item of evidence predicted from all others, and the effect of an error in it, in cells."""
    rows, speed = [], unit_of("speed", units).worth
    for item in findings.left_out:
        label, unit = label_and_unit(item.name, units)
        without = {"expected": NOTHING, "probability": NOTHING, "speed": NOTHING}
        if item.reliable:
            without = {
                "expected": format_with_sd(
                    item.expected / unit.worth, item.expected_sd / unit.worth
                ),
                "probability": format_value(item.probability, 3),
                "speed": format_with_sd(item.speed_b / speed, item.speed_b_sd / speed),
            }
        cells = without | {
            "believed": format_value(
                100 * item.believed, decimals_of(10, error=100 * item.believed_error)
            ),
            "moved": format_value(
                item.moved / speed,
                decimals_of(item.speed_b_sd / speed, error=item.moved_error / speed),
            ),
        }
        cells = {
            k: cell if cell == NOTHING else marked(findings, cell) for k, cell in cells.items()
        }
        measured = format_with_sd(item.value / unit.worth, item.sd / unit.worth)
        of_item = {"label": label, "unit": unit.symbol, "measured": measured}
        rows.append(of_item | cells | {"disagrees": item.disagrees})
    return rows


def _narrowed(findings: Findings, units: Units) -> list[dict[str, Any]]:
    """What would narrow each speed the most, in cells."""
    tables = []
    speed = unit_of("speed", units).worth
    for sought, known in findings.narrowing.items():
        rows = []
        for each in known[:_MAX_NARROWING]:
            label, unit = label_and_unit(each.name, units)
            m = each.measured
            now = format_with_sd(m.value / unit.worth, m.sd / unit.worth) if m else "not measured"
            sd = each.sd / speed
            cells = {"now": now, "sd": format_value(sd, decimals_of(sd))}
            rows.append({"label": label, "unit": unit.symbol} | cells)
        now_sd = scaled(findings.quantities[sought].sd, speed)
        tables.append(
            {
                "label": label_and_unit(sought, units)[0],
                "sd": format_value(now_sd, decimals_of(now_sd)),
                "rows": rows,
            }
        )
    return tables


def _law(scene: Scene, row: InputRow) -> str:
    if row.measured.sd == 0:
        return "exact"
    return "heavy-tailed" if scene.robust and row.kind == "evidence" else row.measured.law


def _marks(scene: Scene, units: Units) -> list[str]:
    """Where each mark lies and what passed there, in words."""
    unit = unit_of("length", units)
    return [
        f"mark {number} of {v.upper()}: x = {format_value(mark.x / unit.worth, 2)} {unit.symbol}, "
        f"y = {format_value(mark.y / unit.worth, 2)} {unit.symbol}, "
        + ("centre of gravity" if mark.of == "centre" else f"{mark.of.replace('_', ' ')} wheel")
        for v, marks in scene.marks.items()
        for number, mark in enumerate(marks, start=1)
    ]


def _command(findings: Findings) -> str:
    options = {"model": findings.description.name, **findings.settings, "seed": findings.seed}
    return " ".join([COMMAND, *(f"--{name} {value}" for name, value in options.items())])


def _size(findings: Findings) -> str:
    return NOTHING if findings.size is None else " × ".join(map(str, findings.size))


@cache
def _template(name: str) -> Template:
    environment = Environment(
        loader=PackageLoader("retrodict.report", "."),
        autoescape=True,  # titles, notes and sources are a stranger's text
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(name)
