"""The board's journal: every step in a file beside the scene, so that a killed server loses none.

Each line is a step as JSON with its digest. A line that was not written to its end is left out when the
file is read, which makes each step all or nothing. A line holds what a step changed of the text, so that
its length follows the change and not the scene.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from retrodict.explore.board.state import State, state_from

SUFFIX = ".board.jsonl"
_FORMAT = 1
_DIGEST = 12  # characters of a line's digest


class InUse(OSError):
    """Another process draws on this board."""


class Journal:
    """A file of steps, which is made with the first of them.

    Args:
        path: path of the file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: int | None = None

    def begin(self, state: State) -> None:
        """Begin the file anew with a state.

        Raises:
            InUse: another process has the file.
            OSError: it cannot be written.
        """
        self._open()
        assert self._file is not None
        os.ftruncate(self._file, 0)
        self._append({"format": _FORMAT, "text": state.text, **state.rest()})

    def step(self, before: State, after: State) -> None:
        """Add a step from one state to another."""
        self._append({"do": difference(before.text, after.text), **after.rest(before)})

    def undo(self) -> None:
        """Add that a step was taken back."""
        self._append({"undo": 1})

    def redo(self) -> None:
        """Add that a step was done again."""
        self._append({"redo": 1})

    def saved(self, content: bytes) -> None:
        """Add that the scene file was written with this content."""
        self._append({"saved": hashlib.sha256(content).hexdigest()})

    def close(self) -> None:
        """Let the file go."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def resume(self) -> History | None:
        """The history that the file holds; None where there is no file, or none that can be used.

        A file that cannot be used is put aside, under its name with `.damaged`.

        Raises:
            InUse: another process has the file.
            OSError: it cannot be read.
        """
        if not self.path.is_file():
            return None
        self._open()
        assert self._file is not None
        content = self.path.read_bytes()
        steps, good = [], 0
        for line, end in _lines(content):
            steps.append(line)
            good = end
        try:
            history = _replayed(steps)
        except (ValueError, TypeError, KeyError, IndexError, AttributeError):
            history = None
        if history is None or good < content.rfind(b"\n") + 1:  # more than a torn last line
            with suppress(OSError):
                self.path.with_name(f"{self.path.name}.damaged").write_bytes(content)
        if history is None:
            self.close()
            return None
        os.ftruncate(self._file, good)
        return history

    def _open(self) -> None:
        if self._file is not None:
            return
        file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        try:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(file)
            raise InUse(
                f"{self.path}: another retrodict explore draws on this scene; go on there, or end it"
            ) from None
        except (ImportError, OSError):  # a system without such locks
            pass
        self._file = file

    def _append(self, step: Mapping[str, Any]) -> None:
        assert self._file is not None, "begun or resumed before"
        said = json.dumps(step, ensure_ascii=False, allow_nan=False)
        line = f"{_digest(said)} {said}\n".encode("utf-8", "surrogatepass")
        end = os.lseek(self._file, 0, os.SEEK_END)
        try:
            while line:
                line = line[os.write(self._file, line) :]
            os.fsync(self._file)
        except OSError:
            os.ftruncate(self._file, end)  # a full disk: the step before is still whole
            raise


class History:
    """States with what came before and after: taken back and done again without end.

    Args:
        first: state at the beginning.
    """

    def __init__(self, first: State) -> None:
        self.past: list[State] = []
        self.present = first
        self.future: list[State] = []  # the next one last
        self.saved = ""  # digest of the file as it was written last

    def add(self, state: State) -> None:
        """Go on to a new state; what was taken back is forgotten."""
        self.past.append(self.present)
        self.present = state
        self.future.clear()

    def undo(self) -> None:
        """Take the last step back.

        Raises:
            IndexError: there is none.
        """
        before = self.past.pop()
        self.future.append(self.present)
        self.present = before

    def redo(self) -> None:
        """Do the step again that was taken back last.

        Raises:
            IndexError: there is none.
        """
        after = self.future.pop()
        self.past.append(self.present)
        self.present = after


def difference(before: str, after: str) -> list[Any]:
    """What turns a text into another: begin, length of what goes, what comes in its place."""
    begin = _alike(before, after)
    one, other = before[begin:], after[begin:]
    same = _alike(one[::-1], other[::-1])
    return [begin, len(one) - same, other[: len(other) - same]]


def _alike(one: str, other: str) -> int:
    """How many characters two texts have in common from their beginning."""
    both = zip(one, other, strict=False)
    return next((i for i, (a, b) in enumerate(both) if a != b), min(len(one), len(other)))


def applied(text: str, change: list[Any]) -> str:
    """A text with what `difference` found.

    Raises:
        ValueError, TypeError: the change does not belong to the text.
    """
    begin, length, new = change
    if not (0 <= begin <= begin + length <= len(text)) or not isinstance(new, str):
        raise ValueError("a change of another text")
    return text[:begin] + new + text[begin + length :]


def _replayed(steps: list[dict[str, Any]]) -> History | None:
    if not steps or steps[0].get("format") != _FORMAT:
        return None
    history = History(state_from(steps[0]["text"], steps[0]))
    for step in steps[1:]:
        if "do" in step:
            known = history.present
            history.add(state_from(applied(known.text, step["do"]), step, known))
        elif "undo" in step:
            history.undo()
        elif "redo" in step:
            history.redo()
        else:
            history.saved = step["saved"]
    return history


def _lines(content: bytes) -> Iterator[tuple[dict[str, Any], int]]:
    """Steps of a file and where each ends, up to the first that is not whole."""
    at = 0
    while (end := content.find(b"\n", at)) >= 0:
        digest, _, said = content[at:end].decode("utf-8", "replace").partition(" ")
        if digest != _digest(said):
            return
        step = json.loads(said)
        yield step, end + 1
        at = end + 1


def _digest(said: str) -> str:
    return hashlib.sha256(said.encode("utf-8", "surrogatepass")).hexdigest()[:_DIGEST]
