"""The report of the ladder of models: printed rows, and files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retrodict.findings.rounding import NOTHING, format_range, format_value, format_with_sd
from retrodict.findings.statistics import LEVELS
from retrodict.findings.summary import ladder_data
from retrodict.inference.digits import decimals_of
from retrodict.interchange.tables import csv_text
from retrodict.report.results import named
from retrodict.scene.quantities import Units, label_and_unit, unit_of

if TYPE_CHECKING:
    from retrodict.studies.comparison import Ladder, Step


@dataclass(frozen=True, slots=True)
class LadderRow:
    """A rung as it is printed.

    Args:
        name: name of the rung.
        chosen: whether the rung is the ladder's choice.
        answers: (median ± sd, 90 % interval) of each asked quantity.
        fit: probability of a chi-square as large.
        evidence: log marginal likelihood ± error.
        parameters: number of unknowns and uncertain inputs.
        seconds: run time without compilation, s.
        verdict: reason why the rung was chosen, not chosen or not run.
        priors: sought speed under other priors of that speed, as (prior, median ± sd).
        furthest: the item of evidence with the largest residual, and that residual in sd.
        ran: whether the rung was run and its fit to the evidence is known.
    """

    name: str
    chosen: bool
    answers: tuple[tuple[str, str], ...]
    fit: str
    evidence: str
    parameters: str
    seconds: str
    verdict: str
    priors: tuple[tuple[str, str], ...]
    furthest: str
    ran: bool


def ladder_rows(
    ladder: Ladder, units: Units = "si", decimals: Mapping[str, int | None] | None = None
) -> list[LadderRow]:
    """The rungs as they are printed, rounded to their uncertainty.

    Args:
        ladder: results of every rung of the ladder of models.
        units: "si" or "us".
        decimals: largest number of decimals to print of each quantity, by name; None for no limit.

    Returns:
        One row per rung, from simplest to fullest.
    """
    known = decimals or {}
    return [
        LadderRow(
            name=step.name,
            chosen=step.name == ladder.choice,
            answers=tuple(_answer(step, name, units, known.get(name)) for name in ladder.question),
            fit=NOTHING if step.fit is None else f"{step.fit.probability:.2g}",
            evidence=_evidence(step),
            parameters=NOTHING if step.parameters is None else str(step.parameters),
            seconds=format_value(step.seconds, 1),
            verdict=step.verdict,
            priors=_priors(step, units, known.get(ladder.scene.sought)),
            furthest=_furthest(step),
            ran=step.fit is not None,
        )
        for step in ladder.steps
    ]


def headings(ladder: Ladder, units: Units = "si") -> list[str]:
    """Headings of the columns of answers: each asked quantity with its unit."""
    labels = [label_and_unit(name, units) for name in ladder.question]
    return [named(label, unit.symbol) for label, unit in labels]


def write_ladder(ladder: Ladder, directory: Path) -> None:
    """Write ladder.json and ladder.csv, in SI units, and the chart as ladder.png and ladder.svg.

    Args:
        ladder: results of every rung of the ladder of models.
        directory: output directory, made where missing; files of the same names are replaced together.

    Raises:
        OSError: a file could not be written; then no file has changed.
    """
    from retrodict.report.figures.ladder import ladder_figure
    from retrodict.report.study_files import write_study

    write_study(directory, "ladder", ladder_data(ladder), _table(ladder), ladder_figure(ladder))


def _table(ladder: Ladder) -> str:
    """A CSV table with one row per rung, in SI units."""
    rows = []
    for step in ladder.steps:
        row: dict[str, Any] = {"rung": step.name, "chosen": step.name == ladder.choice}
        for name in ladder.question:
            found = step.answers.get(name)
            row[f"{name}_median"] = found and found.median
            row[f"{name}_sd"] = found and found.sd
            for level in LEVELS:
                low, high = found.intervals[level] if found else (None, None)
                row |= {f"{name}_{level}_low": low, f"{name}_{level}_high": high}
        row |= {
            "chi_square": step.fit and step.fit.chi_square,
            "freedom": step.fit and step.fit.freedom,
            "fit_probability": step.fit and step.fit.probability,
            "log_evidence": step.log_evidence,
            "log_evidence_sd": step.log_evidence_sd,
            "parameters": step.parameters,
            "seconds": step.seconds,
            "verdict": step.verdict,
        }
        rows.append(row)
    return csv_text(list(rows[0]) if rows else ["rung"], rows)


def _answer(step: Step, name: str, units: Units, most: int | None) -> tuple[str, str]:
    found = step.answers.get(name)
    if found is None:
        return NOTHING, NOTHING
    worth = label_and_unit(name, units)[1].worth
    low, high = found.intervals[90]
    bounds, decimals = (low / worth, high / worth), _no_more(decimals_of(found.sd / worth), most)
    return (
        format_with_sd(found.median / worth, found.sd / worth, decimals),
        format_range(bounds, decimals),
    )


def _no_more(decimals: int | None, most: int | None) -> int | None:
    return decimals if decimals is None or most is None else min(decimals, most)


def _evidence(step: Step) -> str:
    if step.log_evidence is None or not math.isfinite(step.log_evidence):
        return NOTHING
    return format_with_sd(step.log_evidence, step.log_evidence_sd)


def _priors(step: Step, units: Units, most: int | None) -> tuple[tuple[str, str], ...]:
    worth = unit_of("speed", units).worth
    return tuple(
        (
            other.prior,
            format_with_sd(
                other.median / worth,
                other.sd / worth,
                _no_more(decimals_of(other.sd / worth), most),
            ),
        )
        for other in step.priors
    )


def _furthest(step: Step) -> str:
    items = [item for item in step.fit.items if item.residual is not None] if step.fit else []
    if not items:
        return NOTHING
    furthest = max(items, key=lambda item: abs(item.residual or 0.0))
    return f"{label_and_unit(furthest.name, 'si')[0]}: {format_value(furthest.residual, 1)} sd"
