"""The command `retrodict import`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli.running import print_path, refusing, writing


def import_(
    file: Annotated[
        Path,
        typer.Argument(
            help="survey points (CSV, LandXML), a drawing (DXF) or a recorder's table (CSV)"
        ),
    ],
    map_file: Annotated[
        Path,
        typer.Option("--map", help="the map (TOML): what the file holds and what the scene takes"),
    ],
    into: Annotated[Path, typer.Option(help="the scene file (TOML) that takes it")],
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="show what would be taken, and write nothing")
    ] = False,
) -> None:
    """Take evidence from another program's file into a scene file, each value with its source."""
    from rich.console import Console

    from retrodict.interchange.importing import import_evidence
    from retrodict.report.imported import print_import
    from retrodict.report.libraries import MissingLibrary, imported
    from retrodict.scene import SceneError
    from retrodict.storage.files import write_whole

    with refusing(SceneError), refusing(MissingLibrary, status=1):
        if file.suffix.lower() == ".dxf":
            imported("ezdxf", "a DXF file", "interchange")
        found = import_evidence(file, map_file, into)
    console = Console()
    print_import(found, console)
    if dry_run:
        return
    with writing(into, "scene file"):
        write_whole(into, found.text.encode())
    print_path(into, console)
