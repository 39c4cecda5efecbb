"""The command `retrodict explore`."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from retrodict.cli.options import ModelName, OutFolder, Seed, UnitChoice
from retrodict.cli.running import LOADING, fail, load_or_fail, output_folder, require_rung, working
from retrodict.progress import Progress

if TYPE_CHECKING:
    from retrodict.explore.board.board import Board
    from retrodict.live import Session
    from retrodict.scene import Scene


def explore(
    scene: Annotated[
        Path | None,
        typer.Argument(
            help="the scene file (TOML); without one, an empty board", show_default=False
        ),
    ] = None,
    out: OutFolder = None,
    model: ModelName = "auto",
    seed: Seed = 0,
    units: Annotated[UnitChoice, typer.Option(help="units that come first")] = UnitChoice.si,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="of the page; 0 for one that is free")
    ] = 0,
    browser: Annotated[bool, typer.Option(help="open the page in a browser")] = True,
    quiet: Annotated[bool, typer.Option("--quiet", help="print the page's address only")] = False,
) -> None:
    """Draw a scene to scale on a local page, or change it with sliders, and watch its answer.

    Ctrl-C ends it.
    """
    with working(quiet) as progress:
        progress(LOADING, 0, 1)
        board = _board(scene)
        if board is not None:
            found, file, name = board.scene, board.path, board.name
        else:
            assert scene is not None
            found, file = load_or_fail(scene), scene
            name = found.name
        folder = output_folder(out, name)

        from retrodict.report.libraries import MissingLibrary, imported

        try:
            imported("nicegui", "the page", "explore")
        except MissingLibrary as error:
            fail(str(error), 1)

        from retrodict.explore.server import address, listen, serve

        try:
            listening = listen(port)
        except OSError as error:
            fail(f"--port {port}: {error.strerror}; choose another, or leave it out", 1)

        require_rung(model, auto=True)

        from retrodict.explore.explorer import Explorer, Setting
        from retrodict.inference import Unanswerable
        from retrodict.live import session
        from retrodict.models import RUNGS
        from retrodict.studies.ladder import allowed

        models = tuple(RUNGS)
        if found is not None:
            try:
                models = tuple(allowed(found))
            except Unanswerable as error:
                fail(f"{scene}: {error}")
            if model not in ("auto", *models):
                fail(f"--model {model}: this scene allows auto and {', '.join(models)}")
        setting = Setting(models, folder, file.resolve(), units.value)

    def opened(of: Scene, by: str, progress: Progress) -> Session:
        return session(of, model=by, seed=seed, progress=progress)

    typer.echo(f"{address(listening)} (Ctrl-C ends it)")
    with suppress(KeyboardInterrupt):
        explorer = Explorer(
            found,
            opened,
            model,
            edit=board.edit if board else None,
            reset=board.restore if board else None,
        )
        serve(explorer, setting, listening, board=board, browser=browser)
    # at once: a computation that nobody waits for would hold up the interpreter's own end
    sys.stdout.flush()
    os._exit(0)


def _board(scene: Path | None) -> Board | None:
    """The drawing board of a scene file, or an empty one; None for a file that is not TOML."""
    from retrodict.explore.board.board import Board, untitled
    from retrodict.scene import SceneError
    from retrodict.scene.load import READERS, read_text

    if scene is not None and scene.suffix.lower() in set(READERS) - {".toml"}:
        return None
    path = scene or untitled(Path())
    try:
        if scene is not None:
            read_text(scene)  # says what is wrong with a file that cannot be read
        return Board(path)
    except SceneError as error:
        fail(str(error))
    except OSError as error:
        fail(str(error), 1)
