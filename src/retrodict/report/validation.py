"""The report of a validation: printed rows, its table in Markdown, and files."""

from __future__ import annotations

import json
import re
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from retrodict.findings.rounding import NOTHING, format_range, format_value, format_with_sd
from retrodict.findings.statistics import LEVELS
from retrodict.inference.digits import decimals_of
from retrodict.interchange.tables import csv_text
from retrodict.report.layout import print_table
from retrodict.scene.quantities import Units, describe, unit_of

if TYPE_CHECKING:
    from retrodict.studies.validation import Score, Validation

HOLDS = "*"  # beside an interval that holds the truth


def percent(value: float | None, whole: float | None) -> str:
    """A speed as a share of another, such as "−4.2 %"; a dash where there is none."""
    if value is None or not whole:
        return NOTHING
    return f"{format_value(100 * value / whole, 1)} %"


def cells(score: Score, units: Units = "si") -> dict[str, str]:
    """Printed cells of a score by heading, rounded to its uncertainty.

    Args:
        score: score of one speed.
        units: "si" or "us".
    """
    unit = unit_of("speed", units)
    answer = score.answer if score.counts else None
    withheld = "withheld" if score.answer else NOTHING
    row = {
        "case": score.case,
        "speed": score.quantity[-1:].upper(),
        "true": format_value(score.truth and score.truth / unit.worth, 2),
        "median ± sd": withheld,
        **{f"{level} %": withheld for level in LEVELS},
        "error": percent(score.error, score.truth),
        "sd": NOTHING,
        "error/sd": format_value(score.standardised, 2),
        "below": format_value(score.below if score.counts else None, 2),
        "model": score.model or NOTHING,
        "published": ", ".join(
            f"{name} {format_value(speed / unit.worth, 2)}"
            for name, speed in score.published.items()
        )
        or NOTHING,
        "checks": "passed" if score.counts else "FAILED" if score.answer else "no answer",
        "seconds": format_value(score.seconds, 0),
    }
    if answer:
        decimals = decimals_of(answer.sd / unit.worth)
        row["median ± sd"] = format_with_sd(answer.median / unit.worth, answer.sd / unit.worth)
        row["sd"] = percent(answer.sd, answer.median)
        for level, (low, high) in answer.intervals.items():
            bounds = format_range((low / unit.worth, high / unit.worth), decimals)
            row[f"{level} %"] = f"{bounds}{HOLDS if score.inside(level) else ''}"
    return row


def groups(validation: Validation) -> list[dict[str, str]]:
    """Printed cells of a row for all speeds and for each group, by heading.

    Shares of intervals that hold the truth have their 95 % limits; sd and error are relative.

    Args:
        validation: validation whose scores are counted.
    """
    found = {"all": validation}
    found |= {f"{name}: {label}": part for (name, label), part in validation.groups().items()}
    return [_group(name, part) for name, part in found.items()]


def _group(name: str, part: Validation) -> dict[str, str]:
    counted = [s for s in part.scores if s.answer is not None and s.error is not None and s.truth]
    sds = [s.answer.sd / s.answer.median for s in counted if s.answer and s.answer.median]
    errors = [(s.error or 0.0) / (s.truth or 1.0) for s in counted]
    standardised = [s.standardised or 0.0 for s in counted]
    row = {"group": name, "speeds": f"{len(part.scores)}", "answered": f"{len(counted)}"}
    for level in LEVELS:
        c = part.coverage(level)
        row[f"{level} %"] = f"{c.inside} ({c.low:.0%} to {c.high:.0%})" if c.of else NOTHING
    return row | {
        "median sd": percent(median(sds), 1.0) if sds else NOTHING,
        "median error": percent(median(errors), 1.0) if errors else NOTHING,
        "rms error": percent(_rms(errors), 1.0) if errors else NOTHING,
        "rms error/sd": format_value(_rms(standardised), 2) if errors else NOTHING,
    }


def _rms(values: list[float]) -> float:
    return (sum(value * value for value in values) / len(values)) ** 0.5


def remarks(validation: Validation) -> list[str]:
    """Remarks on the table: coverage, evenness, what was withheld and why, notes of the cases."""
    lines = []
    for level in LEVELS:
        found = validation.coverage(level)
        lines.append(
            f"The {level} % interval holds the truth in {found.inside} of {found.of} (95 % limits of "
            f"the share: {found.low:.0%} to {found.high:.0%})."
        )
    probability = validation.evenness()
    if probability is not None:
        lines.append(
            "The shares of the draws below the truth lie as unevenly as these, or more so, with a "
            f"probability of {probability:.2g} if all answers are calibrated (Kolmogorov and Smirnov)."
        )
    lines.append(
        f"{validation.coverage(90).of} speeds are few, and two of one collision are not independent: "
        "the limits take them as if they were."
    )
    lines += _of_exchange(validation)
    seconds = {s.case: s.seconds for s in validation.scores if s.seconds is not None}
    if seconds:
        longest = max(seconds, key=lambda case: seconds[case] or 0.0)
        lines.append(
            f"Reconstructions took {sum(seconds.values()):.0f} s, the longest {seconds[longest]:.0f} s "
            f"({longest})."
        )
    # two speeds of a case share its reasons and its note
    said = [f"{s.case}: {'; '.join(s.reasons)}" for s in validation.scores if not s.counts]
    said += [f"{score.case}: {score.note}" for score in validation.scores if score.note]
    lines += dict.fromkeys(said)
    if not validation.complete:
        lines.append("Interrupted: cases are missing.")
    return lines


