"""A typed row without a browser: what it says of texts that arrive while it is not yet shown."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from nicegui import Client
from nicegui.page import page

from retrodict.explore.board import rows
from retrodict.explore.board.board import Board
from retrodict.explore.board.typed_row import TypedRow
from retrodict.scene.errors import SceneError
from tests.explore.made_up import BRACH

KEY = "vehicles.A.approach.speed"


class Typing:
    """A row for the speed of A, and the browser's side of it."""

    def __init__(self, board: Board) -> None:
        self.board, self.number = board, 0
        speed = next(row for row in rows.BEFORE if row.of("A") == KEY)
        self.row = TypedRow(speed, KEY, self._write, lambda: board.plan)
        self.row.show(board.plan)

    def _write(self, key: str, text: str) -> str:
        try:
            self.board.do("write", {"key": key, "value": text})
        except SceneError as error:
            return str(error)
        return ""

    def send(self, text: object) -> None:
        self.number += 1
        args = {"text": text, "number": self.number}
        self.row._typed(args)

    def shown(self) -> tuple[str, int, str]:
        """The file's text, the number of the text that was answered last, and the text refused."""
        state = self.row.props["state"]
        refused = state["refused"]
        return state["text"], state["done"], refused["text"] if refused else ""


@pytest.fixture
def typing(tmp_path: Path) -> Iterator[Typing]:
    path = tmp_path / "scene.toml"
    path.write_bytes(BRACH.read_bytes())
    board = Board(path)
    with Client(page("")):
        yield Typing(board)
    board.close()


def test_a_refusal_outlives_what_was_written_before_it_and_is_shown_after_it(
    typing: Typing,
) -> None:
    typing.send("40 ± 2 mph")
    typing.send("40 ± 2 mph and")
    assert typing.shown() == ("40 ± 2 mph", 2, "40 ± 2 mph and")
    typing.row.show(typing.board.plan)  # the first, late
    assert typing.shown() == ("40 ± 2 mph", 2, "40 ± 2 mph and")
    typing.send("41 ± 2 mph")
    assert typing.shown() == ("41 ± 2 mph", 3, "")


def test_a_refusal_goes_when_the_file_says_something_else(typing: Typing) -> None:
    typing.send("fast")
    assert typing.shown() == ("45 ± 2 mph", 1, "fast")
    typing.row.show(typing.board.plan)
    assert typing.shown() == ("45 ± 2 mph", 1, "fast")
    typing.board.do("write", {"key": KEY, "value": "50 ± 2 mph"})
    typing.row.show(typing.board.plan)
    assert typing.shown() == ("50 ± 2 mph", 1, "")


def test_what_no_browser_sends_is_passed_over(typing: Typing) -> None:
    for args in (None, 5, [], {"text": 5, "number": 1}, {"text": "5 mph", "number": "1"}):
        typing.row._typed(args)
    assert typing.shown() == ("45 ± 2 mph", 0, "")


def test_a_refusal_imports_nothing_that_a_thread_imports_meanwhile(tmp_path: Path) -> None:
    # two threads that import xarray, pint and dask at once may see one of them half made
    code = f"""
import sys
from retrodict.explore.board.board import Board
from retrodict.explore.server import load_libraries
from retrodict.scene.errors import SceneError
from pathlib import Path
load_libraries()
import retrodict.explore.beside
loaded = set(sys.modules)
board = Board(Path("new.toml"))
for text in ("40 mph and", "heavy", "40 furlong/fortnight"):
    try:
        board.do("write", {{"key": "{KEY}", "value": text}})
    except SceneError:
        pass
import xarray
later = {{name.partition(".")[0] for name in set(sys.modules) - loaded}}
assert not later & {{"pint", "dask", "xarray", "pandas"}}, later
"""
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path)
