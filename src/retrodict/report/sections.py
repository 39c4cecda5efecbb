"""Sections of a report: results, evidence and inputs, model, priors, reproduction, expert."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from retrodict.findings.inputs import ASSUMED
from retrodict.findings.rounding import format_value
from retrodict.findings.sentences import MARK, NOT_TO_BE_RELIED_ON
from retrodict.report.blocks import (
    Block,
    Code,
    Form,
    Listing,
    Paragraph,
    Picture,
    Section,
    Table,
)
from retrodict.report.results import marked, named, result_rows
from retrodict.scene.quantities import Units, unit_of
from retrodict.scene.write import CANNOT_SAY

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.findings.answers import Answered
    from retrodict.findings.inputs import InputRow
    from retrodict.findings.statistics import Quantity
    from retrodict.scene.case import Attachment, Case

NOT_STATED = "not stated"
COMMAND = "retrodict reconstruct scene.toml"  # and the options that make the same numbers

_LEVELS = (90, 95)  # per cent, of the results' intervals
_SYSTEMS: dict[Units, str] = {"si": "SI units", "us": "US customary units"}


def results(findings: Findings, units: Units, pictures: Mapping[str, list[Picture]]) -> Section:
    """The results in both systems of units, and what the probabilities mean."""
    derived = tuple(_result_tables(findings, units, findings.derived))
    warned = "" if findings.checks.passed else f" {MARK} {NOT_TO_BE_RELIED_ON}: see the first page."
    return Section(
        "Results",
        (
            *_result_tables(findings, units, findings.quantities),
            Paragraph(
                "Intervals are central: they hold the stated share of the posterior draws, with as many "
                "draws below as above. "
                "Numbers are rounded to two significant digits of their standard deviation (sd), or to "
                f"fewer where the error of drawing them reaches the last of these.{warned}",
                "quiet",
            ),
            *pictures["results"],
            Section("What follows from the same draws", derived),
            Section(
                "What the probability means",
                (
                    Paragraph(
                        "A 95 % interval is a statement about what is not known: if the model, the "
                        "measured inputs with their uncertainties and the priors listed below are "
                        "accepted, the probability that the true value lies in it is 95 %. Other "
                        "inputs, another prior or another model would give another interval. It is "
                        "not a claim that 95 % of such reconstructions are right; only trials against "
                        "staged collisions can show that."
                    ),
                    Paragraph(
                        "By itself such a probability is not an evaluative opinion. The ENFSI "
                        "guideline for evaluative reporting asks how probable the findings are under "
                        "each of two stated propositions, not how probable a proposition is. The prior "
                        "odds of propositions are left to the court."
                    ),
                ),
            ),
        ),
    )


def _result_tables(
    findings: Findings, units: Units, quantities: Mapping[str, Quantity]
) -> Iterable[Table]:
    """Results in the system of units that comes first, then in the other where the unit differs."""
    other: Units = "us" if units == "si" else "si"
    first = result_rows(findings, units, quantities.values())
    second = result_rows(findings, other, quantities.values())
    differing = [b for a, b in zip(first, second, strict=True) if a.unit != b.unit]
    for system, rows in ((units, first), (other, differing)):
        if rows:
            yield Table(
                header=("Quantity", "Median", "Mean ± sd", *(f"{n} % interval" for n in _LEVELS)),
                rows=tuple(
                    (
                        named(row.label, row.unit),
                        row.median,
                        row.mean,
                        *(row.intervals[level] for level in _LEVELS),
                    )
                    for row in rows
                ),
                title=_SYSTEMS[system],
            )


def questions(
    findings: Findings, units: Units, pictures: Mapping[str, list[Picture]]
) -> Section | None:
    """The questions that were put, with their answers; None where none was."""

    def part(number: int, each: Answered) -> Section:
        blocks: list[Block] = [Paragraph(sentence) for sentence in each.sentences]
        if each.rows:
            blocks.append(Table(each.rows, each.header))
        return Section(each.title, (*blocks, *pictures[f"question {number}"]))

    parts = tuple(
        part(number, each.in_units(units)) for number, each in enumerate(findings.questions)
    )
    return Section("Questions put", parts) if parts else None


def evidence(
    findings: Findings, units: Units, case: Case, pictures: Mapping[str, list[Picture]]
) -> Section:
    """Section on the evidence: measured and predicted values, and the register of sources."""
    rows = [row for row in findings.measured if row.kind == "evidence"]
    blocks: list[Block] = [
        Section("Measured and predicted", tuple(_fit(findings, units, rows, pictures))),
        Section(
            "Register",
            (
                _files(case.attachments),
                Paragraph(
                    f"The scene file has the SHA-256 {findings.scene_text.sha256} and is printed under "
                    "Reproduction. Of each measurement it says:"
                ),
                _sources(rows),
            ),
        ),
    ]
    if findings.scene.notes:
        blocks.append(Section("The investigator's remarks", (Listing(findings.scene.notes),)))
    return Section("Evidence", tuple(blocks))


def _fit(
    findings: Findings,
    units: Units,
    rows: Sequence[InputRow],
    pictures: Mapping[str, list[Picture]],
) -> Iterable[Block]:
    yield Paragraph(
        "What was measured of the vehicles after the impact, and what the model predicts for such a "
        "measurement. The shift is in standard deviations of the measurement; ► marks one beyond two."
    )
    yield _measured_table(findings, units, rows, "Predicted ± sd")
    if any(row.measured.model_sd for row in rows):
        yield Paragraph(
            "The number after “run-out” is the assumed model error of the run-out at that point, listed "
            "under The model. Likelihood and shift use it together with the measurement's own error.",
            "quiet",
        )
    if marks := _marks(findings, units):
        yield Paragraph("Marks lie where a vehicle passed, so at no distance from its path:")
        yield Listing(tuple(marks))
    if findings.scene.end_of_rotation:
        yield Paragraph(
            "A vehicle's end of rotation is where it stops sliding sideways and begins to roll: where "
            "the slip angle of its rear axle last falls below a threshold, averaged over thresholds "
            "from 12 to 8 deg. One that slides sideways until it rests ends there.",
            "quiet",
        )
    yield from pictures["evidence"]


def _measured_table(
    findings: Findings, units: Units, rows: Iterable[InputRow], found: str
) -> Table:
    def cells(row: InputRow) -> tuple[str, ...]:
        measured = row.format_measured(units)
        if row.measured.model_sd:
            measured += f", run-out {row.format_model(units)}"
        law = _law(findings, row)
        shift = "" if row.shift is None else marked(findings, row.format_shift())
        return (
            named(row.label, row.unit(units)),
            f"{measured} ({law})" if law else measured,
            "" if row.mean is None else marked(findings, row.format_found(units)),
            f"► {shift}" if row.shift is not None and abs(row.shift) > 2 else shift,
        )

    return Table(tuple(map(cells, rows)), ("Item", "Measured ± sd", found, "Shift, sd"))


def _law(findings: Findings, row: InputRow) -> str:
    """The error law where it is not the normal one."""
    if row.measured.sd == 0:
        return "exact"
    if findings.scene.robust and row.kind == "evidence":
        return "heavy-tailed"
    return "" if row.measured.law == "normal" else row.measured.law


def _files(attachments: tuple[Attachment, ...]) -> Block:
    if not attachments:
        return Paragraph(f"Files of the case: {NOT_STATED}.")
    rows = tuple(
        (
            each.title or each.file,
            f"{each.file}, {each.size} bytes, SHA-256 {each.sha256}",
            "; ".join(
                f"{what} {value or NOT_STATED}"
                for what, value in (
                    ("by", each.by),
                    ("how:", each.method),
                    ("when:", each.date),
                    ("source:", each.source),
                )
            ),
        )
        for each in attachments
    )
    return Table(rows, ("File", "Name and digest", "Who, how, when and where from"), texts=(1, 2))


def _sources(rows: Iterable[InputRow]) -> Table:
    cells = tuple((row.label, row.source or NOT_STATED, ASSUMED[row.assumed]) for row in rows)
    return Table(cells, ("Item", "Source", "Default"), texts=(1, 2))


def _marks(findings: Findings, units: Units) -> list[str]:
    """Position of each mark and the point of the vehicle that passed there, in words."""
    unit = unit_of("length", units)
    return [
        f"mark {number} of {v.upper()}: x = {format_value(mark.x / unit.worth, 2)} {unit.symbol}, "
        f"y = {format_value(mark.y / unit.worth, 2)} {unit.symbol}, "
        + ("centre of gravity" if mark.of == "centre" else f"{mark.of.replace('_', ' ')} wheel")
        for v, marks in findings.scene.marks.items()
        for number, mark in enumerate(marks, start=1)
    ]


def inputs(findings: Findings, units: Units) -> Section:
    """Section on the inputs of the model and their sources."""
    rows = [row for row in findings.measured if row.kind == "input"]
    return Section(
        "Inputs and defaults",
        (
            Paragraph(
                "What was taken into the model with its uncertainty, and what the evidence made of it. "
                "Error laws are normal where none is named. What is exact has no posterior."
            ),
            _measured_table(findings, units, rows, "Posterior ± sd"),
            Section("Where they come from", (_sources(rows),)),
        ),
    )


def model(findings: Findings) -> Section:
    """The model in words, and what it does not answer."""
    description = findings.description
    return Section(
        "The model and its limits",
        (
            Paragraph(f"{description.title} ({description.name})."),
            Paragraph(
                "Axes x and y lie in the road plane; angles count counter-clockwise from the x axis, "
                "Γ from the y axis; lower case is before impact and upper case after."
            ),
            Section("Equations", (Listing(description.equations),)),
            Section("Assumptions", (Listing(findings.assumptions),)),
            Section("Left out", (Listing(description.left_out),)),
            Section(
                "Not answered here",
                (
                    Listing(
                        (
                            "who or what caused the collision",
                            "how probable a proposition is: the prior odds are left to the court",
                            "whether the model is the right one for this collision: every statement "
                            "here is made within it",
                        )
                    ),
                ),
            ),
        ),
    )


def priors(findings: Findings) -> Section:
    """Section on the priors of the unknowns, with the reasons."""
    table = Table(tuple(findings.description.priors), ("Quantity", "Prior", "Reason"), texts=(1, 2))
    text = "What was assumed of the unknowns before the evidence was used."
    return Section("Priors", (Paragraph(text), table))


def reproduction(findings: Findings) -> Section:
    """The command, the versions and the scene file that give the same numbers."""
    text = findings.scene_text
    # what was asked for: after a retry the settings of the draws do not make them again
    options = {k: v for k, v in asdict(findings.asked).items() if v is not None}
    command = " ".join([COMMAND, *(f"--{name} {value}" for name, value in options.items())])
    how = (
        "as it was written"
        if text.as_written
        else "made from the values that were computed with, because the scene was changed after its "
        "file was read, or had none"
    )
    rows = {
        "model": findings.description.name,
        **{name: str(value) for name, value in findings.settings.items()},
        **findings.versions,
        **{f"seconds, {name}": format_value(s, 1) for name, s in findings.seconds.items()},
    }
    first = text.text.split("\n")[0]
    unsaid = (Paragraph(first.removeprefix("# ")),) if first.startswith(CANNOT_SAY) else ()
    return Section(
        "Reproduction",
        (
            Paragraph("With the scene file below saved as scene.toml:"),
            Code(command),
            *unsaid,
            Table(tuple(rows.items()), texts=(1,)),
            Paragraph(f"The scene file, {how}; SHA-256 {text.sha256}:"),
            Code(text.text),
        ),
    )


def expert(case: Case) -> Section:
    """Section with the expert's statements, and a line for the signature."""
    dates = case.dates
    rows: dict[str, str | tuple[str, ...]] = {
        "Case number": case.number,
        "Name, position and organisation": tuple(
            filter(None, (case.examiner, case.position, case.organisation))
        ),
        "Qualifications": case.qualifications,
        "Publications of the last ten years": case.publications,
        "Testimony given in the last four years": case.testimony,
        "Compensation": case.compensation,
        "Instructed by": case.instructed_by,
        "Question put": case.instruction,
        "Propositions compared": case.propositions,
        "Date of the collision": dates.get("collision", ""),
        "Date of the inspection": dates.get("inspection", ""),
        "Place and date of the report": tuple(filter(None, (case.place, dates.get("report", "")))),
        "Duty to the court and declaration of truth": case.declaration,
    }
    stated = tuple(
        (name, (value if isinstance(value, str) else "; ".join(value)) or NOT_STATED)
        for name, value in rows.items()
    )
    return Section("The expert", (Table(stated, texts=(1,)), Form(("Signature",))))
