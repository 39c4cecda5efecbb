"""The board: the present state of a scene that is drawn, its history, and where it is kept."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from retrodict.explore.board.actions import perform
from retrodict.explore.board.journal import SUFFIX, History, InUse, Journal
from retrodict.explore.board.needs import Need, needs_of, scene_of
from retrodict.explore.board.plan import Plan, plan_of
from retrodict.explore.board.state import EMPTY, State
from retrodict.explore.naming import named
from retrodict.scene.errors import Problem, SceneError
from retrodict.scene.load import parse_scene, toml_of
from retrodict.scene.records import Scene
from retrodict.scene.text_edit import edited
from retrodict.storage.files import write_whole

UNTITLED = "untitled"
_FILE_BYTES = 100_000  # as `scene.load` has it


class Board:
    """A scene that is drawn. Every step is in the journal before it is shown.

    Args:
        path: path of the scene file, which need not exist yet.
        keep: whether to keep a journal beside it.

    Raises:
        SceneError: the file is there and cannot be changed on the board.
        InUse: another process draws on this scene.
        OSError: the file or its journal cannot be read.
    """

    def __init__(self, path: Path, keep: bool = True) -> None:
        self.path = path
        self.note = ""
        written = _text_of(path) if path.is_file() else None
        self._journal = Journal(path.with_name(f"{path.stem}{SUFFIX}")) if keep else None
        resumed = self._journal.resume() if self._journal else None
        self._begun = resumed is not None
        if resumed is None:
            self._history = History(State(EMPTY if written is None else written))
            self._saved = written
            return
        self._history = resumed
        self._saved = written
        if written is not None and written != self.state.text:
            if _digest(written) == resumed.saved:
                self.note = "Drawn before and not saved: the board goes on where it was."
            else:
                self._go(replace(self.state, text=written, said="the file, changed elsewhere"))
                self.note = (
                    "The file was changed elsewhere; undo leads back to what was drawn before."
                )
        elif written is None:
            self.note = "Drawn before and not saved: the board goes on where it was."

    @property
    def state(self) -> State:
        """The present state."""
        return self._history.present

    @property
    def name(self) -> str:
        """Short identifier of the scene, as `load_scene` has it."""
        stem = self.path.stem
        return stem if stem != "scene" else self.path.resolve().parent.name

    @property
    def plan(self) -> Plan:
        """What there is to draw."""
        return plan_of(self.state)

    @property
    def needs(self) -> tuple[Need, ...]:
        """What is missing for an answer."""
        return needs_of(self.state)

    @property
    def scene(self) -> Scene | None:
        """The scene; None while something is missing."""
        return scene_of(self.state, self.name)

    @property
    def undoes(self) -> str:
        """What `undo` would take back, in words; empty where there is nothing."""
        return self.state.said or "a step" if self._history.past else ""

    @property
    def redoes(self) -> str:
        """What `redo` would do again, in words; empty where there is nothing."""
        return self._history.future[-1].said or "a step" if self._history.future else ""

    @property
    def unsaved(self) -> bool:
        """Whether the scene file does not have the present text."""
        return self._saved != self.state.text and (bool(self._history.past) or self._begun)

    def do(self, name: str, values: Mapping[str, Any]) -> bool:
        """Do an action, and keep it.

        Args:
            name: name of the action, in `ACTIONS`.
            values: arguments of the action, as JSON has them.

        Returns:
            Whether something has changed.

        Raises:
            SceneError: it is refused; nothing has changed.
            OSError: it cannot be kept; nothing has changed.
        """
        return self._go(perform(self.state, name, values))

    def change(self, how: Callable[[State], State]) -> bool:
        """Go on to a state that a function makes of the present one, and keep it, as `do` does."""
        return self._go(how(self.state))

    def edit(self, changes: Mapping[str, object]) -> Scene:
        """Write values at keys of the scene file, as `Scene.change` takes them, and keep it.

        Args:
            changes: new values by key.

        Returns:
            The changed scene.

        Raises:
            SceneError: the scene would be wrong or incomplete; nothing has changed.
            OSError: it cannot be kept; nothing has changed.
        """
        state = self.state
        text = edited(state.text.removeprefix("\ufeff"), changes, str(self.path))
        scene = parse_scene(text, self.name)
        bom = "\ufeff" if state.text.startswith("\ufeff") else ""
        self._go(
            replace(state, text=bom + text, said=f"{next(iter(changes), 'nothing')} by a slider")
        )
        return scene

    def restore(self, scene: Scene) -> None:
        """Go back to the text of a scene that was drawn here, and keep it."""
        self._go(replace(self.state, text=scene.text, said="all sliders back"))

    def undo(self) -> bool:
        """Take the last step back; returns whether there was one."""
        if not self._history.past:
            return False
        if self._journal:
            self._journal.undo()
        self._history.undo()
        return True

    def redo(self) -> bool:
        """Do the step again that was taken back last; returns whether there was one."""
        if not self._history.future:
            return False
        if self._journal:
            self._journal.redo()
        self._history.redo()
        return True

    def save(self) -> Path:
        """Write the scene file, whole.

        Raises:
            OSError: it cannot be written; an existing file is unchanged.
        """
        content = self.state.text.encode()
        write_whole(self.path, content)
        self._saved = self.state.text
        if self._journal and self._begun:
            self._journal.saved(content)
        return self.path

    def save_as(self, name: str, over: bool = False) -> Path:
        """Write the scene file under another name in the same folder; the board stays with its own.

        Args:
            name: name of the file; a suffix .toml is added where it has none.
            over: whether a file of that name may be replaced.

        Raises:
            SceneError: the name is no file name, or is taken.
            OSError: the file cannot be written.
        """
        path = named(self.path.parent, name, over)
        return write_whole(path, self.state.text.encode())

    def close(self) -> None:
        """Let the journal go."""
        if self._journal:
            self._journal.close()

    def _go(self, state: State) -> bool:
        if state == self.state:
            return False
        if self._journal and not self._begun:
            self._begin(self._journal)
        if self._journal:
            self._journal.step(self.state, state)
        self._history.add(state)
        return True

    def _begin(self, journal: Journal) -> None:
        """Begin the journal; a folder that nobody may write to has none."""
        try:
            journal.begin(self.state)
            if self._saved is not None:
                journal.saved(self._saved.encode())
            self._begun = True
        except InUse:
            raise
        except OSError as error:
            self._journal = None
            self.note = f"No journal is kept here, so save the scene under another name: {error}"


def untitled(folder: Path) -> Path:
    """Where a scene is drawn that has no file yet: the first name that no scene file has.

    Args:
        folder: folder to draw in.
    """
    number, path = 1, folder / f"{UNTITLED}.toml"
    while path.exists():
        number += 1
        path = folder / f"{UNTITLED}-{number}.toml"
    return path


def _text_of(path: Path) -> str:
    """The text of a scene file with every byte that it has.

    Raises:
        SceneError: it is no TOML in UTF-8.
    """
    content = path.read_bytes()[: _FILE_BYTES + 1]
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        raise SceneError(
            str(path), [Problem("", "", "not UTF-8 text; save the file as UTF-8")]
        ) from None
    toml_of(text.removeprefix("\ufeff"), str(path))
    return text


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
