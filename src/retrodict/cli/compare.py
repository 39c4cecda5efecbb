"""The command `retrodict compare`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from retrodict.cli.options import Quiet, UnitChoice
from retrodict.cli.running import (
    LOADING,
    WRITING,
    output_folder,
    print_path,
    refusing,
    working,
    writing,
)

if TYPE_CHECKING:
    from retrodict.findings.differences import Differences
    from retrodict.progress import Progress
    from retrodict.result import Result
    from retrodict.studies.attribution import Step


def compare(
    one: Annotated[Path, typer.Argument(help="folder of a result", show_default=False)],
    other: Annotated[Path, typer.Argument(help="folder of another", show_default=False)],
    each: Annotated[
        bool,
        typer.Option("--each", help="reconstruct the first with each difference alone: minutes"),
    ] = False,
    formats: Annotated[
        str, typer.Option("--format", help="html, pdf, docx, or several with commas: also written")
    ] = "",
    units: Annotated[UnitChoice, typer.Option(help="units of the results")] = UnitChoice.si,
    out: Annotated[Path | None, typer.Option(help="folder for documents")] = None,
    quiet: Quiet = False,
) -> None:
    """Set two results beside each other: what differs, and how far it moves the answer."""
    from retrodict.report.document import UnknownFormat, renderers, write_reports
    from retrodict.scene import SceneError

    with refusing(UnknownFormat, prefix=f"--format {formats}: "):
        wanted = list(renderers(formats.split(","))) if formats else []
    folder = output_folder(out, f"{one.name}-{other.name}") if wanted else Path()
    with working(quiet) as progress:
        progress(LOADING, 0, 1)

        from rich.console import Console

        from retrodict.findings.differences import NothingInCommon
        from retrodict.findings.stored import NotStored
        from retrodict.report.comparison import compared
        from retrodict.report.pdf import NoGlyph
        from retrodict.report.terminal import print_document
        from retrodict.result import load_result

        with refusing(NotStored, SceneError, NothingInCommon):
            first, second = load_result(one), load_result(other)
            found = first.compare(second)
        sought = first.outcome.scene.sought
        steps = _each_alone(first, found, sought, progress) if each else ()
        progress(WRITING, 0, 1)
        document = compared(
            found,
            (first.findings, first.outcome),
            (second.findings, second.outcome),
            steps,
            sought,
            units.value,
        )
        with refusing(NoGlyph, status=1), writing(folder, "documents"):
            files = write_reports(document, folder, wanted, "comparison") if wanted else []
        progress(WRITING, 1, 1)
    console = Console(quiet=quiet)
    print_document(document, console)
    for file in files:
        print_path(file, console)


def _each_alone(
    first: Result, found: Differences, sought: str, progress: Progress
) -> tuple[Step, ...]:
    """How far each difference of the scene files moves the answer by itself."""
    if not found.scene:
        return ()
    from retrodict.findings.rounding import NOTHING
    from retrodict.studies.attribution import each_alone

    changes = {
        key: (old, None if new == NOTHING else new) for key, (old, new) in found.scene.items()
    }
    outcome = first.outcome
    return each_alone(
        outcome.scene, changes, outcome.description.name, sought, outcome.seed, progress
    )
