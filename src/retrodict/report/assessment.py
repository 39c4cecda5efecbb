"""Sections of a report on how far its numbers can be relied on, and what they depend on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from retrodict.findings.rounding import NOTHING, format_value, format_with_sd
from retrodict.findings.sentences import NOT_TO_BE_RELIED_ON
from retrodict.findings.statistics import scaled
from retrodict.inference.digits import decimals_of, rhat_text
from retrodict.report.blocks import Block, Listing, Paragraph, Picture, Section, Table
from retrodict.report.ladder import LadderRow, headings, ladder_rows
from retrodict.report.results import marked, named, result_rows
from retrodict.scene.names import vehicle_of
from retrodict.scene.quantities import Units, label_and_unit, unit_of
from retrodict.studies.conflict import MIN_PROBABILITY

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.studies.conflict import LeftOut
    from retrodict.studies.narrowing import Narrowed

_MAX_NARROWING = 8  # quantities that would narrow an answer


def sensitivity(findings: Findings, units: Units, pictures: Mapping[str, list[Picture]]) -> Section:
    """Section on what the answers depend on."""
    blocks: list[Block] = []
    if findings.narrowing:
        blocks.append(Section("What would narrow the answer", tuple(_narrowed(findings, units))))
    if findings.left_out:
        blocks.append(Section("Each item left out", tuple(_left_out(findings, units))))
        blocks.append(
            Section("An error that nothing contradicts", tuple(_believed(findings, units)))
        )
    return Section("Sensitivity", (*blocks, *pictures["sensitivity"]))


def _narrowed(findings: Findings, units: Units) -> Iterable[Block]:
    yield Paragraph(
        "How sure each speed would be, were one more quantity known exactly: to first order, from the "
        "same draws. Some unmeasured quantities could be obtained from recorders, marks or witnesses. "
        "Two quantities together may do more than either alone."
    )
    speed = unit_of("speed", units)
    for sought, known in findings.narrowing.items():
        label, now = _speed_and_sd(findings, sought, units)
        rows = []
        for each in known[:_MAX_NARROWING]:
            name, unit = label_and_unit(each.name, units)
            m = each.measured
            as_now = (
                format_with_sd(m.value / unit.worth, m.sd / unit.worth) if m else "not measured"
            )
            left = _sd_left(findings, sought, units, each)
            rows.append((named(name, unit.symbol), as_now, left))
        heading = f"Sd of the {label}, {speed.symbol} (now {now})"
        yield Table(tuple(rows), ("Known exactly", "Measured ± sd", heading))


def _speed_and_sd(findings: Findings, name: str, units: Units) -> tuple[str, str]:
    found = findings.quantities[name]
    precision = found.precision[units]
    sd = format_value(scaled(found.sd, precision.unit.worth), precision.decimals)
    return label_and_unit(name, units)[0], sd


def _sd_left(findings: Findings, sought: str, units: Units, known: Narrowed) -> str:
    """Sd of a speed, were a quantity known."""
    sd = known.sd / unit_of("speed", units).worth
    return format_value(sd, _decimals(findings, sought, units, sd))


def _decimals(findings: Findings, name: str, units: Units, sd: float) -> int | None:
    """Decimals of an sd printed beside a quantity: as its size asks, but no more than the quantity's."""
    own, known = decimals_of(sd), findings.quantities[name].precision[units].decimals
    return own if known is None or own is None else min(own, known)


def _left_out(findings: Findings, units: Units) -> Iterable[Block]:
    checked = [item for item in findings.left_out if item.reliable]
    if checked:
        yield Paragraph(
            "Each measurement predicted from all others, by reweighting the draws without it, and the "
            f"speed of {_who(findings)} that would be found. ► marks a measurement that all others make "
            f"less probable than {format_value(100 * MIN_PROBABILITY, 0)} %."
        )
        speed = unit_of("speed", units)
        rows = tuple(_without(findings, units, item) for item in checked)
        yield Table(
            rows,
            (
                "Item",
                "Measured ± sd",
                "All others predict ± sd",
                "Probability",
                f"Speed of {_who(findings)} without it ± sd, {speed.symbol}",
            ),
        )
    if missing := [label_and_unit(i.name, units)[0] for i in findings.left_out if not i.reliable]:
        yield Paragraph(
            f"Nothing cross-checks {'; '.join(missing)}: so much depends on "
            f"{'it' if len(missing) == 1 else 'each of these'} that the draws cannot be reweighted "
            "without it (Pareto k above 0.7)."
        )


def _without(findings: Findings, units: Units, item: LeftOut) -> tuple[str, ...]:
    label, unit = label_and_unit(item.name, units)
    speed = unit_of("speed", units).worth
    sd = item.speed_sd / speed
    decimals = decimals_of(sd)
    if (sought := findings.scene.sought) in findings.quantities:
        decimals = _decimals(findings, sought, units, sd)
    probability = marked(findings, format_value(item.probability, 3))
    return (
        named(label, unit.symbol),
        format_with_sd(item.value / unit.worth, item.sd / unit.worth),
        marked(findings, format_with_sd(item.expected / unit.worth, item.expected_sd / unit.worth)),
        f"► {probability}" if item.disagrees else probability,
        marked(findings, format_with_sd(item.speed / speed, sd, decimals)),
    )