def _of_exchange(validation: Validation) -> list[str]:
    """What the exchange of A and B, and other units, change."""
    lines = []
    moved = {s.case: s.moved for s in validation.scores if s.moved is not None}
    if moved:
        most = max(moved, key=lambda case: abs(moved[case] or 0.0))
        lines.append(
            f"With A and B exchanged the median moves by {abs(moved[most] or 0.0):.2g} sd at most "
            f"({most}), of {len(moved)} cases."
        )
    withheld = [s.case for s in validation.scores if s.counts and s.exchanged_reasons]
    if withheld:
        names = ", ".join(dict.fromkeys(withheld))
        lines.append(
            f"With A and B exchanged the answer is withheld, and it is not without: {names}."
        )
    tried = {s.case: s.units_agree for s in validation.scores if s.units_agree is not None}
    if tried:
        off = [case for case, agree in tried.items() if not agree]
        said = f"but {', '.join(off)}" if off else "without exception"
        lines.append(f"In other units {len(tried)} scenes have the same numbers, {said}.")
    return lines


def narrowing_remarks(validation: Validation) -> list[str]:
    """A remark for each speed on what would narrow it the most."""
    return [_narrowed(score) for score in validation.scores if score.narrowed]


def _narrowed(score: Score) -> str:
    """The quantities that would narrow an answer the most, if known exactly, in words."""
    assert score.answer is not None
    middle = score.answer.median
    (first, *others) = ((describe(n.name)[0], percent(n.sd, middle)) for n in score.narrowed)
    return (
        f"{score.case}: the sd of the {describe(score.quantity)[0]} is "
        f"{percent(score.answer.sd, middle)}; known exactly, the {first[0]} would leave {first[1]}"
        f"{''.join(f', the {label} {sd}' for label, sd in others)}."
    )


