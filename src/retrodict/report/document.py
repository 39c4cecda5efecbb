"""The documents: a format is one renderer file and one line in `FORMATS`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from retrodict.report import html, pdf, word
from retrodict.report.blocks import Document, printable
from retrodict.report.content import content
from retrodict.scene.quantities import Units
from retrodict.storage.files import write_whole

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.case import Case

Renderer = Callable[[Document], bytes]

# renderers by file suffix; heavy libraries are imported where a document is rendered
FORMATS: dict[str, Renderer] = {
    "html": html.render,
    "pdf": pdf.render,
    "docx": word.render,
}


class UnknownFormat(ValueError):
    """No document has that suffix; the message lists the suffixes that there are."""

    def __init__(self, suffix: str) -> None:
        super().__init__(f"no document format {suffix!r}: choose of {', '.join(FORMATS)}")


def document_of(
    findings: Findings,
    outcome: Outcome,
    units: Units = "si",
    case: Case | None = None,
    drawn: dict[str, bytes] | None = None,
) -> Document:
    """The report of a reconstruction, for every format.

    Args:
        findings: findings of the reconstruction.
        outcome: outcome of the reconstruction, with the draws that the figures show.
        units: "si" or "us", the system that comes first and that inputs and figures are printed in.
        case: the expert's statements on the case; None where nothing is stated.
        drawn: images of the figures, by name; None to draw them.

    Returns:
        The document.
    """
    # matplotlib is slow to import
    from retrodict.report.figures.registry import figures_of, images
    from retrodict.report.replay_html import replay_fragment

    replay = printable(replay_fragment(findings, outcome, units))
    if drawn is None:
        drawn = images(findings, outcome, units)
    return replace(content(findings, drawn, figures_of(findings), units, case), replay=replay)


def renderers(suffixes: Iterable[str]) -> dict[str, Renderer]:
    """The renderers of document formats.

    Args:
        suffixes: file suffixes of the formats, without the dot, in any case.

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
        findings: findings of the reconstruction.
        outcome: outcome of the reconstruction, with the draws that the figures show.
        path: path of the report; its suffix selects the format.
        units: "si" or "us", as in `document_of`.
        case: the expert's statements on the case, as in `document_of`.

    Returns:
        The path.

    Raises:
        UnknownFormat: no format has that suffix.
        MissingLibrary: the format needs a library that is not installed.
        OSError: the file could not be written; an existing file is unchanged.
    """
    ((_, render),) = renderers([path.suffix.removeprefix(".")]).items()
    return write_whole(path, render(document_of(findings, outcome, units, case)))


def write_reports(
    document: Document, folder: Path, suffixes: Iterable[str], name: str = "report"
) -> list[Path]:
    """Write a document as NAME.SUFFIX in each of several formats, once all are rendered.

    Args:
        document: document to render, such as `document_of` returns.
        folder: output folder, made where missing.
        suffixes: keys of `FORMATS`, in any case.
        name: name of the files without suffix.

    Returns:
        The files.

    Raises:
        UnknownFormat, MissingLibrary, OSError: as in `write_report`.
    """
    made = {suffix: render(document) for suffix, render in renderers(suffixes).items()}
    return [write_whole(folder / f"{name}.{suffix}", each) for suffix, each in made.items()]
