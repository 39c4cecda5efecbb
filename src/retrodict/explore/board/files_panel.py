"""The panels that take files: a photograph with its place on the ground, plans, points and recorders."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import events, ui

from retrodict.explore.board.arguments import reason, refused
from retrodict.explore.board.backdrop import LARGEST, by_world_file, kept
from retrodict.explore.board.board import Board
from retrodict.explore.board.evidence import taken
from retrodict.explore.board.state import State
from retrodict.scene.errors import SceneError

_WORLD_FILES = (".pgw", ".jgw", ".tfw", ".wld")


class FilesPanel:
    """What is dropped onto the board.

    Args:
        board: board that is drawn on.
        do: function that does an action by name and returns why it is refused.
        attempt: function that does anything else to the board and returns why it is refused.
        say: function that shows a line of text.
        fit: function that brings everything into view.
    """

    def __init__(
        self,
        board: Board,
        do: Callable[[str, dict[str, Any]], str],
        attempt: Callable[[Callable[[], object]], str],
        say: Callable[[str], object],
        fit: Callable[[], None],
    ) -> None:
        self._board, self._do = board, do
        self._try, self._say, self._fit = attempt, say, fit
        self._files: dict[bool, tuple[str, bytes]] = {}  # a map, and a file that it is for
        self._world_files: dict[str, bytes] = {}  # by name: the smaller of two files comes first

    def photograph(self) -> None:
        """Make the elements for a photograph."""
        ui.label(
            "A photograph or drone image (PNG or JPEG, or a GeoTIFF), with its world file where it has "
            "one. Else set its scale by two points (S), north (U) and the origin (I)."
        ).classes("small")
        self._note = ui.label("").classes("small")
        ui.upload(
            label="photograph", multiple=True, auto_upload=True, max_file_size=LARGEST,
            on_upload=self._uploaded,
            on_rejected=lambda: self._say("The photograph is too large."),
        ).props(
            f"flat bordered accept=.png,.jpg,.jpeg,.tif,.tiff,{','.join(_WORLD_FILES)}"
        ).classes("wide")  # fmt: skip
        ui.button("Take the photograph away", on_click=lambda: self._do("no_backdrop", {})).props(
            "flat dense no-caps"
        )

    def evidence(self) -> None:
        """Make the elements for files of evidence."""
        ui.label(
            "Survey points (CSV), a plan (DXF) or a recorder's table (CSV), and the map (TOML) that "
            "says how to read it. Points and the plan's lines are shown, and clicks near a point take "
            "it."
        ).classes("small")
        ui.upload(
            label="file and map", multiple=True, auto_upload=True, on_upload=self._brought
        ).props("flat bordered accept=.csv,.dxf,.toml").classes("wide")

    def show(self) -> None:
        """Say which photograph lies under the drawing."""
        backdrop = self._board.state.backdrop
        self._note.set_text(
            ""
            if backdrop is None
            else f"{backdrop.file}, {1 / backdrop.metres:.1f} pixels a metre"
            f"{'' if backdrop.scaled else ': a guess, set the scale'}; SHA-256 {backdrop.sha256}"
        )

    async def _brought(self, event: events.UploadEventArguments) -> None:
        name = event.file.name
        self._files[name.lower().endswith(".toml")] = (name, await event.file.read())
        if len(self._files) < 2:
            self._say(f"{name}: now its {'file' if True in self._files else 'map'}")
            return
        file, of_map = self._files.pop(False), self._files.pop(True)
        why = self._try(lambda: self._board.change(lambda state: taken(state, *file, *of_map)))
        self._say(why or f"Taken from {file[0]}")
        self._fit()

    async def _uploaded(self, event: events.UploadEventArguments) -> None:
        content, name = await event.file.read(), event.file.name
        stem = Path(name).stem
        if name.lower().endswith(_WORLD_FILES):
            self._world_files[stem] = content
            if self._board.state.backdrop is None:
                self._say(f"{name}: now its photograph")
                return
            why = self._try(lambda: self._board.change(partial(_placed, content)))
        else:
            path = self._board.path
            try:  # a large one is read for seconds, in which the page goes on
                backdrop = await asyncio.to_thread(kept, content, path.parent, path.stem)
            except (SceneError, OSError) as error:
                self._say(reason(error))
                return

            def put(state: State) -> State:
                return replace(state, backdrop=backdrop, said="a photograph")

            why = self._try(lambda: self._board.change(put))
            if not why and stem in self._world_files:
                place = partial(_placed, self._world_files.pop(stem))
                why = self._try(lambda: self._board.change(place))
        self._say(why)
        self._fit()


def _placed(content: bytes, state: State) -> State:
    if state.backdrop is None:
        raise refused("the photograph comes before its world file")
    placed = by_world_file(state.backdrop, content[:1000].decode("ascii", "replace"))
    return replace(state, backdrop=placed, said="the photograph placed by its world file")
