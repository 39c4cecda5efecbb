"""The content of a report: a document is made once from the findings, with every cell formatted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from retrodict.report import assessment, sections
from retrodict.report.blocks import Document, Picture, numbered, printable
from retrodict.report.first_page import first_page
from retrodict.scene.case import Case
from retrodict.scene.quantities import Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.report.figures.registry import Registered


def content(
    findings: Findings,
    images: Mapping[str, bytes],
    figures: Mapping[str, Registered],
    units: Units = "si",
    case: Case | None = None,
) -> Document:
    """The report of a reconstruction.

    Args:
        findings: findings of the reconstruction.
        images: PNG images of the figures, by name.
        figures: titles, captions and places of the figures, by name.
        units: "si" or "us", the system that comes first and that inputs are printed in.
        case: the expert's statements on the case; None where nothing is stated.

    Returns:
        The document. Characters that do not print are written as their codes.
    """
    case = case or Case()
    pictures = _pictures(findings, images, figures)
    scene = findings.scene
    who = [f"vehicle {v.upper()}, {vehicle.name}" for v, vehicle in scene.vehicles.items()]
    who += [scene.barrier.name] if scene.barrier else []
    chosen = [
        sections.results(findings, units, pictures),
        sections.questions(findings, units, pictures),
        sections.evidence(findings, units, case, pictures),
        sections.inputs(findings, units),
        sections.model(findings),
        sections.priors(findings),
        assessment.sensitivity(findings, units, pictures),
        assessment.numerical_quality(findings, units),
        assessment.model_comparison(findings, units),
        sections.reproduction(findings),
        sections.expert(case),
    ]
    document = Document(
        title=scene.title,
        subtitle=f"Reconstruction of a vehicle collision with its uncertainty: {'; '.join(who)}",
        author=case.examiner,
        date=case.dates.get("report", ""),
        units=units,
        first=first_page(findings, units, case, pictures),
        sections=tuple(
            numbered(section, str(number))
            for number, section in enumerate((s for s in chosen if s is not None), 1)
        ),
    )
    return printable(document)


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
