"""The command `retrodict replay`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli.options import Quiet
from retrodict.cli.running import DIFFERS, INTERRUPTED, LOADING, refusing, working
from retrodict.progress import printable


def replay(
    archive: Annotated[Path, typer.Argument(help="an archive", show_default=False)],
    quiet: Quiet = False,
) -> None:
    """Verify an archive, run it anew, and say which numbers come out the same."""
    with working(quiet) as progress:
        progress(LOADING, 0, 1)

        from retrodict.api import replay as run
        from retrodict.inference import Interrupted, Unanswerable
        from retrodict.scene import SceneError
        from retrodict.storage.archive import NotArchived

        with (
            refusing(OSError, prefix=f"{archive}: cannot be read: "),
            refusing(Interrupted, prefix=f"{archive}: ", status=INTERRUPTED),
            refusing(SceneError, Unanswerable, ValueError, prefix=f"{archive}: "),
            refusing(NotArchived),
        ):
            found = run(archive, progress=progress)

    from rich.console import Console

    from retrodict.report.reproduction import reproduction_lines

    console = Console(quiet=quiet)
    for line in reproduction_lines(found):
        console.print(printable(line), highlight=False, markup=False, soft_wrap=True)
    if not found.reproduced:
        raise typer.Exit(DIFFERS)
