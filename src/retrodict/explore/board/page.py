"""The page of the drawing board: the plan, what is missing, what is known, and the answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from nicegui import events, ui
from nicegui.element import Element

from retrodict.explore import answers
from retrodict.explore.answers import Answer
from retrodict.explore.board import rows
from retrodict.explore.board.arguments import refused
from retrodict.explore.board.backdrop import LARGEST, by_world_file, kept
from retrodict.explore.board.board import Board
from retrodict.explore.board.contact import proposed
from retrodict.explore.board.drawing import drawing
from retrodict.explore.board.evidence import taken
from retrodict.explore.board.needs import thing_of
from retrodict.explore.board.plan import WHEELS, Car, Plan
from retrodict.explore.board.rows import Row
from retrodict.explore.board.state import State
from retrodict.explore.explorer import Explorer, Setting
from retrodict.explore.templates import template, text_of
from retrodict.scene.defaults import FRICTION
from retrodict.scene.errors import SceneError
from retrodict.scene.load import value_at
from retrodict.scene.plausibility import plausibility_warnings
from retrodict.scene.quantities import Units
from retrodict.scene.units import LENGTH, QuantityError, read_quantity
from retrodict.scene.vehicle_library import vehicles

_BEAT = 0.25  # s between looks at how far the work is
_PATHS = 21  # motions that are drawn
_PACKAGE = "retrodict.explore.board"
_UNITS = {"si": "metres, m/s", "us": "feet, mph"}
_LOOK = "dense outlined options-dense"
_OWN = "own numbers"
_WHEEL_WORDS = {"centre": "centre of gravity"} | {w: w.replace("_", " ") for w in WHEELS}


class Sheet(Element, component="board.js"):
    """The plan to scale, with its tools.

    Args:
        first: drawing at the beginning.
        survey: surveyed points.
        units: units of grid and ruler.
    """

    def __init__(self, first: dict[str, Any], survey: Sequence[Any], units: Units) -> None:
        super().__init__()
        self._props["first"] = first
        self._props["survey"] = [list(point) for point in survey]
        self._props["units"] = units


class BoardPage:
    """The page on which a browser draws a scene.

    Args:
        board: board that is drawn on.
        explorer: explorer that answers its scene.
        setting: settings of the page.
    """

    def __init__(self, board: Board, explorer: Explorer, setting: Setting) -> None:
        self.board, self.explorer, self.setting = board, explorer, setting
        self.units: Units = setting.units
        self._begun = False
        self._count = 0
        self._rows: list[TypedRow] = []
        self._paths: list[dict[str, Any]] = []  # of the result that was confirmed last
        self._paths_of: State | None = None
        self._points = board.state.points
        self._files: dict[bool, tuple[str, bytes]] = {}  # a map, and a file that it is for
        self._classes: dict[str, ui.select] = {}
        self._kinds: dict[str, ui.select] = {}
        self._surfaces: dict[str, bool] = {}  # whether each that has rows has an edge

    def build(self) -> None:
        """Make the page's elements, and begin to show."""
        ui.add_css(text_of("page.css"))
        ui.add_css(text_of("board.css", _PACKAGE))
        with ui.element("header").classes("top"):
            self._title = ui.label("").classes("title")
            self._undo = ui.button("Undo", on_click=self._undone).props("flat dense no-caps")
            self._redo = ui.button("Redo", on_click=self._redone).props("flat dense no-caps")
            self._save = ui.button("Save the scene file", on_click=self._saved)
            self._save.props("dense no-caps")
            ui.select(
                ["auto", *self.setting.models], value=self.explorer.model, label="model",
                on_change=lambda e: self.explorer.choose(e.value),
            ).props(_LOOK).classes("model")  # fmt: skip
            ui.select(
                _UNITS, value=self.units, label="units", on_change=lambda e: self._use(e.value)
            ).props(_LOOK).classes("units")
        with ui.element("div").classes("drawing-page"):
            with ui.element("section").classes("plan"):
                self.sheet = Sheet(self._drawn(), self.board.state.points, self.units)
                self.sheet.on("act", lambda e: self._act(e.args))
                self.sheet.on("pick", lambda e: self._picked(e.args))
            with ui.element("section").classes("side"):
                self._note = ui.label(self.board.note).classes("small")
                self._kept = ui.label("").classes("small").props("aria-live=polite")
                with ui.element("div").classes("state").props("aria-live=polite"):
                    self._needs = ui.element("div").classes("needs")
                    self._progress = ui.linear_progress(value=0, show_value=False, size="3px")
                    self._progress.props("indeterminate instant-feedback").set_visibility(False)
                    self._answer = ui.html("", sanitize=False).classes("answer-box")
                    self._doing = ui.label("").classes("doing")
                    self._warned = ui.element("div").classes("warnings")
                self._panels()
                self._actions()
        with ui.dialog().props("persistent") as self._elsewhere, ui.card():
            ui.label("This scene was opened on another page, which goes on with it.")
            ui.button("Go on here", on_click=lambda: ui.navigate.reload())
        self._refresh()
        ui.timer(_BEAT, self._tick)
        client = ui.context.client
        client.on_connect(self._begin)
        client.on_delete(lambda: self.explorer.leave(self))

    # what the explorer calls

    def working(self, busy: bool) -> None:
        """Say whether an answer is being computed."""
        self._progress.set_visibility(busy)

    def answered(self, answer: Answer) -> None:
        """Show an answer."""
        self._count += 1
        self._answer.set_content(answers.html(answer, self.units, self._count))

    def failed(self, why: str) -> None:
        """Say why there is no answer."""
        self._answer.set_content(template("failed.html.j2").render(why=why))

    def superseded(self) -> None:
        """Say that another page has taken over."""
        self._elsewhere.open()

    # what the user does

    def _act(self, args: Any) -> None:
        name, values = args.get("name"), args.get("values")
        plain = {"undo": self._undone, "redo": self._redone, "save": self._saved}
        if name in plain:
            plain[name]()
        elif isinstance(name, str) and isinstance(values, dict):
            self._do(name, values)

    def _do(self, name: str, values: dict[str, Any]) -> str:
        """Do an action; returns why it was refused, empty where it was not."""
        return self._try(lambda: self.board.do(name, values))

    def _try(self, what: Callable[[], object]) -> str:
        if not self.explorer.shown_in(self):
            return ""
        try:
            what()
        except SceneError as error:
            why = "; ".join(str(problem) for problem in error.problems)
        except OSError as error:
            why = f"not kept: {error}"
        else:
            self._refresh()
            return ""
        self.sheet.run_method("refuse", why)
        self.sheet.run_method("show", self._drawn())
        return why

    def _undone(self) -> None:
        self._try(self.board.undo)

    def _redone(self) -> None:
        self._try(self.board.redo)

    def _saved(self) -> None:
        why = self._try(self.board.save)
        self._kept.set_text(why or f"Saved: {self.board.path}")

    def _copied(self) -> None:
        try:
            path = self.board.save_as(str(self._name.value or ""), bool(self._replace.value))
            self._kept.set_text(f"Saved: {path}")
        except (SceneError, OSError) as error:
            self._kept.set_text(str(error))

    def _use(self, units: Units) -> None:
        self.units = units
        self.sheet.run_method("measure", units)
        if self.explorer.answer:
            self.answered(self.explorer.answer)

    def _picked(self, args: Any) -> None:
        thing = args.get("thing") if isinstance(args, dict) else None
        names = {"A": "A", "B": "B", "impact": "Impact", "ground": "Ground"}
        if thing in names:
            self._tabs.set_value(names[thing])

    def _tick(self) -> None:
        self._doing.set_text(self.explorer.doing)

    def _begin(self) -> None:
        if self._begun:
            return
        self._begun = True
        self.explorer.show_in(self)
        self._refresh()

    # showing

    def _drawn(self) -> dict[str, Any]:
        return drawing(self.board.state, self.board.plan)

    def _refresh(self) -> None:
        """Show the present state everywhere."""
        board, state = self.board, self.board.state
        plan, scene, needs = board.plan, board.scene, board.needs
        drawn = self._drawn()
        warned = [] if scene is None else list(plausibility_warnings(scene))
        drawn["paths"] = self._paths if state == self._paths_of else []
        drawn["warnings"] = [{"thing": thing_of(line), "words": line} for line in warned]
        if self._begun:  # before, it has the first drawing
            self.sheet.run_method("show", drawn)
        self._note.set_text(board.note)
        if state.points != self._points:
            self._points = state.points
            self.sheet.run_method("surveyed", [list(point) for point in state.points])
        title = value_at(plan.document, "title")
        self._title.set_text(
            f"{title if isinstance(title, str) else 'Untitled'} · {board.path.name}"
            f"{' (not saved)' if board.unsaved else ''}"
        )
        for button, word, what in (
            (self._undo, "Undo", board.undoes),
            (self._redo, "Redo", board.redoes),
        ):
            button.set_enabled(bool(what))
            button.props["title"] = f"{word}: {what}" if what else word
        self._needs.clear()
        with self._needs:
            for need in needs:
                kind = "need wrong" if need.wrong else "need"
                ui.label(need.words).classes(kind).props(f"data-need={need.thing}")
        self._needs.set_visibility(bool(needs))
        self._answer.set_visibility(not needs)
        self._warned.clear()
        with self._warned:
            for line in warned:
                ui.label(line).classes("warning").props(f"data-warning={thing_of(line)}")
        self._confirm.set_enabled(scene is not None)
        self._sliders.set_visibility(scene is not None)
        self._show_surfaces(plan)
        for row in self._rows:
            row.show(plan)
        self._show_choices(plan)
        if self._begun:
            self.explorer.follow(scene)

    # parts of the page

    def _panels(self) -> None:
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
                self._photo()
            with ui.tab_panel("Evidence"):
                self._evidence()
            with ui.tab_panel("Scene"):
                self._typed(rows.SCENE, "")
                with ui.row().classes("save"):
                    self._name = ui.input("save a copy as").props("dense outlined")
                    self._replace = ui.checkbox("replace it")
                    ui.button("Save a copy", on_click=self._copied).props("no-caps outline")

    def _typed(self, several: Sequence[Row], name: str) -> None:
        for row in several:
            self._rows.append(TypedRow(row, row.of(name), self._write))

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
            self._rows.append(TypedRow(row, row.key, write, partial(_coordinate, letter, at, axis)))

    def _placed(self, letter: str, at: str, axis: str, key: str, text: str) -> str:
        plan = self.board.plan
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

    def _class(self, letter: str, kind: str) -> None:
        said = value_at(self.board.plan.document, f"vehicles.{letter}.class")
        new = "" if kind == _OWN or kind is None else kind
        if new != (said or ""):
            self._write(f"vehicles.{letter}.class", new)

    def _impact(self) -> None:
        self._struck = ui.select(
            {"vehicle": "vehicle B", "wall": "a wall", "pole": "a pole"}, value="vehicle",
            label="A struck", on_change=lambda e: self._strike(e.value),
        ).props(_LOOK).classes("wide")  # fmt: skip
        self._proposal = ui.button("", on_click=self._propose).props("outline dense no-caps")
        self._proposal.classes("proposal")
        self._typed(rows.IMPACT, "")

    def _strike(self, kind: str) -> None:
        if kind != (self.board.plan.barrier or "vehicle"):
            self._do("barrier", {"kind": kind})

    def _propose(self) -> None:
        found = proposed(self.board.plan)
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
            on_change=lambda e: self.sheet.run_method("markPart", e.value),
        ).props(_LOOK).classes("wide")  # fmt: skip

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

    def _surface(self, name: str, kind: str) -> None:
        key = f"surfaces.{name}.kind"
        if kind and kind != value_at(self.board.plan.document, key):
            self._write(key, kind)

    def _photo(self) -> None:
        ui.label(
            "A photograph or drone image (PNG or JPEG), with its world file where it has one. Then "
            "set its scale by two points (S), north (U) and the origin (I)."
        ).classes("small")
        ui.upload(
            label="photograph", multiple=True, auto_upload=True, max_file_size=LARGEST,
            on_upload=self._uploaded,
            on_rejected=lambda: self._kept.set_text("The photograph is too large."),
        ).props("flat bordered accept=.png,.jpg,.jpeg,.pgw,.jgw,.wld").classes("wide")  # fmt: skip
        self._ground_note = ui.label("").classes("small")
        ui.button("Take the photograph away", on_click=lambda: self._do("no_backdrop", {})).props(
            "flat dense no-caps"
        )

    def _evidence(self) -> None:
        ui.label(
            "Survey points (CSV), a plan (DXF) or a recorder's table (CSV), and the map (TOML) that "
            "says how to read it. Points are shown, and clicks near one take it."
        ).classes("small")
        ui.upload(
            label="file and map", multiple=True, auto_upload=True, on_upload=self._brought
        ).props("flat bordered accept=.csv,.dxf,.toml").classes("wide")

    async def _brought(self, event: events.UploadEventArguments) -> None:
        name = event.file.name
        self._files[name.lower().endswith(".toml")] = (name, await event.file.read())
        if len(self._files) < 2:
            self._kept.set_text(f"{name}: now its {'file' if True in self._files else 'map'}")
            return
        file, of_map = self._files.pop(False), self._files.pop(True)
        why = self._try(lambda: self.board.change(lambda state: taken(state, *file, *of_map)))
        self._kept.set_text(why or f"Taken from {file[0]}")
        self.sheet.run_method("fit")

    async def _uploaded(self, event: events.UploadEventArguments) -> None:
        content, name = await event.file.read(), event.file.name
        if name.lower().endswith((".pgw", ".jgw", ".wld")):
            why = self._try(lambda: self.board.change(partial(_placed_by, content)))
        else:
            folder, stem = self.board.path.parent, self.board.path.stem

            def put(state: State) -> State:
                return replace(state, backdrop=kept(content, folder, stem), said="a photograph")

            why = self._try(lambda: self.board.change(put))
        self._kept.set_text(why)
        self.sheet.run_method("fit")

    def _show_choices(self, plan: Plan) -> None:
        """Bring what is chosen from lists to the present state."""
        for letter, choice in self._classes.items():
            said = value_at(plan.document, f"vehicles.{letter}.class")
            known = next((k for k in vehicles() if k.casefold() == str(said).casefold()), _OWN)
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
        self._proposal.set_visibility(found is not None)
        if found:
            self._proposal.set_text(
                f"Take the proposal: {math.degrees(found.angle):.1f} ± {math.degrees(found.sd):.0f} "
                f"deg, {found.why}"
            )
        backdrop = self.board.state.backdrop
        self._ground_note.set_text(
            ""
            if backdrop is None
            else f"{backdrop.file}, {1 / backdrop.metres:.1f} pixels a metre"
            f"{'' if backdrop.scaled else ': a guess, set the scale'}; SHA-256 {backdrop.sha256}"
        )

    def _actions(self) -> None:
        with ui.element("div").classes("actions-box"):
            self._confirm = ui.button(
                "Confirm by NUTS and write the report", on_click=self._confirmed
            ).props("no-caps outline")
            self._archive = ui.button("Archive", on_click=self._archived).props("no-caps outline")
            self._archive.set_enabled(False)
            self._sliders = ui.link("Sliders, marginals and joint", "/sliders").classes("small")
            self._written = ui.html("", sanitize=False).classes("small")

    async def _confirmed(self) -> None:
        asked = self.board.state
        self._confirm.disable()
        self._written.set_content("")
        try:
            path = await self.explorer.confirm(self.setting.out, self.units)
            said = template("written.html.j2").render(path=str(path), why="")
            self._paths, self._paths_of = _paths(self.explorer.result), asked
            self._refresh()
            self._archive.set_enabled(True)
        except Exception as error:  # any is shown beside the button
            said = template("written.html.j2").render(path="", why=str(error))
        self._written.set_content(said)
        self._confirm.set_enabled(self.board.scene is not None)

    async def _archived(self) -> None:
        self._archive.disable()
        try:
            path = await self.explorer.archive(self.setting.out)
            self._kept.set_text(f"Archived: {path}")
        except Exception as error:  # any is shown
            self._kept.set_text(f"Not archived: {error}")
        self._archive.enable()


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
        """Show the present text."""
        text = self._shown(plan) if self._shown else rows.said(plan, self.key)
        short, whole = ("", "") if self._shown else rows.note(plan, self.row, self.key)
        if text != self._said:
            self._said = text
            self._text.set_value(text)
            self._fault.set_text("")
        self._note.set_text(short)
        if self._note.props.get("title") != whole:
            self._note.props["title"] = whole

    def _typed(self) -> None:
        text = str(self._text.value or "").strip()
        if text != self._said:
            self._fault.set_text(self._write(self.key, text))


