"""The documents: a format is one renderer file and one line in `FORMATS`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from retrodict.report import html, pdf, word
from retrodict.report.blocks import Document, printable
from retrodict.report.content import content
from retrodict.report.files import write_whole
from retrodict.scene.quantities import Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.case import Case

Images = Callable[[], dict[str, bytes]]  # figures' images by name
Renderer = Callable[[Document], bytes]

# by the suffix of the file; heavy libraries are imported where a document is rendered
FORMATS: dict[str, Renderer] = {
    "html": html.render,
    "pdf": pdf.render,
    "docx": word.render,
}


class UnknownFormat(ValueError):
    """No document has that suffix; the message lists those that there are."""

    def __init__(self, suffix: str) -> None:
        super().__init__(f"no document format {suffix!r}: choose of {', '.join(FORMATS)}")


def document_of(
    findings: Findings,
    outcome: Outcome,
    units: Units = "si",
    case: Case | None = None,
    drawn: Images | None = None,
) -> Document:
    """What the report of a reconstruction says, in every format.

    Args:
        findings: of the reconstruction.
        outcome: its draws, for the figures.
        units: "si" or "us": which come first, and which inputs and figures are printed in.
        case: what the expert says; None where nothing is stated.
        drawn: gives the figures' images, where they are drawn elsewhere.

    Returns:
        The document.
    """
    # matplotlib is slow to import
    from retrodict.report.figures import figures_of, images
    from retrodict.report.replay_html import replay_fragment

    replay = printable(replay_fragment(findings, outcome, units))
    drawings = drawn() if drawn else images(findings, outcome, units)
    return replace(content(findings, drawings, figures_of(findings), units, case), replay=replay)


def renderers(suffixes: Iterable[str]) -> dict[str, Renderer]:
    """The renderers of formats.

    Args:
        suffixes: of their files, in any case.

    Returns:
        Functions that render a document, by suffix.

    Raises:
        UnknownFormat: there is no such format.
    """
    wanted = [suffix.strip().lower() for suffix in suffixes]
    for suffix in wanted:
        if suffix not in FORMATS:
            raise UnknownFormat(suffix)
    return {suffix: FORMATS[suffix] for suffix in wanted}


def write_report(
    findings: Findings,
    outcome: Outcome,
    path: Path,
    units: Units = "si",
    case: Case | None = None,
) -> Path:
    """Write the report in the format of the file's suffix, whole or not at all.

    Args:
        findings: of the reconstruction.
        outcome: its draws, for the figures.
        path: of the file.
        units: as of `document_of`.
        case: likewise.

    Returns:
        The path.

    Raises:
        UnknownFormat: no format has that suffix.
        MissingLibrary: the format needs a library that is not installed.
        OSError: the file could not be written; one that was there is as it was.
    """
    ((_, render),) = renderers([path.suffix.removeprefix(".")]).items()
    return write_whole(path, render(document_of(findings, outcome, units, case)))


def write_reports(
    document: Document, folder: Path, suffixes: Iterable[str], name: str = "report"
) -> list[Path]:
    """Write a document as NAME.SUFFIX in each of several formats, once all are rendered.

    Args:
        document: from `document_of`.
        folder: made where missing.
        suffixes: of `FORMATS`.
        name: of the files.

    Returns:
        The files.

    Raises:
        UnknownFormat, MissingLibrary, OSError: as of `write_report`.
    """
    made = {suffix: render(document) for suffix, render in renderers(suffixes).items()}
    return [write_whole(folder / f"{name}.{suffix}", each) for suffix, each in made.items()]
