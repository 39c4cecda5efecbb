"""The findings on a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

from retrodict.findings.rounding import NOTHING
from retrodict.findings.sentences import MARK, NOT_TO_BE_RELIED_ON
from retrodict.findings.statistics import LEVELS
from retrodict.report import blocks
from retrodict.report.ladder import ladder_rows
from retrodict.report.layout import print_table
from retrodict.report.results import named, result_rows
from retrodict.report.sliding import CAUTION, sliding_table
from retrodict.scene.quantities import Units, label_and_unit

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.findings.answers import Answered
    from retrodict.report.blocks import Block, Document
    from retrodict.studies.comparison import Ladder

_ONLY_IN_REPORTS = ("one_at_a_time", "checks")  # long tables that nobody asked for
_WIDE = 120  # columns that a row with all of its intervals side by side needs


def print_summary(findings: Findings, console: Console, units: Units = "si") -> None:
    """Print the results, the verdict of the checks and its reasons.

    Numbers of a run that failed its checks are marked; the numbers of a quantity that failed checks
    of its own are withheld.

    Args:
        findings: findings of the reconstruction.
        console: rich console to print on.
        units: "si" or "us".
    """
    checks = findings.checks
    _line(console, findings.scene.title, "bold")
    _line(console, findings.description.title, "dim")
    print_table(console, _table(findings, units, wide=console.width >= _WIDE))
    _line(console, findings.answers[units], "bold" if checks.passed else "bold red")
    _line(console, findings.verdict, "green" if checks.passed else "bold red")
    if by_sliding := sliding_table(findings, units):
        _line(console, by_sliding.title, "bold")
        _print_block(by_sliding, console)
        _line(console, CAUTION, "yellow")
    for asked in findings.questions:
        if asked.kind not in _ONLY_IN_REPORTS:
            _print_answer(asked.in_units(units), console)
    for reason in checks.reasons:
        _line(console, f"  {MARK} {reason}", "red")
    for flag in checks.flags:
        _line(console, f"  note: {flag}", "yellow")
    for note in findings.notes:
        _line(console, f"  note: {note}", "dim")
    if findings.ladder:
        _line(console, f"  model: {findings.ladder.reason}", "dim")


def _print_answer(asked: Answered, console: Console) -> None:
    _line(console, asked.title, "bold")
    for sentence in asked.sentences:
        _line(console, f"  {sentence}", "")
    if asked.rows:
        table = Table()
        for heading in asked.header:
            table.add_column(Text(heading))
        for row in asked.rows:
            table.add_row(*map(Text, row))
        print_table(console, table)


def print_document(document: Document, console: Console) -> None:
    """Print the texts and tables of a short document.

    Args:
        document: document to print, without its pictures.
        console: rich console to print on.
    """
    _line(console, document.title, "bold")
    for block in document.first:
        _print_block(block, console)
    for section in document.sections:
        _line(console, section.title, "bold")
        for block in section.blocks:
            _print_block(block, console)


def _print_block(block: Block, console: Console) -> None:
    if isinstance(block, blocks.Paragraph):
        _line(console, block.text, "bold red" if block.kind == "held" else "")
    elif isinstance(block, blocks.Table):
        table = Table(show_lines=False)
        for i, heading in enumerate(block.header):
            words = i == 0 or i in block.texts
            table.add_column(Text(heading), justify="left" if words else "right")
        for row in block.rows:
            table.add_row(*map(Text, row))
        print_table(console, table)


def print_ladder(ladder: Ladder, console: Console, units: Units = "si") -> None:
    """Print every rung's answer, and the choice with its reason.

    Args:
        ladder: results of every rung of the ladder of models.
        console: rich console to print on.
        units: "si" or "us".
    """
    _line(console, ladder.scene.title, "bold")
    wide = console.width >= _WIDE
    # else the median above its sd: with every unknown asked it still fits a narrow terminal
    table = Table(show_lines=not wide, padding=(0, 1) if wide else 0)
    table.add_column("rung", no_wrap=True)
    for name in ladder.question:
        unit = label_and_unit(name, units)[1].symbol
        table.add_column(Text(f"{name}\n{unit}" if unit else name), justify="right", no_wrap=True)
    for heading in ("fit p", "ln evid.", "n", "s"):
        table.add_column(heading, justify="right", no_wrap=True)
    rows = ladder_rows(ladder, units)
    for row in rows:
        if row.fit == NOTHING:  # not run: its verdict follows
            continue
        cells = [row.name, *(answer for answer, _ in row.answers)]
        cells += [row.fit, row.evidence, row.parameters, row.seconds]
        if not wide:
            cells[0] = row.name.replace("-", "-\n").replace("+", "\n+ ")
            cells = [cell.replace(" ±", "\n±") for cell in cells]
        table.add_row(*map(Text, cells), style="bold" if row.chosen else None)
    print_table(console, table)
    _line(console, "n: unknowns and uncertain inputs; s: seconds without compilation", "dim")
    for verdict in dict.fromkeys(row.verdict for row in rows):
        names = [row.name for row in rows if row.verdict == verdict]
        _line(
            console, f"  {', '.join(names)}: {verdict}", "bold" if ladder.choice in names else "dim"
        )
    _line(console, ladder.reason, "bold" if ladder.choice else "bold red")


def _table(findings: Findings, units: Units, wide: bool) -> Table:
    title = None if findings.checks.passed else Text(f"{MARK} {NOT_TO_BE_RELIED_ON}", "bold red")
    table = Table(title=title, title_justify="left", show_lines=not wide)
    table.add_column("quantity")
    headings = [f"{level} %" for level in LEVELS] if wide else ["central intervals"]
    fold = " " if wide else "\n"  # a narrow table breaks its cells where the eye would
    for heading in ("median", f"mean{fold}± sd", *headings, "R-hat", f"ESS bulk{fold}/ tail"):
        table.add_column(Text(heading), justify="right", no_wrap=True)
    for row in result_rows(findings, units):
        intervals = [row.intervals[level] for level in LEVELS]
        if not wide:
            pairs = zip(LEVELS, intervals, strict=True)
            intervals = ["\n".join(f"{level} %: {text}" for level, text in pairs)]
        if row.withheld:
            intervals = [row.intervals[LEVELS[0]]] * len(intervals)
        label = named(row.label, row.unit)
        mean = row.mean.replace(" ±", f"{fold}±")
        size = f"{row.ess_bulk}{fold}/ {row.ess_tail}"
        cells = [label, row.median, mean, *intervals, row.rhat, size]
        table.add_row(*(Text(cell) for cell in cells), style="red" if row.withheld else None)
    return table


def _line(console: Console, text: str, style: str) -> None:
    # a Text is never read as markup; control characters and escape sequences are not let through
    safe = "".join(c if c.isprintable() else " " for c in text)
    console.print(Text(safe, style=style), soft_wrap=False, highlight=False)