def _coordinate(letter: str, at: str, axis: str, plan: Plan) -> str:
    car: Car | None = plan.cars.get(letter)
    i = "xy".index(axis)
    if car is None:
        return ""
    if at == "rest":
        pair = value_at(plan.document, f"{car.key}.rest.position")
        return rows.said(plan, f"{car.key}.rest.position[{i}]") if isinstance(pair, list) else ""
    return "" if car.at is None else f"{car.at[i]:.3f} m"


def _paths(result: object) -> list[dict[str, Any]]:
    """Paths of the vehicles in some draws of a result, to be drawn; none where none is recorded."""
    outcome = getattr(result, "outcome", None)
    if outcome is None:
        return []
    from retrodict.findings.run_outs import motions

    return [
        {
            "letter": v.upper(),
            "points": motion.pose[v][:: max(1, len(motion.pose[v]) // 60), :2].tolist(),
        }
        for motion in motions(outcome, _PATHS)
        for v in outcome.scene.vehicles
    ]


def _placed_by(content: bytes, state: State) -> State:
    if state.backdrop is None:
        raise refused("the photograph comes before its world file")
    placed = by_world_file(state.backdrop, content[:1000].decode("ascii", "replace"))
    return replace(state, backdrop=placed, said="the photograph placed by its world file")
