"""A quantity that is typed on the board, with what holds where nothing is typed."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from retrodict.explore.board import rows
from retrodict.explore.board.plan import Car, Plan
from retrodict.explore.board.rows import Row
from retrodict.scene.load import value_at


class TypedRow:
    """A quantity that is typed, with what holds where nothing is.

    Args:
        row: quantity.
        key: dotted key, with the vehicle's letter or the surface's name.
        write: function that writes a text at a key and returns why that is refused.
        shown: function that finds its present text; None for what the file says at the key.
    """

    def __init__(
        self,
        row: Row,
        key: str,
        write: Callable[[str, str], str],
        shown: Callable[[Plan], str] | None = None,
    ) -> None:
        self.row, self.key = row, key
        self._write, self._shown = write, shown
        self._said = ""
        with ui.element("div").classes("typed") as place:
            place.props["data-key"] = key  # it may have brackets
            ui.label(row.label).classes("label")
            self._text = ui.input(placeholder=row.example).props("dense outlined")
            self._text.props["aria-label"] = row.label
            self._text.on("keydown.enter", self._typed).on("blur", self._typed)
            self._note = ui.label("").classes("small")
            self._fault = ui.label("").classes("fault").props("role=alert")

    def show(self, plan: Plan) -> None:
        """Show the present text; what is being typed stays where the file says the same as before."""
        text = self._shown(plan) if self._shown else rows.said(plan, self.key)
        short, whole = ("", "") if self._shown else rows.note(plan, self.row, self.key)
        if text != self._said:
            self._said = text
            if text != self._typed_text():  # else somebody may already type on
                self._text.set_value(text)
            self._fault.set_text("")
        self._note.set_text(short)
        if self._note.props.get("title") != whole:
            self._note.props["title"] = whole

    def _typed(self) -> None:
        text = self._typed_text()
        if text != self._said:
            self._fault.set_text(self._write(self.key, text))

    def _typed_text(self) -> str:
        return str(self._text.value or "").strip()


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
