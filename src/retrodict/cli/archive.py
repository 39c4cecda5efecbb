"""The command `retrodict archive`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from retrodict.cli.options import Quiet, ResultFolder
from retrodict.cli.running import LOADING, WRITING, print_path, refusing, working, writing


def archive(
    result: ResultFolder,
    case: Annotated[
        Path | None, typer.Option(help="case file (TOML); its attachments' SHA-256 are recorded")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="the file [default: beside the folder, .retrodict.zip]")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Put a result and all that it came from into one file that can be verified and run anew."""
    with working(quiet) as progress:
        progress(LOADING, 0, 1)

        from retrodict.findings.stored import NotStored
        from retrodict.report.libraries import arviz_without_jax
        from retrodict.result import load_result
        from retrodict.scene import SceneError
        from retrodict.storage.archive import SUFFIX, read_archive

        arviz_without_jax()

        file = out or result.resolve().with_name(f"{result.resolve().name}{SUFFIX}")
        with refusing(NotStored, SceneError), writing(file, "archive"):
            found = load_result(result)
            progress(WRITING, 0, 1)
            link = read_archive(found.archive(file, case)).link
            progress(WRITING, 1, 1)

    from rich.console import Console

    console = Console(quiet=quiet)
    print_path(file, console)
    console.print(f"Its chain of hashes ends in {link}", highlight=False, soft_wrap=True)