def _believed(findings: Findings, units: Units) -> Iterable[Block]:
    speed = unit_of("speed", units)
    rows = []
    for item in findings.left_out:
        believed = format_value(
            100 * item.believed, decimals_of(10, error=100 * item.believed_error)
        )
        moved = format_value(
            item.moved / speed.worth,
            decimals_of(item.speed_sd / speed.worth, error=item.moved_error / speed.worth),
        )
        if NOTHING not in (believed, moved):
            label = label_and_unit(item.name, units)[0]
            rows.append((label, marked(findings, believed), marked(findings, moved)))
    if not rows:
        yield Paragraph("No values are given: errors of the evidence have heavy tails here.")
        return
    yield Paragraph(
        "What an error in a measurement would do, to first order: which share of it would be believed, "
        "for want of anything that contradicts it, and how far an error of one standard deviation would "
        f"move the speed of {_who(findings)}. Where nearly all is believed, a reading that is wrong by "
        "many standard deviations passes unseen."
    )
    moved_by = f"Speed of {_who(findings)} moved, {speed.symbol}"
    yield Table(tuple(rows), ("Item", "Error believed, %", moved_by))


def _who(findings: Findings) -> str:
    """The vehicle, "A" or "B", whose speed is sought."""
    return str(vehicle_of(findings.scene.sought)).upper()


def numerical_quality(findings: Findings, units: Units) -> Section:
    """Section on how far the draws can be relied on."""
    checks = findings.checks
    size = NOTHING if findings.size is None else " × ".join(map(str, findings.size))
    own = ("Divergent transitions", format_value(checks.divergences, 0))
    if checks.pareto_k is not None:
        own = ("Pareto k of the importance weights", format_value(checks.pareto_k, 2))
    held = "every check held" if checks.passed else f"FAILED: {NOT_TO_BE_RELIED_ON}"
    blocks: list[Block] = [
        Table(
            (
                ("Verdict", held),
                ("Chains × draws kept of each", size),
                own,
                ("Largest R-hat (1 when the chains agree)", rhat_text(checks.max_rhat)),
                ("Smallest effective sample size, bulk", format_value(checks.min_ess_bulk, 0)),
                ("Smallest effective sample size, tail", format_value(checks.min_ess_tail, 0)),
            )
        )
    ]
    if checks.reasons:
        blocks.append(Listing(checks.reasons))
    if findings.notes:
        blocks.append(Section("How the run was completed", (Listing(findings.notes),)))
    flags: Block = Listing(checks.flags) if checks.flags else Paragraph("None was raised.")
    blocks.append(Section("Findings to note", (flags,)))
    blocks.append(_by_quantity(findings, units))
    return Section("Numerical quality", tuple(blocks))


def _by_quantity(findings: Findings, units: Units) -> Section:
    """Diagnostics and Monte Carlo error of each reported quantity."""
    rows = tuple(
        (
            named(row.label, row.unit),
            row.rhat,
            f"{row.ess_bulk} / {row.ess_tail}",
            row.monte_carlo_error,
            row.last_digit,
        )
        for row in result_rows(findings, units)
    )
    heads = (
        "Quantity",
        "R-hat",
        "ESS bulk / tail",
        "Error of the 95 % limits",
        "Last digit printed",
    )
    explained = Paragraph(
        "The error is that of drawing (Monte Carlo); only those digits are printed of "
        "which it is below a unit. R-hat compares the chains with one another; the "
        "effective sample size (ESS) says how many independent draws they are worth, for "
        "the middle (bulk) and for the ends (tail) of a distribution.",
        "quiet",
    )
    return Section("Quantity by quantity", (Table(rows, heads), explained))


def model_comparison(findings: Findings, units: Units) -> Section | None:
    """Section on the results of the other models; None where the findings have no ladder."""
    if (ladder := findings.ladder) is None:
        return None
    known = {name: q.precision[units].decimals for name, q in findings.quantities.items()}
    rows = ladder_rows(ladder, units, known)
    ran = [row for row in rows if row.ran]
    answers = tuple(f"{heading}: median ± sd" for heading in headings(ladder, units))
    named = {row.name: f"{row.name} (chosen)" if row.chosen else row.name for row in rows}
    blocks: list[Block] = [
        Paragraph(ladder.reason),
        Table(
            tuple(
                (named[row.name], *(text for text, _ in row.answers), row.fit, row.evidence)
                for row in ran
            ),
            ("Model", *answers, "Fit, p", "ln evidence"),
        ),
        Table(
            tuple(
                (
                    named[row.name],
                    row.verdict,
                    row.furthest,
                    "; ".join(f"{prior}: {text}" for prior, text in row.priors) or NOTHING,
                )
                for row in ran
            ),
            (
                "Model",
                "Verdict",
                "Furthest evidence",
                f"Speed of {_who(findings)} under other priors of it",
            ),
            texts=(1, 2, 3),
        ),
    ]
    blocks += _not_run([row for row in rows if not row.ran])
    blocks.append(
        Paragraph(
            "p is the probability of a misfit as large, of evidence and inputs together, were the model "
            "true. The ln evidence (log marginal likelihood) may be compared only between models that "
            f"explain the same data. The half-normal prior of {_who(findings)}'s speed was halved and "
            "doubled in scale, and made flat, by reweighting the same draws.",
            "quiet",
        )
    )
    return Section("Comparison of models", tuple(blocks))


def _not_run(left: list[LadderRow]) -> list[Paragraph]:
    """A paragraph for each reason why models were not run, with their names."""
    return [
        Paragraph(
            f"Not run: {', '.join(row.name for row in left if row.verdict == verdict)}: {verdict}."
        )
        for verdict in dict.fromkeys(row.verdict for row in left)
    ]
