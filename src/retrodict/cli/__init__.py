"""The commands, thin, one a file: read a scene, reconstruct, report."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import typer

import retrodict
from retrodict.cli import (
    archive,
    batch,
    calibrate,
    check,
    compare,
    explore,
    export,
    import_,
    ladder,
    reconstruct,
    replay,
    report,
    validate,
    vehicles,
)

app = typer.Typer(
    name="retrodict",
    help="Reconstructs vehicle collisions and says how sure it is.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

_COMMANDS: dict[str, Callable[..., None]] = {  # in the order of --help
    "check": check.check,
    "vehicles": vehicles.vehicles,
    "import": import_.import_,
    "reconstruct": reconstruct.reconstruct,
    "explore": explore.explore,
    "report": report.report,
    "compare": compare.compare,
    "export": export.export,
    "archive": archive.archive,
    "replay": replay.replay,
    "ladder": ladder.ladder,
    "batch": batch.batch,
    "calibrate": calibrate.calibrate,
    "validate": validate.validate,
}
for _name, _command in _COMMANDS.items():
    app.command(_name)(_command)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"retrodict {retrodict.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="the version")
    ] = False,
) -> None:
    pass
