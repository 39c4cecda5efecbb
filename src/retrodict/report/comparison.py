"""Two results beside each other, as a document: both answers, what differs, and what it moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from retrodict.findings.rounding import NOTHING, format_value, format_with_sd
from retrodict.findings.statistics import finite_draws, scaled
from retrodict.report.blocks import (
    Document,
    Paragraph,
    Picture,
    Section,
    Table,
    numbered,
    printable,
)
from retrodict.report.figures import drawing
from retrodict.scene.quantities import REPORTED, Units, describe, unit_of

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.findings.differences import Differences
    from retrodict.inference.outcome import Outcome
    from retrodict.studies.attribution import Step

_CAPTION = (
    "Posterior densities by the first result (solid, filled) and by the second (dashed), smoothed from "
    "all draws."
)
_ALONE = (
    "Each row is the first scene with that one difference made, all else as it is, by the model of the "
    "first result (importance sampling). Together they may count for more or less than one by one."
)


def compared(
    differences: Differences,
    one: tuple[Findings, Outcome],
    other: tuple[Findings, Outcome],
    steps: Sequence[Step] = (),
    sought: str = "",
    units: Units = "si",
) -> Document:
    """A document that sets two results beside each other.

    Args:
        differences: differences between the two results.
        one: findings and outcome of the first result.
        other: findings and outcome of the second result.
        steps: the first scene as it is, then each difference of the scenes made alone; empty where
            no such steps were computed.
        sought: flat name of the quantity whose means the steps hold.
        units: "si" or "us".

    Returns:
        The document.
    """
    answers = tuple(
        Paragraph(f"{which}: {findings.answers[units]}", "answer" if reliable else "held")
        for which, (findings, _), reliable in zip(
            ("First", "Second"), (one, other), differences.reliable, strict=True
        )
    )
    image = drawing.to_png(beside_figure(*one, units, *other))
    sections = [
        Section("The answers", (quantities_table(differences, units),)),
        Section("What was done otherwise", tuple(_changed(differences))),
    ]
    if steps:
        alone = (Paragraph(_ALONE), steps_table(steps, sought, units))
        sections.append(Section("How far each difference moves the answer", alone))
    return printable(
        Document(
            title=one[0].scene.title,
            subtitle="Two reconstructions beside each other",
            author="",
            date="",
            units=units,
            first=(
                Paragraph(differences.verdicts[units]),
                *answers,
                Picture("1", "Both posteriors", _CAPTION, image),
            ),
            sections=tuple(numbered(each, str(i)) for i, each in enumerate(sections, 1)),
        )
    )


def quantities_table(differences: Differences, units: Units = "si") -> Table:
    """The quantities that both results have, with the difference of each."""
    rows = []
    for each in differences.quantities:
        one, other = each.one.precision[units], each.other.precision[units]
        cells = [
            NOTHING
            if found.withheld or not found.passed
            else format_with_sd(
                scaled(found.mean, precision.unit.worth),
                scaled(found.sd, precision.unit.worth),
                precision.decimals,
            )
            for found, precision in ((each.one, one), (each.other, other))
        ]
        moved = format_value(scaled(each.difference, one.unit.worth), one.decimals)
        label = f"{each.one.label}, {one.unit.symbol}".rstrip(", ")
        rows.append((label, *cells, moved, format_value(each.in_sd, 2)))
    header = ("Quantity", "First", "Second", "Difference", "In standard deviations")
    return Table(tuple(rows), header)


def steps_table(steps: Sequence[Step], name: str, units: Units = "si") -> Table:
    """Table of how far each difference of the scenes moves an answer, the largest move first."""
    label, dimension = describe(name)
    unit = unit_of(dimension, units)
    as_it_is, *others = steps

    def moved(step: Step) -> float | None:
        if step.mean is None or as_it_is.mean is None:
            return None
        return step.mean - as_it_is.mean

    def row(step: Step, key: str) -> tuple[str, ...]:
        if step.mean is None:
            return key, step.old, step.new, step.why, NOTHING
        answer = format_with_sd(scaled(step.mean, unit.worth), scaled(step.sd, unit.worth), 1)
        move = NOTHING if step is as_it_is else format_value(scaled(moved(step), unit.worth), 2)
        return key, step.old or NOTHING, step.new or NOTHING, answer, move

    others.sort(key=lambda step: -abs(moved(step) or 0.0))
    rows = (row(as_it_is, "as in the first"), *(row(step, step.key) for step in others))
    answer = f"{label}, {unit.symbol}"
    return Table(rows, ("Key", "First", "Second", answer, "Moved by"), texts=(1, 2))


def _changed(differences: Differences) -> list[Paragraph | Table]:
    rows = [(key, *pair) for key, pair in (differences.scene | differences.run).items()]
    if not rows:
        return [Paragraph("Nothing: both are of the same scene, made in the same way.")]
    return [Table(tuple(rows), ("Key", "First", "Second"), texts=(1, 2))]


@drawing.styled
def beside_figure(
    findings: Findings,
    outcome: Outcome,
    units: Units,
    findings_of_other: Findings,
    other: Outcome,
) -> Figure:
    """Posterior densities of two results.

    Args:
        findings: findings of the first result.
        outcome: outcome of the first result, with its draws.
        units: "si" or "us".
        findings_of_other: findings of the second result.
        other: outcome of the second result, with its draws.

    Returns:
        The figure.
    """
    shown = drawing.shown(findings_of_other)
    names = [name for name in drawing.shown(findings) if name in shown]
    rows = (len(names) + 1) // 2
    figure = drawing.new_figure(7.2, 2.2 * rows)
    panels = figure.subplots(rows, 2, squeeze=False).flat
    styles = ((drawing.BLUE, "-", outcome), (drawing.ORANGE, "--", other))
    for axes, name in zip(panels, names, strict=False):
        unit = drawing.worth(name, units)
        for colour, line, draws in styles:
            values = finite_draws(draws, "posterior", name)
            curve = None if values is None else drawing.density(values / unit.worth)
            if curve is not None:
                axes.plot(*curve, color=colour, ls=line, lw=1.4)
                axes.fill_between(*curve, color=colour, alpha=0.25 if line == "-" else 0.0, lw=0)
        axes.set_xlabel(f"{REPORTED[name][0]} ({unit.symbol})".replace(" ()", ""))
        axes.set_yticks([])
        axes.set_ylim(bottom=0)
        axes.spines["left"].set_visible(False)
    for axes in list(panels)[len(names) :]:
        axes.set_axis_off()
    return figure
