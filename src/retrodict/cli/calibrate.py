"""The command `retrodict calibrate`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli.options import ExactChoice, Quiet, Seed
from retrodict.cli.running import (
    INTERRUPTED,
    LOADING,
    load_or_fail,
    output_folder,
    print_path,
    refusing,
    require_rung,
    working,
    writing,
)


def calibrate(
    model: Annotated[str, typer.Option(help="a rung's name")] = "planar-moment+wheels",
    method: Annotated[ExactChoice, typer.Option(help="how to draw")] = ExactChoice.importance,
    simulations: Annotated[int, typer.Option(min=2, max=100_000, help="how many")] = 1000,
    scene: Annotated[
        Path | None, typer.Option(help="the design, a scene file [default: the package's]")
    ] = None,
    seed: Seed = 0,
    out: Annotated[
        Path | None,
        typer.Option(help="folder for the results [default: out/calibration/MODEL-METHOD]"),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Simulate crashes and reconstruct them: are the posteriors as sure as they may be?"""
    with working(quiet) as progress:
        found = None if scene is None else load_or_fail(scene)
        progress(LOADING, 0, 1)

        require_rung(model, auto=False)
        folder = output_folder(out, f"calibration/{model}-{method.value}")

        from retrodict.api import calibrate as run

        with refusing(ValueError), writing(folder):
            done = run(
                found,
                model=model,
                method=method.value,
                simulations=simulations,
                seed=seed,
                out=folder,
                progress=progress,
            )

    from rich.console import Console

    from retrodict.report.calibration import print_calibration

    console = Console(quiet=quiet)
    print_calibration(done, console)
    print_path(folder / "calibration.json", console)
    if not done.complete:
        raise typer.Exit(INTERRUPTED)
