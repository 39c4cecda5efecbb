"""The command `retrodict explore`."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated

import typer

from retrodict.cli.options import ModelName, OutFolder, SceneFile, Seed, UnitChoice
from retrodict.cli.running import LOADING, fail, load_or_fail, output_folder, require_rung, working
from retrodict.progress import Progress

if TYPE_CHECKING:
    from retrodict.live import Session
    from retrodict.scene import Scene


def explore(
    scene: SceneFile,
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
    """Change a scene with sliders on a local page, and watch its answer. Ctrl-C ends it."""
    with working(quiet) as progress:
        found = load_or_fail(scene)
        folder = output_folder(out, found.name)
        progress(LOADING, 0, 1)

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
        from retrodict.studies.ladder import allowed

        try:
            models = tuple(allowed(found))
        except Unanswerable as error:
            fail(f"{scene}: {error}")
        if model not in ("auto", *models):
            fail(f"--model {model}: this scene allows auto and {', '.join(models)}")
        setting = Setting(models, folder, scene.resolve(), units.value)

    def opened(of: Scene, by: str, progress: Progress) -> Session:
        return session(of, model=by, seed=seed, progress=progress)

    typer.echo(f"{address(listening)} (Ctrl-C ends it)")
    with suppress(KeyboardInterrupt):
        serve(Explorer(found, opened, model), setting, listening, browser=browser)
    # at once: a computation that nobody waits for would hold up the interpreter's own end
    sys.stdout.flush()
    os._exit(0)