def print_validation(validation: Validation, console: Console, units: Units = "si") -> None:
    """Print a row for each speed, and the remarks.

    Args:
        validation: validation to print.
        console: rich console to print on.
        units: "si" or "us".
    """
    symbol = unit_of("speed", units).symbol
    table = Table(show_lines=True, padding=0)
    table.add_column("case and speed")
    for heading in ("true", "median\n± sd", "central\nintervals", "error", "sd"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("model and checks")
    table.add_column("published")
    for score in validation.scores:
        row = cells(score, units)
        lines = [f"{level} %: {row[f'{level} %']}" for level in LEVELS]
        shown = [
            f"{row['case']}\n{row['speed']}",
            row["true"],
            row["median ± sd"].replace(" ±", "\n±"),
            "\n".join(lines) if score.counts else row["90 %"],
            row["error"],
            row["sd"],
            f"{row['model']}\n{row['checks']}",
            row["published"],
        ]
        table.add_row(*map(_safe, shown), style=None if score.counts else "red")
    print_table(console, table)
    console.print(_safe(f"Speeds in {symbol}. {HOLDS} holds the truth."), style="dim")
    print_table(console, _groups_table(validation))
    console.print("Intervals: how many hold the truth, 95 % limits of the share.", style="dim")
    for line in [*remarks(validation), *narrowing_remarks(validation)]:
        console.print(_safe(line), highlight=False)


def _groups_table(validation: Validation) -> Table:
    table = Table(padding=0)
    rows = groups(validation)
    for heading in rows[0]:
        # narrow columns: shares above their limits
        table.add_column(heading, justify="left" if heading == "group" else "right")
    for row in rows:
        table.add_row(*(_safe(cell.replace(" (", "\n(")) for cell in row.values()))
    return table


def table_lines(validation: Validation, units: Units = "si") -> list[str]:
    """The table in Markdown, one line per row.

    Args:
        validation: validation whose scores make the rows.
        units: "si" or "us".
    """
    rows = [cells(score, units) for score in validation.scores]
    headings = list(rows[0]) if rows else ["case"]
    symbol = unit_of("speed", units).symbol
    lines = [
        [f"{h}, {symbol}" if h in ("true", "median ± sd") else h for h in headings],
        ["---"] * len(headings),
        *([_plain(row[heading]) for heading in headings] for row in rows),
    ]
    return [f"| {' | '.join(line)} |" for line in lines]


def group_lines(validation: Validation) -> list[str]:
    """The table of groups in Markdown, one line per row."""
    rows = groups(validation)
    lines = [list(rows[0]), ["---"] * len(rows[0])]
    lines += [[_plain(cell) for cell in row.values()] for row in rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def remark_lines(validation: Validation) -> list[str]:
    """The remarks in Markdown, one line each."""
    return [f"- {_plain(line)}" for line in remarks(validation)]


def narrowing_lines(validation: Validation) -> list[str]:
    """What would narrow each speed, in Markdown, one line each."""
    return [f"- {_plain(line)}" for line in narrowing_remarks(validation)]


def write_validation(validation: Validation, directory: Path, units: Units = "si") -> None:
    """Write validation.md, .csv and .json (SI units), and both charts as .png and .svg.

    Args:
        validation: validation to write.
        directory: output directory, made where missing; files of the same names are replaced together.
        units: "si" or "us", the system of units of the Markdown table and the chart.

    Raises:
        OSError: a file could not be written; then no file has changed.
    """
    from retrodict.report.figures.validation import (
        CAPTION,
        ERRORS_CAPTION,
        errors_figure,
        validation_figure,
    )
    from retrodict.report.study_files import write_study

    page = [
        "# Staged collisions",
        "",
        f"retrodict {version('retrodict')}, model {_plain(validation.model)}, "
        f"method {_plain(validation.method)}.",
        "",
        *table_lines(validation, units),
        "",
        "## By group",
        "",
        *group_lines(validation),
        "",
        "## Remarks",
        "",
        *remark_lines(validation),
        *narrowing_lines(validation),
        "",
        f"![{CAPTION}](validation.png)",
        "",
        f"![{ERRORS_CAPTION}](validation-errors.png)",
        "",
        "## Files",
        "",
        *_digest_lines(validation),
        "",
    ]
    figure = validation_figure(validation, units)
    data, table = validation_data(validation), _csv(validation)
    more = {"validation-errors": errors_figure(validation)}
    write_study(directory, "validation", data, table, figure, "\n".join(page), more)


def _digest_lines(validation: Validation) -> list[str]:
    """SHA-256 of each case's files in Markdown, by which a third party sees that none has changed."""
    rows = {s.case: s.digests for s in validation.scores if s.digests}
    lines = [
        f"| {_plain(case)} | {' | '.join(f'`{digest}`' for digest in digests.values())} |"
        for case, digests in rows.items()
    ]
    return ["| case | scene.toml, SHA-256 | truth.toml, SHA-256 |", "| --- | --- | --- |", *lines]


def validation_data(validation: Validation) -> dict[str, Any]:
    """A validation in strict JSON, in SI units."""
    return {
        "version": version("retrodict"),
        "model": validation.model,
        "method": validation.method,
        "complete": validation.complete,
        "faults": list(validation.faults),
        "coverage": _coverage(validation),
        "evenness": validation.evenness(),
        "groups": [
            {"group": name, "label": label, "coverage": _coverage(part)}
            for (name, label), part in validation.groups().items()
        ],
        "scores": [
            asdict(score)
            | {"passed": score.counts, "error": score.error, "standardised": score.standardised}
            | {"inside": {str(level): score.inside(level) for level in LEVELS}}
            for score in validation.scores
        ],
    }


def _coverage(validation: Validation) -> dict[str, dict[str, Any]]:
    return {str(level): asdict(validation.coverage(level)) for level in LEVELS}


def _csv(validation: Validation) -> str:
    """A CSV table with one row per speed, in SI units."""
    rows = []
    for score in validation.scores:
        answer = score.answer
        row: dict[str, Any] = {"case": score.case, "quantity": score.quantity}
        row |= {"truth": score.truth, "model": score.model, "passed": score.counts}
        row |= {"median": answer and answer.median, "sd": answer and answer.sd}
        for level in LEVELS:
            low, high = answer.intervals[level] if answer else (None, None)
            row |= {f"{level}_low": low, f"{level}_high": high}
            row[f"{level}_inside"] = score.inside(level)
        row |= {"error": score.error, "standardised": score.standardised, "below": score.below}
        row |= {"seconds": score.seconds, "reasons": "; ".join(score.reasons)}
        row["groups"] = json.dumps(score.groups, ensure_ascii=False)
        row["published"] = json.dumps(score.published, ensure_ascii=False)
        rows.append(row)
    return csv_text(list(rows[0]) if rows else ["case"], rows)


def _safe(text: str) -> Text:
    # a Text is never read as markup; control characters and escape sequences are not let through
    return Text("".join(c if c.isprintable() or c == "\n" else " " for c in text))


def _plain(text: str) -> str:
    """A text with the characters that Markdown would interpret escaped."""
    return re.sub(r"([\\`*_\[\]<>|&])", r"\\\1", " ".join(text.split()))
