"""The command `retrodict batch`."""

from __future__ import annotations

from enum import StrEnum
from glob import glob
from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli.options import Quiet, ResultUnits, Seed, UnitChoice
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
from retrodict.progress import printable


class DeviceChoice(StrEnum):
    """What JAX computes on."""

    cpu = "cpu"
    gpu = "gpu"


def batch(
    scenes: Annotated[
        list[str],
        typer.Argument(help='scene files, or patterns: "crashes/**/*.toml"', show_default=False),
    ],
    out: Annotated[
        Path, typer.Option(help="folder for the results; the same command goes on with it")
    ],
    model: Annotated[
        str,
        typer.Option(help="a rung's name, or auto: the whole ladder for each scene, which is slow"),
    ] = "planar-moment+wheels",
    workers: Annotated[
        int | None,
        typer.Option(
            min=1, max=1024, help="processes [default: one a core; 1 without the extra cluster]"
        ),
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="address of a Dask cluster, in place of processes here")
    ] = None,
    seed: Seed = 0,
    units: ResultUnits = UnitChoice.si,
    device: Annotated[DeviceChoice, typer.Option(help="to compute on")] = DeviceChoice.cpu,
    quiet: Quiet = False,
) -> None:
    """Answer many scenes, each by itself, in one table."""
    with working(quiet) as progress:
        if workers and scheduler:
            fail(f"--workers {workers} --scheduler {scheduler}: choose one of them")
        files = _files(scenes)
        folder = output_folder(out, "batch")
        progress(LOADING, 0, 1)

        require_rung(model, auto=True)

        from retrodict.api import batch as run
        from retrodict.studies.device import NoDevice
        from retrodict.studies.engine import NoScheduler

        with (
            refusing(ValueError),
            refusing(NoDevice, prefix=f"--device {device.value}: "),
            writing(folder),
            refusing(NoScheduler, prefix="--scheduler "),
        ):
            table = run(
                files,
                model=model,
                seed=seed,
                units=units.value,
                out=folder,
                workers=workers,
                scheduler=scheduler,
                device=device.value,
                progress=progress,
            )

    if len(table) < len(files):
        fail(
            f"interrupted: {len(table)} of {len(files)} scenes are answered; the same command goes on",
            INTERRUPTED,
        )

    from rich.console import Console

    from retrodict.report.batch import files_of, in_words

    console = Console(quiet=quiet)
    console.print(printable(in_words(table)), highlight=False, markup=False)
    for file in files_of(folder):
        print_path(file, console)


def _files(patterns: list[str]) -> list[str]:
    """The files that patterns match, each once; a name that is no pattern stands for itself."""
    found: dict[str, None] = {}
    for pattern in patterns:
        matched = [pattern] if Path(pattern).is_file() else sorted(glob(pattern, recursive=True))
        if not matched:
            fail(f"{pattern}: no scene file is there; write paths, or a pattern in quotes")
        found |= dict.fromkeys(matched)
    return list(found)
