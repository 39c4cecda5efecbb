"""The command `retrodict batch`."""

from __future__ import annotations

from enum import StrEnum
from glob import glob
from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli import (
    _LOADING,
    INTERRUPTED,
    UnitChoice,
    _fail,
    _folder,
    _known_rung,
    _name,
    _working,
    app,
)
from retrodict.progress import printable


class DeviceChoice(StrEnum):
    """What JAX computes on."""

    cpu = "cpu"
    gpu = "gpu"


@app.command()
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
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="of every random number")] = 0,
    units: Annotated[UnitChoice, typer.Option(help="units of the table")] = UnitChoice.si,
    device: Annotated[DeviceChoice, typer.Option(help="to compute on")] = DeviceChoice.cpu,
    quiet: Annotated[bool, typer.Option("--quiet", help="print errors only")] = False,
) -> None:
    """Answer many scenes, each by itself, in one table."""
    with _working(quiet) as progress:
        if workers and scheduler:
            _fail(f"--workers {workers} --scheduler {scheduler}: choose one of them")
        files = _files(scenes)
        folder = _folder(out, "batch")
        progress(_LOADING, 0, 1)

        _known_rung(model, auto=True)

        from retrodict.api import batch as run
        from retrodict.report.libraries import MissingLibrary
        from retrodict.studies.device import NoDevice
        from retrodict.studies.engine import NoScheduler

        try:
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
        except MissingLibrary as error:
            _fail(str(error), 1)
        except NoDevice as error:
            _fail(f"--device {device.value}: {error}")
        except NoScheduler as error:
            _fail(f"--scheduler {error}")
        except ValueError as error:
            _fail(str(error))
        except OSError as error:
            _fail(f"{folder}: cannot write the results: {error}", 1)

    if len(table) < len(files):
        _fail(
            f"interrupted: {len(table)} of {len(files)} scenes are answered; the same command goes on",
            INTERRUPTED,
        )

    from rich.console import Console

    from retrodict.report.batch import files_of, in_words

    console = Console(quiet=quiet)
    console.print(printable(in_words(table)), highlight=False, markup=False)
    for file in files_of(folder):
        _name(file, console)


def _files(patterns: list[str]) -> list[str]:
    """The files that patterns match, each once; a name that is no pattern stands for itself."""
    found: dict[str, None] = {}
    for pattern in patterns:
        matched = [pattern] if Path(pattern).is_file() else sorted(glob(pattern, recursive=True))
        if not matched:
            _fail(f"{pattern}: no scene file is there; write paths, or a pattern in quotes")
        found |= dict.fromkeys(matched)
    return list(found)
