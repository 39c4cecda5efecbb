"""The command `retrodict ladder`."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from retrodict.cli.options import OutFolder, Quiet, ResultUnits, SceneFile, Seed, UnitChoice
from retrodict.cli.running import (
    INTERRUPTED,
    LOADING,
    WRITING,
    fail,
    load_or_fail,
    output_folder,
    print_path,
    refusing,
    working,
    writing,
)


def ladder(
    scene: SceneFile,
    out: OutFolder = None,
    share: Annotated[
        float,
        typer.Option(help="of its standard deviation that a fuller model may move an answer by"),
    ] = 0.25,
    factor: Annotated[
        float, typer.Option(help="by which a fuller model may widen or narrow it")
    ] = 1.25,
    seed: Seed = 0,
    units: ResultUnits = UnitChoice.si,
    quiet: Quiet = False,
) -> None:
    """Reconstruct on every model that the scene allows, and choose the lowest that will do."""
    with working(quiet) as progress:
        found = load_or_fail(scene)
        if not (0 < share < math.inf and 1 < factor < math.inf):
            fail(f"--share {share:g} --factor {factor:g}: share is above 0, and factor above 1")
        folder = output_folder(out, found.name)
        progress(LOADING, 0, 1)

        from retrodict.api import ladder as compare_models
        from retrodict.inference import Unanswerable
        from retrodict.report.ladder import write_ladder

        with refusing(Unanswerable, prefix=f"{scene}: "), writing(folder):
            comparison = compare_models(
                found, seed=seed, share=share, factor=factor, progress=progress
            )
            progress(WRITING, 0, 1)
            write_ladder(comparison, folder)
            progress(WRITING, 1, 1)

    from rich.console import Console

    from retrodict.report.terminal import print_ladder

    console = Console(quiet=quiet)
    print_ladder(comparison, console, units.value)
    print_path(folder / "ladder.json", console)
    if not comparison.complete:
        raise typer.Exit(INTERRUPTED)
