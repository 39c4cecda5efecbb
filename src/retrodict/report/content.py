"""What a report says: the document is made once of the findings, with every cell formatted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from retrodict.findings.inputs import ASSUMED
from retrodict.findings.rounding import NOTHING, format_value, format_with_sd
from retrodict.findings.sentences import MARK, NOT_TO_BE_RELIED_ON
from retrodict.findings.statistics import scaled
from retrodict.inference.digits import decimals_of, rhat_text
from retrodict.report.blocks import (
    Block,
    Code,
    Document,
    Form,
    Listing,
    Paragraph,
    Picture,
    Section,
    Table,
    numbered,
    printable,
)
from retrodict.report.ladder import headings, ladder_rows
from retrodict.report.results import marked, result_rows
from retrodict.scene.case import Attachment, Case
from retrodict.scene.quantities import Units, label_and_unit, unit_of
from retrodict.scene.records import VEHICLES
from retrodict.studies.conflict import DOUBT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from retrodict.findings import Findings
    from retrodict.findings.inputs import InputRow
    from retrodict.findings.questions import Answered
    from retrodict.findings.statistics import Quantity
    from retrodict.report.figures import Registered
    from retrodict.studies.conflict import LeftOut
    from retrodict.studies.narrowing import Narrowed

NOT_STATED = "not stated"
COMMAND = "retrodict reconstruct scene.toml"  # and the options that make the same numbers

_CAUSES = 3  # of the uncertainty, on the first page
_MOST_TELLING = 8  # quantities that would narrow an answer
_LEVELS = (90, 95)  # per cent, of the results' intervals
_SYSTEMS: dict[Units, str] = {"si": "SI units", "us": "US customary units"}


def content(
    findings: Findings,
    images: Mapping[str, bytes],
    figures: Mapping[str, Registered],
    units: Units = "si",
    case: Case | None = None,
) -> Document:
    """The report of a reconstruction.

    Args:
        findings: of the reconstruction.
        images: of the figures, PNG, by name.
        figures: their titles and captions, and where they stand, by name.
        units: which come first, and which inputs are printed in.
        case: what the expert says; None where nothing is stated.

    Returns:
        The document. Characters that do not print are written as their codes.
    """
    case = case or Case()
    pictures = _pictures(findings, images, figures)
    vehicles = findings.scene.vehicles
    sections = [
        _results(findings, units, pictures),
        _questions(findings, pictures),
        _evidence(findings, units, case, pictures),
        _inputs(findings, units),
        _model(findings),
        _priors(findings),
        _sensitivity(findings, units, pictures),
        _numerical_quality(findings, units),
        _model_comparison(findings, units),
        _reproduction(findings),
        _expert(case),
    ]
    document = Document(
        title=findings.scene.title,
        subtitle="Reconstruction of a vehicle collision with its uncertainty: "
        + "; ".join(f"vehicle {v.upper()}, {vehicles[v].name}" for v in VEHICLES),
        author=case.examiner,
        date=case.dates.get("report", ""),
        first=_first_page(findings, units, case, pictures),
        sections=tuple(
            numbered(section, str(number))
            for number, section in enumerate((s for s in sections if s is not None), 1)
        ),
    )
    return printable(document)


# ---- the first page


def _first_page(
    findings: Findings, units: Units, case: Case, pictures: Mapping[str, list[Picture]]
) -> tuple[Block, ...]:
    asked = [Paragraph(case.instruction)] if case.instruction else []
    blocks: list[Block] = [*_case_lines(case)]
    blocks.append(Section("The question", (*asked, Paragraph(findings.question))))
    blocks.append(Section("The answer", (*_answer(findings, units), *_put(findings))))
    blocks += [
        replace(p, caption=_first_sentence(p.caption), small=True) for p in pictures["first page"]
    ]
    if causes := tuple(_causes(findings, units)):
        blocks.append(Section("What the uncertainty comes from most", causes))
    blocks.append(Section("Are the numbers sound?", _verdict(findings)))
    blocks.append(Section("Assumed rather than measured", (Paragraph(_assumed(findings)),)))
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
                + " ".join(checks.reasons),
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


def _put(findings: Findings) -> Iterable[Block]:
    """The questions that were put, each with the first sentence of its answer."""
    for each in findings.questions:
        title = each.title if each.title.endswith(("?", ".")) else f"{each.title}:"
        yield Paragraph(" ".join((title, *each.sentences[:1])))


def _causes(findings: Findings, units: Units) -> Iterable[Block]:
    """The measurements that would narrow each speed the most, of those that visibly would."""
    if not findings.narrowing:
        return
    symbol, lines = unit_of("speed", units).symbol, list[str]()
    for sought, known in findings.narrowing.items():
        label, now = _speed_and_sd(findings, sought, units)
        measured = [each for each in known if each.measured is not None][:_CAUSES]
        for each in measured:
            left = _sd_left(findings, sought, units, each)
            if left != now:
                name = label_and_unit(each.name, units)[0]
                lines.append(f"{name}: {label} from ± {now} to ± {left} {symbol}")
    if lines:
        yield Paragraph("Known exactly, each alone would narrow the answer (standard deviation):")
        yield Listing(tuple(lines))
    else:
        yield Paragraph("No single measurement, known exactly, would visibly narrow the answer.")


def _verdict(findings: Findings) -> tuple[Block, ...]:
    flags = findings.checks.flags
    text = "Findings about the scene that a reader should know:"
    notes: tuple[Block, ...] = (Paragraph(text), Listing(flags)) if flags else ()
    return (Paragraph(findings.verdict), *notes)


def _assumed(findings: Findings) -> str:
    """Which inputs and items of evidence were not measured, in a sentence or two."""
    sentences = []
    for what, words in (
        ("value", "Neither value nor uncertainty was measured of"),
        ("sd", "Only the uncertainty is assumed of"),
    ):
        labels = [row.label for row in findings.measured if row.assumed == what]
        if labels:
            sentences.append(f"{words} {len(labels)}: {'; '.join(labels)}.")
    if not sentences:
        return "Every input and its uncertainty are stated as measured; sources are listed below."
    return " ".join((*sentences, "The sources of these figures are listed below."))


def _first_sentence(text: str) -> str:
    return text.partition(". ")[0].rstrip(".") + "."


# ---- the sections


def _results(findings: Findings, units: Units, pictures: Mapping[str, list[Picture]]) -> Section:
    derived = tuple(_result_tables(findings, units, findings.derived))
    warned = "" if findings.checks.passed else f" {MARK} {NOT_TO_BE_RELIED_ON}: see the first page."
    return Section(
        "Results",
        (
            *_result_tables(findings, units, findings.quantities),
            Paragraph(
                "Intervals are the shortest that hold the stated share of the posterior draws. "
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
    """In the units that come first; then, of what has another unit there, in the others."""
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
                        _named(row.label, row.unit),
                        row.median,
                        row.mean,
                        *(row.intervals[level] for level in _LEVELS),
                    )
                    for row in rows
                ),
                title=_SYSTEMS[system],
            )


def _questions(findings: Findings, pictures: Mapping[str, list[Picture]]) -> Section | None:
    def part(number: int, each: Answered) -> Section:
        blocks: list[Block] = [Paragraph(sentence) for sentence in each.sentences]
        if each.rows:
            blocks.append(Table(each.rows, each.header))
        return Section(each.title, (*blocks, *pictures[f"question {number}"]))

    parts = tuple(part(number, each) for number, each in enumerate(findings.questions))
    return Section("Questions put", parts) if parts else None


def _evidence(
    findings: Findings, units: Units, case: Case, pictures: Mapping[str, list[Picture]]
) -> Section:
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
            "Behind “run-out” stands how far the run-out is taken to miss a real car there, by the "
            "assumptions listed under The model. Likelihood and shift take it together with the "
            "measurement's own error.",
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
            _named(row.label, row.unit(units)),
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
    """Where each mark lies and what passed there, in words."""
    unit = unit_of("length", units)
    return [
        f"mark {number} of {v.upper()}: x = {format_value(mark.x / unit.worth, 2)} {unit.symbol}, "
        f"y = {format_value(mark.y / unit.worth, 2)} {unit.symbol}, "
        + ("centre of gravity" if mark.of == "centre" else f"{mark.of.replace('_', ' ')} wheel")
        for v, marks in findings.scene.marks.items()
        for number, mark in enumerate(marks, start=1)
    ]


def _inputs(findings: Findings, units: Units) -> Section:
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


def _model(findings: Findings) -> Section:
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


def _priors(findings: Findings) -> Section:
    table = Table(tuple(findings.description.priors), ("Quantity", "Prior", "Reason"), texts=(1, 2))
    text = "What was assumed of the unknowns before the evidence was used."
    return Section("Priors", (Paragraph(text), table))


def _sensitivity(
    findings: Findings, units: Units, pictures: Mapping[str, list[Picture]]
) -> Section:
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
        "same draws. Of what was not measured some could be, by recorders, marks or witnesses. Two "
        "quantities together may do more than either alone."
    )
    speed = unit_of("speed", units)
    for sought, known in findings.narrowing.items():
        label, now = _speed_and_sd(findings, sought, units)
        rows = []
        for each in known[:_MOST_TELLING]:
            name, unit = label_and_unit(each.name, units)
            m = each.measured
            as_now = (
                format_with_sd(m.value / unit.worth, m.sd / unit.worth) if m else "not measured"
            )
            left = _sd_left(findings, sought, units, each)
            rows.append((_named(name, unit.symbol), as_now, left))
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
    """Decimals of an sd that stands beside the one of a quantity, which it does not exceed in digits."""
    own, known = decimals_of(sd), findings.quantities[name].precision[units].decimals
    return own if known is None or own is None else min(own, known)


def _left_out(findings: Findings, units: Units) -> Iterable[Block]:
    told = [item for item in findings.left_out if item.told]
    if told:
        yield Paragraph(
            "What all else says of each measurement, by weighing the draws anew without it, and the "
            "speed of B that would be found. ► marks a measurement that all else makes less probable "
            f"than {format_value(100 * DOUBT, 0)} %."
        )
        speed = unit_of("speed", units)
        rows = tuple(_without(findings, units, item) for item in told)
        yield Table(
            rows,
            (
                "Item",
                "Measured ± sd",
                "All else expects ± sd",
                "Probability",
                f"Speed of B without it ± sd, {speed.symbol}",
            ),
        )
    if missing := [label_and_unit(i.name, units)[0] for i in findings.left_out if not i.told]:
        yield Paragraph(
            f"Nothing cross-checks {'; '.join(missing)}: so much depends on "
            f"{'it' if len(missing) == 1 else 'each of these'} that the draws cannot be weighed anew "
            "without it (Pareto k above 0.7)."
        )


def _without(findings: Findings, units: Units, item: LeftOut) -> tuple[str, ...]:
    label, unit = label_and_unit(item.name, units)
    speed = unit_of("speed", units).worth
    sd = item.speed_b_sd / speed
    decimals = decimals_of(sd)
    if "speed_b" in findings.quantities:
        decimals = _decimals(findings, "speed_b", units, sd)
    probability = marked(findings, format_value(item.probability, 3))
    return (
        _named(label, unit.symbol),
        format_with_sd(item.value / unit.worth, item.sd / unit.worth),
        marked(findings, format_with_sd(item.expected / unit.worth, item.expected_sd / unit.worth)),
        f"► {probability}" if item.disagrees else probability,
        marked(findings, format_with_sd(item.speed_b / speed, sd, decimals)),
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
            decimals_of(item.speed_b_sd / speed.worth, error=item.moved_error / speed.worth),
        )
        if NOTHING not in (believed, moved):
            label = label_and_unit(item.name, units)[0]
            rows.append((label, marked(findings, believed), marked(findings, moved)))
    if not rows:
        yield Paragraph("Not told: errors of the evidence have heavy tails here.")
        return
    yield Paragraph(
        "What an error in a measurement would do, to first order: which share of it would be believed, "
        "for want of anything that contradicts it, and how far an error of one standard deviation would "
        "move the speed of B. Where nearly all is believed, a reading that is wrong by many standard "
        "deviations passes unseen."
    )
    yield Table(tuple(rows), ("Item", "Error believed, %", f"Speed of B moved, {speed.symbol}"))


def _numerical_quality(findings: Findings, units: Units) -> Section:
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
    rows = tuple(
        (
            _named(row.label, row.unit),
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
    blocks.append(
        Section(
            "Quantity by quantity",
            (
                Table(rows, heads),
                Paragraph(
                    "The error is that of drawing (Monte Carlo); only those digits are printed of "
                    "which it is below a unit. R-hat compares the chains with one another; the "
                    "effective sample size (ESS) says how many independent draws they are worth, for "
                    "the middle (bulk) and for the ends (tail) of a distribution.",
                    "quiet",
                ),
            ),
        )
    )
    return Section("Numerical quality", tuple(blocks))


def _model_comparison(findings: Findings, units: Units) -> Section | None:
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
            ("Model", "Verdict", "Furthest evidence", "Speed of B under other priors of it"),
            texts=(1, 2, 3),
        ),
    ]
    left = [row for row in rows if not row.ran]
    blocks += [
        Paragraph(
            f"Not run: {', '.join(row.name for row in left if row.verdict == verdict)}: {verdict}."
        )
        for verdict in dict.fromkeys(row.verdict for row in left)
    ]
    blocks.append(
        Paragraph(
            "p is the probability of a misfit as large, of evidence and inputs together, were the model "
            "true. The ln evidence (log marginal likelihood) may be compared only between models that "
            "explain the same data. The half-normal prior of B's speed was halved and doubled in scale, "
            "and made flat, by weighing the same draws anew.",
            "quiet",
        )
    )
    return Section("Comparison of models", tuple(blocks))


def _reproduction(findings: Findings) -> Section:
    text = findings.scene_text
    options = {"model": findings.description.name, **findings.settings, "seed": findings.seed}
    command = " ".join([COMMAND, *(f"--{name} {value}" for name, value in options.items())])
    how = (
        "as it was written"
        if text.as_written
        else "made from the values that were computed with, because the scene was changed after its "
        "file was read, or had none"
    )
    rows = {
        **{name: str(value) for name, value in options.items()},
        **findings.versions,
        **{f"seconds, {name}": format_value(s, 1) for name, s in findings.seconds.items()},
    }
    return Section(
        "Reproduction",
        (
            Paragraph("With the scene file below saved as scene.toml:"),
            Code(command),
            Table(tuple(rows.items()), texts=(1,)),
            Paragraph(f"The scene file, {how}; SHA-256 {text.sha256}:"),
            Code(text.text),
        ),
    )


def _expert(case: Case) -> Section:
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
    told = tuple(
        (name, (value if isinstance(value, str) else "; ".join(value)) or NOT_STATED)
        for name, value in rows.items()
    )
    return Section("The expert", (Table(told, texts=(1,)), Form(("Signature",))))


# ---- shared


def _named(label: str, unit: str) -> str:
    return f"{label}, {unit}" if unit else label


def _pictures(
    findings: Findings, images: Mapping[str, bytes], figures: Mapping[str, Registered]
) -> dict[str, list[Picture]]:
    """The figures by where they stand, numbered in the order in which they come."""
    of_question = {
        each.figure: f"question {number}"
        for number, each in enumerate(findings.questions)
        if each.figure
    }
    questions = [f"question {number}" for number in range(len(findings.questions))]
    places: dict[str, list[Picture]] = {
        place: [] for place in ("first page", "results", *questions, "evidence", "sensitivity")
    }
    names: dict[str, list[str]] = {place: [] for place in places}
    for name in images:
        names[of_question.get(name, figures[name].beside)].append(name)
    number = 0
    for place, of_place in names.items():
        for name in of_place:
            number += 1
            found = figures[name]
            places[place].append(Picture(str(number), found.title, found.caption, images[name]))
    return places
