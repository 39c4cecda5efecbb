"""The drawing board with a session without inference: serves a scene file, or an empty board."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path

from retrodict.explore.board.board import Board
from retrodict.explore.explorer import Explorer, Setting
from retrodict.explore.server import address, listen, serve
from tests.explore.made_up import MadeUpSession


def main() -> None:
    """Serve the board of the scene file that the first argument names."""
    board = Board(Path(sys.argv[1]))
    listening = listen(0)
    print(address(listening), flush=True)
    setting = Setting(("planar+spin",), board.path.parent / "out", board.path)
    explorer = Explorer(
        board.scene,
        lambda of, by, _: MadeUpSession(of, by),
        edit=board.edit,
        reset=board.restore,
    )
    with suppress(KeyboardInterrupt):
        serve(explorer, setting, listening, board=board)


if __name__ == "__main__":
    main()
