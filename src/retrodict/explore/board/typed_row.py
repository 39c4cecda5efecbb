"""A quantity that is typed on the board, with what holds where nothing is typed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui.element import Element

from retrodict.explore.board import rows
from retrodict.explore.board.plan import Car, Plan
from retrodict.explore.board.rows import Row
from retrodict.scene.load import value_at


class TypedRow(Element, component="typed_row.js"):
    """A quantity that is typed, with what holds where nothing is.

    Args:
        row: quantity.
        key: dotted key, with the vehicle's letter or the surface's name.
        write: function that writes a text at a key and returns why that is refused.
        plan: function that returns the plan of the present state.
        shown: function that finds its present text; None for what the file says at the key.
    """

    def __init__(
        self,
        row: Row,
        key: str,
        write: Callable[[str, str], str],
        plan: Callable[[], Plan],
        shown: Callable[[Plan], str] | None = None,
    ) -> None:
        super().__init__()
        self.row, self.key = row, key
        self._write, self._plan, self._shown = write, plan, shown
        self._said = ""
        self._done = 0  # number of the browser's last text that was written or refused
        self._refused: dict[str, str] | None = None
        self._props["data-key"] = key
        self._props["label"] = row.label
        self._props["example"] = row.example
        self._show()
        self.on("typed", lambda e: self._typed(e.args))

    def show(self, plan: Plan) -> None:
        """Show the present text, which replaces none that the server does not know yet.

        Args:
            plan: plan of the present state.
        """
        text = self._text_of(plan)
        if text != self._said:
            # what was refused stays until the file says something else
            self._said, self._refused = text, None
        self._show()
        short, whole = ("", "") if self._shown else rows.note(plan, self.row, self.key)
        for name, words in (("note", short), ("whole", whole)):
            if self._props.get(name) != words:
                self._props[name] = words

    def _typed(self, args: Any) -> None:
        given = args if isinstance(args, dict) else {}
        text, number = given.get("text"), given.get("number")
        if not isinstance(text, str) or not isinstance(number, int):
            return
        why = self._write(self.key, text) if text != self._text_of(self._plan()).strip() else ""
        # what the file says now is no news to whoever typed it, however late it is shown
        self._said = self._text_of(self._plan())
        self._done = number
        self._refused = {"text": text, "why": why} if why else None
        self._show()

    def _show(self) -> None:
        state = {"text": self._said, "done": self._done, "refused": self._refused}
        if self._props.get("state") != state:
            self._props["state"] = state

    def _text_of(self, plan: Plan) -> str:
        return self._shown(plan) if self._shown else rows.said(plan, self.key)


def coordinate(letter: str, at: str, axis: str, plan: Plan) -> str:
    """The text of a vehicle's coordinate, at the impact or at rest; empty where it has none.

    Args:
        letter: letter of the vehicle.
        at: "impact" or "rest".
        axis: "x" or "y".
        plan: plan of the present state.
    """
    car: Car | None = plan.cars.get(letter)
    i = "xy".index(axis)
    if car is None:
        return ""
    if at == "rest":
        pair = value_at(plan.document, f"{car.key}.rest.position")
        return rows.said(plan, f"{car.key}.rest.position[{i}]") if isinstance(pair, list) else ""
    return "" if car.at is None else f"{car.at[i]:.3f} m"
