"""The command `retrodict export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli.options import Quiet, UnitChoice
from retrodict.cli.running import (
    LOADING,
    WRITING,
    fail,
    output_folder,
    print_path,
    refusing,
    working,
    writing,
)


def export(
    result: Annotated[
        Path,
        typer.Argument(
            help="folder of a result, as reconstruct wrote it, or an archive", show_default=False
        ),
    ],
    formats: Annotated[
        str | None,
        typer.Option(
            "--format",
            help="motion, dxf, svg, tables, netcdf, parquet, or several with commas [default: all]",
        ),
    ] = None,
    draw: Annotated[
        list[str] | None,
        typer.Option(
            help="whose motion: median, a percentage of the sought speed, or a draw's number; may be "
            "repeated [default: median, 5%, 95%]"
        ),
    ] = None,
    rate: Annotated[float, typer.Option(help="of motions, frames a second")] = 30.0,
    before: Annotated[
        float, typer.Option(help="how long before the impact motions begin, s")
    ] = 1.0,
    units: Annotated[UnitChoice, typer.Option(help="units of tables")] = UnitChoice.si,
    out: Annotated[
        Path | None, typer.Option(help="folder for the files [default: RESULT/export]")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write a finished run for other programs: motions, DXF, SVG, tables and draws."""
    with working(quiet) as progress:
        if out is None and result.is_file():
            fail(f"{result}: an archive is left as it is; name a folder for the files with --out")
        folder = output_folder(result / "export" if out is None else out, "export")
        progress(LOADING, 0, 1)

        from retrodict.report.libraries import arviz_without_jax

        arviz_without_jax()

        from retrodict.findings.run_outs import NoMotion
        from retrodict.findings.stored import NotStored
        from retrodict.report.export import Asked, NotExported, checked
        from retrodict.result import load_result
        from retrodict.storage.archive import NotArchived

        with refusing(NotStored, NotArchived, NotExported, NoMotion), writing(folder, "files"):
            wanted = checked(() if formats is None else formats.split(","), Asked((), rate, before))
            found = load_result(result)
            progress(WRITING, 0, 1)
            files = found.export(
                folder, wanted, draws=draw or (), rate=rate, before=before, units=units.value
            )
            progress(WRITING, 1, 1)

    from rich.console import Console

    console = Console(quiet=quiet)
    for file in files:
        print_path(file, console)
    if not found.checks.passed:
        console.print(found.findings.verdict, highlight=False, markup=False)
