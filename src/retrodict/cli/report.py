"""The command `retrodict report`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli.options import Quiet, ResultFolder, UnitChoice
from retrodict.cli.running import (
    LOADING,
    WRITING,
    output_folder,
    print_path,
    refusing,
    working,
    writing,
)


def report(
    result: ResultFolder,
    formats: Annotated[
        str, typer.Option("--format", help="html, pdf, docx, or several with commas")
    ] = "html",
    case: Annotated[
        Path | None, typer.Option(help="case file (TOML): number, examiner, attachments …")
    ] = None,
    units: Annotated[
        UnitChoice | None, typer.Option(help="units that come first [default: the case's, or si]")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="folder for the report [default: that of the result]")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write the report of a finished run as HTML page, PDF or Word document."""
    from retrodict.report.document import UnknownFormat, document_of, renderers, write_reports
    from retrodict.scene import SceneError
    from retrodict.scene.case import load_case

    with refusing(UnknownFormat, prefix=f"--format {formats}: "), refusing(SceneError):
        wanted = list(renderers(formats.split(",")))
        known = None if case is None else load_case(case)
    with working(quiet) as progress:
        folder = result if out is None else output_folder(out, "report")
        progress(LOADING, 0, 1)

        from retrodict.findings.stored import NotStored
        from retrodict.report.libraries import arviz_without_jax
        from retrodict.report.pdf import NoGlyph
        from retrodict.result import load_result

        arviz_without_jax()

        with (
            refusing(NotStored, SceneError),
            refusing(NoGlyph, status=1),
            writing(folder, "report"),
        ):
            found = load_result(result)
            progress(WRITING, 0, 1)
            chosen = units.value if units else (known and known.units) or "si"
            document = document_of(found.findings_for(known), found.outcome, chosen, known)
            files = write_reports(document, folder, wanted)
            progress(WRITING, 1, 1)

    from rich.console import Console

    for file in files:
        print_path(file, Console(quiet=quiet))
