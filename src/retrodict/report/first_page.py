"""The first page of a report: for a reader who knows reconstruction and no statistics."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from retrodict.findings.rounding import format_value
from retrodict.findings.sentences import MARK, NOT_TO_BE_RELIED_ON
from retrodict.inference.digits import decimals_of
from retrodict.report.blocks import Block, Listing, Paragraph, Picture, Section, Table
from retrodict.report.sections import NOT_STATED
from retrodict.report.sliding import CAUTION, sliding_table
from retrodict.scene.case import Case
from retrodict.scene.quantities import Units, label_and_unit

if TYPE_CHECKING:
    from retrodict.findings import Findings


_ON_FIRST_PAGE = ("probability", "likelihood_ratio", "avoidability", "corners")


def first_page(
    findings: Findings, units: Units, case: Case, pictures: Mapping[str, list[Picture]]
) -> tuple[Block, ...]:
    """The first page: question, answer, causes of uncertainty, checks, assumptions, scene.

    The scene comes last, so that on paper the text is the first page and the scene as wide as the next.
    """
    asked = [Paragraph(case.instruction)] if case.instruction else []
    blocks: list[Block] = [*_case_lines(case)]
    blocks.append(Section("The question", (*asked, Paragraph(findings.question))))
    answered = (*_answer(findings, units), *_if_sliding(findings, units), *_put(findings, units))
    blocks.append(Section("The answer", answered))
    if causes := tuple(_causes(findings, units)):
        blocks.append(Section("What the uncertainty comes from most", causes))
    blocks.append(Section("Did the computation converge?", _verdict(findings)))
    blocks.append(Section("Assumed rather than measured", (Paragraph(_assumed(findings)),)))
    blocks += [replace(p, caption=_first_sentence(p.caption)) for p in pictures["first page"]]
    return tuple(blocks)


def _case_lines(case: Case) -> list[Block]:
    if case == Case():
        return []
    rows = (
        ("Case number", case.number),
        ("Examiner", ", ".join(filter(None, (case.examiner, case.position, case.organisation)))),
        ("Instructed by", case.instructed_by),
        ("Date of the collision", case.dates.get("collision", "")),
        ("Date of the report", case.dates.get("report", "")),
    )
    return [Table(tuple((name, value or NOT_STATED) for name, value in rows), texts=(1,))]


def _answer(findings: Findings, units: Units) -> list[Block]:
    checks, blocks = findings.checks, list[Block]()
    if not checks.passed:
        stopped = "" if findings.complete else ", and the run was interrupted"
        blocks.append(
            Paragraph(
                f"{NOT_TO_BE_RELIED_ON}. Checks of the draws failed{stopped}. Numbers marked {MARK} "
                "come from these draws; those that failed checks of their own are withheld. "
                f"{_reasons(checks.reasons)} Run it again with more draws or by another method; where "
                "that fails too, look for measurements that contradict each other.",
                "held",
            )
        )
    blocks.append(Paragraph(findings.answers[units], "answer" if checks.passed else "held"))
    if not findings.complete:
        text = (
            "The run was interrupted before its end: what follows rests on the draws made by then."
        )
        blocks.append(Paragraph(text, "note"))
    return blocks


def _if_sliding(findings: Findings, units: Units) -> Iterable[Block]:
    """The answers if sliding ended and if it went on, with a caution."""
    if table := sliding_table(findings, units):
        yield table
        yield Paragraph(CAUTION, "note")


def _put(findings: Findings, units: Units) -> Iterable[Block]:
    """The questions that were put, each with the first sentence of its answer."""
    for asked in findings.questions:
        each = asked.in_units(units)
        if each.kind not in _ON_FIRST_PAGE:
            continue
        title = each.title if each.title.endswith(("?", ".")) else f"{each.title}:"
        yield Paragraph(" ".join((title, *each.sentences[:1])))


def _causes(findings: Findings, units: Units) -> Iterable[Block]:
    lines = []
    for sought, causes in findings.causes.items():
        shares = [
            f"{label_and_unit(each.name, units)[0]} "
            f"{format_value(100 * each.share, decimals_of(10, error=_percent(each.error)))} %"
            for each in causes
        ]
        if shares:
            lines.append(f"{label_and_unit(sought, units)[0]}: {', '.join(shares)}")
    if lines:
        yield Paragraph(
            "The measured quantities that contribute most, with the share of the variance that would "
            "vanish, were each known exactly (to first order):"
        )
        yield Listing(tuple(lines))


def _percent(share: float | None) -> float | None:
    return None if share is None else 100 * share


def _verdict(findings: Findings) -> tuple[Block, ...]:
    flags = findings.checks.flags
    text = "Findings about the scene that a reader should know:"
    notes: tuple[Block, ...] = (Paragraph(text), Listing(flags)) if flags else ()
    converged = (
        "Yes: every check of the draws was passed. None of them can tell whether a measurement is wrong "
        "or the model applies; for that see the comparison with the evidence."
    )
    return (Paragraph(converged if findings.checks.passed else f"No. {findings.verdict}"), *notes)


def _assumed(findings: Findings) -> str:
    """The inputs and items of evidence that were not measured, in a sentence or two."""
    sentences = []
    for what, words in (
        ("value", "Neither value nor uncertainty was measured of"),
        ("sd", "Only the uncertainty is assumed of"),
    ):
        labels = [row.label for row in findings.measured if row.assumed == what]
        if labels:
            sentences.append(f"{words} {len(labels)}: {'; '.join(labels)}.")
    sentences = [*findings.simplifications, *sentences]
    if not sentences:
        return "Every input and its uncertainty are stated as measured; sources are listed below."
    return " ".join((*sentences, "The sources of these figures are listed below."))


def _reasons(reasons: tuple[str, ...]) -> str:
    """The first of the reasons, with a note where the others are listed."""
    first, *more = reasons or ("",)
    others = f" ({len(more)} more are listed under numerical quality)" if more else ""
    return f"{first[:1].upper()}{first[1:].rstrip('.')}{others}."


def _first_sentence(text: str) -> str:
    return text.partition(". ")[0].rstrip(".") + "."
