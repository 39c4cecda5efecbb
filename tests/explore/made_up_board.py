"""The drawing board with a session without inference: serves a scene file, or an empty board."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from retrodict.explore.board.board import Board
from retrodict.explore.explorer import Explorer, Setting
from retrodict.explore.server import address, listen, serve
from retrodict.scene.quantities import Units
from tests.explore.made_up import MadeUpAnswer, MadeUpSession


class AnswerOnTheBoard(MadeUpAnswer):
    """The made-up answer with what questions and narrowing read: A's speed, by which B's is known."""

    @property
    def draws(self) -> dict[str, np.ndarray]:
        found, rng = super().draws, np.random.default_rng(1)
        speed_a = found["speed_b"] + rng.normal(0.0, 0.5, 1000)
        # a session keeps conditions and predictions too, whose names have a slash
        others = {"condition/close_in": np.zeros(1000), "predicted/rest_x_a": np.ones(1000)}
        return found | {"speed_a": speed_a, "direction_b": rng.normal(-0.4, 0.03, 1000)} | others

    def summary(self, units: Units = "si") -> pd.DataFrame:
        return MadeUpAnswer(self.scene, self.model).summary(units)


class SessionOnTheBoard(MadeUpSession):
    """Answers at once."""

    @property
    def answer(self) -> MadeUpAnswer:
        return AnswerOnTheBoard(self.scene, self.model)


class LateBoard(Board):
    """A board on a busy machine: every action takes its time."""

    late = 0.0  # s

    def do(self, name: str, values: Mapping[str, Any]) -> bool:
        time.sleep(self.late)
        return super().do(name, values)


def main() -> None:
    """Serve the board of a scene file; a second argument says how late each action is, s."""
    board = LateBoard(Path(sys.argv[1]))
    LateBoard.late = float(sys.argv[2]) if len(sys.argv) > 2 else 0.0
    listening = listen(0)
    print(address(listening), flush=True)
    setting = Setting(("planar+spin",), board.path.parent / "out", board.path)
    explorer = Explorer(
        board.scene,
        lambda of, by, _: SessionOnTheBoard(of, "planar+spin"),
        edit=board.edit,
        reset=board.restore,
    )
    with suppress(KeyboardInterrupt):
        serve(explorer, setting, listening, board=board)


if __name__ == "__main__":
    main()
