"""The command `retrodict validate`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli.options import MethodChoice, ModelName, Quiet, ResultUnits, UnitChoice
from retrodict.cli.running import (
    INTERRUPTED,
    LOADING,
    fail,
    output_folder,
    print_path,
    refusing,
    require_rung,
    working,
    writing,
)


def validate(
    folders: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[FOLDER]...",
            help="hold the cases: folders with scene.toml and truth.toml [default: examples]",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="folder for the results")] = Path("out/validation"),
    model: ModelName = "auto",
    method: Annotated[MethodChoice, typer.Option(help="how to draw")] = MethodChoice.importance,
    exchange: Annotated[
        bool,
        typer.Option(
            "--exchange", help="each case also with A and B exchanged, and in other units"
        ),
    ] = False,
    units: ResultUnits = UnitChoice.si,
    quiet: Quiet = False,
) -> None:
    """Reconstruct staged collisions, and compare with the speeds that were measured."""
    with working(quiet) as progress:
        output_folder(out, "validation")
        progress(LOADING, 0, 1)

        require_rung(model, auto=True)
        from retrodict.api import validate as run

        with refusing(ValueError), writing(out):
            done = run(
                folders or [Path("examples")],
                model=model,
                method=method.value,
                exchange=exchange,
                units=units.value,
                out=out,
                progress=progress,
            )

    from rich.console import Console

    from retrodict.report.validation import print_validation

    console = Console(quiet=quiet)
    print_validation(done, console, units.value)
    print_path(out / "validation.md", console)
    if done.faults:
        fail("\n".join(done.faults))
    if not done.complete:
        raise typer.Exit(INTERRUPTED)
