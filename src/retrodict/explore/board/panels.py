"""The panels beside the plan: what is typed and chosen of vehicles, impact, ground and scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from nicegui import ui

from retrodict.explore.board import rows
from retrodict.explore.board.board import Board
from retrodict.explore.board.contact import proposed
from retrodict.explore.board.files_panel import FilesPanel
from retrodict.explore.board.of_questions import AVOIDABLE, ROWS
from retrodict.explore.board.plan import WHEELS, Plan
from retrodict.explore.board.rows import Row
from retrodict.explore.board.sheet import Sheet
from retrodict.explore.board.typed_row import TypedRow, coordinate
from retrodict.scene.defaults import FRICTION
from retrodict.scene.errors import SceneError
from retrodict.scene.load import value_at
from retrodict.scene.units import LENGTH, QuantityError, read_quantity
from retrodict.scene.vehicle_library import vehicles

_LOOK = "dense outlined options-dense"
_OWN = "own numbers"
_WHEEL_WORDS = {"centre": "centre of gravity"} | {w: w.replace("_", " ") for w in WHEELS}
_OF_THING = {"A": "A", "B": "B", "impact": "Impact", "ground": "Ground"}


class Panels:
    """Panels beside the plan, a tab each.

    Args:
        board: board that is drawn on.
        sheet: plan in the browser.
        do: function that does an action by name and returns why it is refused.
        attempt: function that does anything else to the board and returns why it is refused.
        say: function that shows a line of text.
        fit: function that brings everything into view.
    """

    def __init__(
        self,
        board: Board,
        sheet: Sheet,
        do: Callable[[str, dict[str, Any]], str],
        attempt: Callable[[Callable[[], object]], str],
        say: Callable[[str], object],
        fit: Callable[[], None],
    ) -> None:
        self._board, self._sheet, self._do, self._say = board, sheet, do, say
        self._files = FilesPanel(board, do, attempt, say, fit)
        self._rows: list[TypedRow] = []
        self._classes: dict[str, ui.select] = {}
        self._kinds: dict[str, ui.select] = {}
        self._surfaces: dict[str, bool] = {}  # whether each that has rows has an edge

    def build(self) -> None:
        """Make the elements."""
        names = ("A", "B", "Impact", "Ground", "Photograph", "Evidence", "Scene")
        with ui.tabs().props("dense no-caps align=left") as self._tabs:
            for name in names:
                ui.tab(name)
        with ui.tab_panels(self._tabs, value="A", animated=False, keep_alive=True).classes(
            "panels"
        ):
            for letter in ("A", "B"):
                with ui.tab_panel(letter):
                    self._vehicle(letter)
            with ui.tab_panel("Impact"):
                self._impact()
            with ui.tab_panel("Ground"):
                self._ground()
            with ui.tab_panel("Photograph"):
                self._files.photograph()
            with ui.tab_panel("Evidence"):
                self._files.evidence()
            with ui.tab_panel("Scene"):
                self._scene()

    def choose(self, thing: str) -> None:
        """Open the panel of a thing.

        Args:
            thing: "A", "B", "impact" or "ground"; for anything else the open panel stays.
        """
        if thing in _OF_THING:
            self._tabs.set_value(_OF_THING[thing])

    def show(self, plan: Plan) -> None:
        """Show the present state."""
        self._show_surfaces(plan)
        for row in self._rows:
            row.show(plan)
        self._show_choices(plan)
        self._files.show()

    # panels

    def _typed(self, several: Sequence[Row], name: str) -> None:
        for row in several:
            self._rows.append(TypedRow(row, row.of(name), self._write, self._plan))

    def _plan(self) -> Plan:
        return self._board.plan

    def _write(self, key: str, text: str) -> str:
        several = [each.strip() for each in text.split(",") if each.strip()]
        value = several if key in rows.LISTS else text
        return self._do("write", {"key": key, "value": value})

    def _vehicle(self, letter: str) -> None:
        kinds = [_OWN, *vehicles()]
        self._classes[letter] = ui.select(
            kinds, value=_OWN, label=f"class or model of {letter}", with_input=True,
            on_change=lambda e: self._class(letter, e.value),
        ).props(_LOOK).classes("wide")  # fmt: skip
        self._typed(rows.VEHICLE, letter)
        ui.label("At the impact").classes("part")
        self._pose(letter, "impact")
        self._typed(rows.AT_IMPACT, letter)
        ui.label("Before").classes("part")
        self._typed(rows.BEFORE, letter)
        ui.label("After").classes("part")
        self._pose(letter, "rest")
        self._typed(rows.AFTER, letter)

    def _pose(self, letter: str, at: str) -> None:
        where = "at the impact" if at == "impact" else "at rest"
        for axis in "xy":
            row = Row(f"{letter}.{at}.{axis}", f"{axis} {where}", "3.20 m, or 10' 6\"")
            write = partial(self._placed, letter, at, axis)
            shown = partial(coordinate, letter, at, axis)
            self._rows.append(TypedRow(row, row.key, write, self._plan, shown))

    def _placed(self, letter: str, at: str, axis: str, key: str, text: str) -> str:
        plan = self._board.plan
        car = plan.cars.get(letter)
        if car is None:
            return f"there is no vehicle {letter}"
        file_key = f"vehicles.{letter}.rest.position[{'xy'.index(axis)}]"
        if at == "rest" and car.rest is not None:
            return self._write(file_key, text)
        try:
            value = read_quantity(text, LENGTH, "3.2 m").value
        except QuantityError as error:
            return error.fix
        place = (car.at if at == "impact" else car.rest) or (0.0, 0.0)
        x, y = (value, place[1]) if axis == "x" else (place[0], value)
        return self._do("place", {"vehicle": letter, "at": at, "x": x, "y": y})

    def _class(self, letter: str, kind: str | None) -> None:
        known = _known(self._board.plan, letter)
        if kind is not None and kind != known:
            self._write(f"vehicles.{letter}.class", "" if kind == _OWN else kind)

    def _impact(self) -> None:
        self._struck = ui.select(
            {"vehicle": "vehicle B", "wall": "a wall", "pole": "a pole"}, value="vehicle",
            label="A struck", on_change=lambda e: self._strike(e.value),
        ).props(_LOOK).classes("wide")  # fmt: skip
        self._proposal = ui.button("", on_click=self._propose).props("outline dense no-caps")
        self._proposal.classes("proposal")
        self._typed(rows.IMPACT, "")

    def _strike(self, kind: str) -> None:
        if kind != (self._board.plan.barrier or "vehicle"):
            self._do("barrier", {"kind": kind})

    def _propose(self) -> None:
        found = proposed(self._board.plan)
        if found:
            angle, sd = round(math.degrees(found.angle), 1), round(math.degrees(found.sd), 1)
            self._do("line", {"angle": angle, "sd": sd})

    def _ground(self) -> None:
        self._of_ground = ui.element("div")
        with ui.element("div"):
            self._typed(rows.SLOPE, "")
        ui.label("Marks of the vehicles are of").classes("part")
        ui.select(
            _WHEEL_WORDS, value="centre",
            on_change=lambda e: self._sheet.run_method("markPart", e.value),
        ).props(_LOOK).classes("wide")  # fmt: skip

    def _scene(self) -> None:
        self._typed(rows.SCENE, "")
        ui.label("Could it have stopped?").classes("part")
        self._driver = ui.select(["A", "B"], value="A", label="driver of").props(_LOOK)
        self._asked: dict[str, ui.input] = {}
        for name, (label, example) in ROWS.items():
            with ui.element("div").classes("typed"):
                ui.label(label).classes("label")
                self._asked[name] = ui.input(placeholder=example).props("dense outlined")
                self._asked[name].props["aria-label"] = label
        with ui.row().classes("save"):
            ui.button("Ask", on_click=self._ask).props("no-caps outline dense")
            self._not_asked = ui.button(
                "Ask no longer", on_click=lambda: self._do("ask_avoidable", {})
            ).props("no-caps flat dense")
        self._refused = ui.label("").classes("fault").props("role=alert")
        self._said_of_avoidable: object = None
        with ui.row().classes("save"):
            self._name = ui.input("save a copy as").props("dense outlined")
            self._replace = ui.checkbox("replace it")
            ui.button("Save a copy", on_click=self._copied).props("no-caps outline")

    def _ask(self) -> None:
        texts = {name: str(each.value or "") for name, each in self._asked.items()}
        self._refused.set_text(self._do("ask_avoidable", {"vehicle": self._driver.value, **texts}))

    def _copied(self) -> None:
        try:
            path = self._board.save_as(str(self._name.value or ""), bool(self._replace.value))
            self._say(f"Saved: {path}")
        except (SceneError, OSError) as error:
            self._say(str(error))

    def _surface(self, name: str, kind: str) -> None:
        key = f"surfaces.{name}.kind"
        if kind and kind != value_at(self._board.plan.document, key):
            self._write(key, kind)

    # showing

    def _show_surfaces(self, plan: Plan) -> None:
        """Rows for every surface, made anew where there are others."""
        known = plan.document.get("surfaces")
        tables = known if isinstance(known, dict) else {}
        tables = {name: each for name, each in tables.items() if isinstance(each, dict)}
        names = {name: "edge" in each for name, each in tables.items()}
        if all("edge" in each or "outline" in each for each in tables.values()):
            names["road"] = False  # everywhere else
        if names == self._surfaces:
            return
        self._surfaces = names
        self._rows = [row for row in self._rows if not row.key.startswith("surfaces.")]
        self._of_ground.clear()
        self._kinds = {}
        with self._of_ground:
            for name in names:
                ui.label(name).classes("part")
                self._kinds[name] = ui.select(
                    ["", *FRICTION], value="", label=f"kind of the {name}",
                    on_change=lambda e, name=name: self._surface(name, e.value),
                ).props(_LOOK).classes("wide")  # fmt: skip
                self._typed(rows.GROUND, name)
                if names[name]:
                    self._typed(rows.EDGE, name)

    def _show_choices(self, plan: Plan) -> None:
        """Bring what is chosen from lists to the present state."""
        for letter, choice in self._classes.items():
            known = _known(plan, letter)
            if choice.value != known:
                choice.set_value(known)
            choice.set_enabled(letter in plan.cars)
        if self._struck.value != (plan.barrier or "vehicle"):
            self._struck.set_value(plan.barrier or "vehicle")
        for name, kind in self._kinds.items():
            said = value_at(plan.document, f"surfaces.{name}.kind") or ""
            if kind.value != said and said in ("", *FRICTION):
                kind.set_value(said)
        found = proposed(plan) if plan.point is not None else None
        self._proposal.set_enabled(found is not None)
        self._proposal.set_text(
            f"Take the proposal: {math.degrees(found.angle):.1f} ± {math.degrees(found.sd):.0f} deg, "
            f"{found.why}"
            if found
            else "A contact line is proposed once outlines and the impact point are placed"
        )
        asked = value_at(plan.document, f"{AVOIDABLE}[0]")
        self._not_asked.set_visibility(asked is not None)
        if asked != self._said_of_avoidable:
            self._said_of_avoidable = asked
            table = asked if isinstance(asked, dict) else {}
            if table.get("vehicle") in ("A", "B"):
                self._driver.set_value(table["vehicle"])
            for name, each in self._asked.items():
                text = rows.in_words(table.get(name))
                if text != each.value:
                    each.set_value(text)


def _known(plan: Plan, letter: str) -> str:
    """The class of a vehicle as the list has it; "own numbers" where it has none of these."""
    said = str(value_at(plan.document, f"vehicles.{letter}.class")).casefold()
    return next((kind for kind in vehicles() if kind.casefold() == said), _OWN)
