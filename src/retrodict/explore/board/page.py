"""The page of the drawing board: the plan, what is missing, what is known, and the answer."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import background_tasks, ui

from retrodict.explore import answers, beside
from retrodict.explore.answers import Answer
from retrodict.explore.board.arguments import reason
from retrodict.explore.board.backdrop import image_at
from retrodict.explore.board.board import Board
from retrodict.explore.board.drawing import drawing
from retrodict.explore.board.needs import Need, thing_of
from retrodict.explore.board.panels import Panels
from retrodict.explore.board.sheet import Sheet
from retrodict.explore.board.state import State
from retrodict.explore.explorer import Explorer, Setting
from retrodict.explore.templates import template, text_of
from retrodict.scene.errors import SceneError
from retrodict.scene.load import value_at
from retrodict.scene.plausibility import plausibility_warnings
from retrodict.scene.quantities import Units
from retrodict.scene.records import Scene

_LOG = logging.getLogger(__name__)
_NOT_BESIDE = (
    '<p class="not">Questions and what would narrow the answer could not be computed; the terminal '
    "says why.</p>"
)
_BEAT = 0.25  # s between looks at how far the work is
_PATHS = 21  # motions that are drawn
_PACKAGE = "retrodict.explore.board"
_UNITS = {"si": "metres, m/s", "us": "feet, mph"}
_LOOK = "dense outlined options-dense"


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
        self._fits = False  # whether everything is to be brought into view then
        self._due = False  # whether the present state is about to be shown
        self._done = 0  # number of the browser's last act that was done or refused
        self._count = 0
        self._paths: list[dict[str, Any]] = []  # of the result that was confirmed last
        self._paths_of: State | None = None
        self._points, self._lines = board.state.points, board.state.lines
        self._warnings: tuple[str, ...] = ()
        self._warned_of: Scene | None = None
        self._warning = False  # whether warnings are being looked for
        self._confirming = False

    def build(self) -> None:
        """Make the page's elements, and begin to show."""
        ui.colors(primary="#0072B2")
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
                self.sheet = Sheet(
                    drawing(self.board.state, self.board.plan),
                    self._points,
                    self._lines,
                    self.units,
                )
                self.sheet.on("act", lambda e: self._act(e.args))
                self.sheet.on("pick", lambda e: self._picked(e.args))
            with ui.element("section").classes("side"):
                # its height is its own: what comes or goes there moves nothing that is clicked
                with ui.element("div").classes("state").props("aria-live=polite"):
                    self._note = ui.label(self.board.note).classes("small")
                    self._kept = ui.label("").classes("small")
                    self._written = ui.html("", sanitize=False).classes("small")
                    self._needs = ui.element("div").classes("needs")
                    self._progress = ui.linear_progress(value=0, show_value=False, size="3px")
                    self._progress.props("indeterminate instant-feedback").set_visibility(False)
                    self._answer = ui.html("", sanitize=False).classes("answer-box")
                    self._beside = ui.html("", sanitize=False).classes("beside")
                    self._doing = ui.label("").classes("doing")
                    self._more = ui.element("div").classes("needs more")
                    self._warned = ui.element("div").classes("warnings")
                self._panels = Panels(
                    self.board, self.sheet, self._do, self._try, self._kept.set_text, self._fit
                )
                self._panels.build()
                self._actions()
        with ui.dialog().props("persistent") as self._elsewhere, ui.card():
            ui.label("This scene was opened on another page, which goes on with it.")
            ui.button("Go on here", on_click=lambda: ui.navigate.reload())
        self._show()
        ui.timer(_BEAT, self._tick)
        client = ui.context.client
        client.on_connect(self._begin)
        client.on_delete(lambda: self.explorer.leave(self))

    # what the explorer calls

    def working(self, busy: bool) -> None:
        """Say whether an answer is being computed."""
        self._progress.set_visibility(busy)

    def answered(self, answer: Answer) -> None:
        """Show an answer, and then what stands beside it."""
        self._count += 1
        self._answer.set_content(answers.html(answer, self.units, self._count))
        background_tasks.create(self._put_beside(answer, self.units))

    def failed(self, why: str) -> None:
        """Say why there is no answer."""
        self._answer.set_content(template("failed.html.j2").render(why=why))
        self._beside.set_content("")

    def superseded(self) -> None:
        """Say that another page has taken over."""
        self._elsewhere.open()

    async def _put_beside(self, answer: Answer, units: Units) -> None:
        try:
            found = await asyncio.to_thread(beside.html, answer, units)
        except Exception:  # the answer stands without it
            _LOG.exception("what stands beside an answer failed")
            found = _NOT_BESIDE
        if self.explorer.answer is answer and self.units == units:
            self._beside.set_content(found)

    # what the user does

    def _act(self, args: Any) -> None:
        name, values, number = args.get("name"), args.get("values"), args.get("number")
        if isinstance(number, int):
            self._done = max(self._done, number)
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
        why = ""
        try:
            what()
        except (SceneError, OSError) as error:
            why = reason(error)
        except Exception as error:  # any is shown where it was asked for, or it would be lost
            _LOG.exception("an action on the board failed")
            why = f"the program failed, and nothing was changed ({type(error).__name__}: {error})"
        if why:
            self.sheet.run_method("refuse", why)
        self._refresh()
        return why

    def _undone(self) -> None:
        self._try(self.board.undo)

    def _redone(self) -> None:
        self._try(self.board.redo)

    def _saved(self) -> None:
        why = self._try(self.board.save)
        self._kept.set_text(why or f"Saved: {self.board.path}")

    def _use(self, units: Units) -> None:
        self.units = units
        self.sheet.run_method("measure", units)
        if self.explorer.answer:
            self.answered(self.explorer.answer)

    def _picked(self, args: Any) -> None:
        thing = args.get("thing") if isinstance(args, dict) else None
        if isinstance(thing, str):
            self._panels.choose(thing)

    def _tick(self) -> None:
        self._doing.set_text(self.explorer.doing)

    def _begin(self) -> None:
        if self._begun:
            return
        self._begun = True
        self.explorer.show_in(self)
        self._refresh()

    # showing

    def _refresh(self) -> None:
        """Show the present state, once for all steps that have already arrived."""
        if not self._due:
            self._due = True
            background_tasks.create(self._show_soon())

    def _fit(self) -> None:
        """Bring everything into view, once it is shown."""
        self._fits = True
        self._refresh()

    async def _show_soon(self) -> None:
        await asyncio.sleep(0)
        self._due = False
        self._show()

    def _show(self) -> None:
        """Show the present state everywhere."""
        board, state = self.board, self.board.state
        plan, scene, needs = board.plan, board.scene, board.needs
        warned = self._warnings_of(scene)
        if self._begun:  # before, it has the first drawing
            drawn = drawing(state, plan)
            drawn["paths"] = self._paths if state == self._paths_of else []
            drawn["warnings"] = [{"thing": thing_of(line), "words": line} for line in warned]
            drawn["done"] = self._done
            self.sheet.run_method("show", drawn)
            if state.points is not self._points or state.lines is not self._lines:
                self._points, self._lines = state.points, state.lines
                self.sheet.run_method("surveyed", state.points, state.lines)
            if self._fits:
                self._fits = False
                self.sheet.run_method("fit")
        self._note.set_text(board.note)
        title = value_at(plan.document, "title")
        self._title.set_text(
            f"{board.path.name}{' (not saved)' if board.unsaved else ''} · "
            f"{title if isinstance(title, str) else 'Untitled'}"
        )
        for button, word, what in (
            (self._undo, "Undo", board.undoes),
            (self._redo, "Redo", board.redoes),
        ):
            button.set_enabled(bool(what))
            button.props["title"] = f"{word}: {what}" if what else word
        missing = [need for need in needs if not need.more]
        _list_needs(self._needs, missing)
        _list_needs(self._more, [] if missing else [need for need in needs if need.more])
        self._answer.set_visibility(not missing)
        self._beside.set_visibility(not missing)
        self._warned.clear()
        with self._warned:
            for line in warned:
                ui.label(line).classes("warning").props(f"data-warning={thing_of(line)}")
        self._confirm.set_enabled(scene is not None and not self._confirming)
        self._sliders.set_visibility(scene is not None)
        self._panels.show(plan)
        if self._begun:
            self.explorer.follow(scene)

    def _warnings_of(self, scene: Scene | None) -> tuple[str, ...]:
        """Warnings of a scene as far as they are known; they are looked for beside the page's work."""
        if scene is None:
            return ()
        if scene != self._warned_of and not self._warning:
            self._warning = True
            background_tasks.create(self._warn(scene))
        return self._warnings

    async def _warn(self, scene: Scene) -> None:
        try:
            self._warnings = await asyncio.to_thread(plausibility_warnings, scene)
        finally:
            self._warned_of, self._warning = scene, False
        self._refresh()

    # parts of the page

    def _actions(self) -> None:
        with ui.element("div").classes("actions-box"):
            self._confirm = ui.button(
                "Confirm by NUTS and write the report", on_click=self._confirmed
            ).props("no-caps outline")
            self._report = ui.button("Report").props("no-caps outline href=/report target=_blank")
            self._archive = ui.button("Archive", on_click=self._archived).props("no-caps outline")
            self._report.set_enabled(self.explorer.result is not None)
            self._archive.set_enabled(self.explorer.result is not None)
            self._sliders = ui.link("Sliders, marginals and joint", "/sliders").classes("small")

    async def _confirmed(self) -> None:
        asked, self._confirming = self.board.state, True
        self._confirm.disable()
        self._written.set_content("")
        try:
            around = partial(_on_photograph, self.board.path.parent, asked)
            path = await self.explorer.confirm(self.setting.out, self.units, around)
            said = template("written.html.j2").render(path=str(path), why="")
            self._paths, self._paths_of = _paths(self.explorer.result), asked
            self._refresh()
            self._report.enable()
            self._archive.enable()
        except Exception as error:  # any is shown beside the button
            said = template("written.html.j2").render(path="", why=str(error))
        self._written.set_content(said)
        self._confirming = False
        self._refresh()

    async def _archived(self) -> None:
        self._archive.disable()
        try:
            path = await self.explorer.archive(self.setting.out)
            self._kept.set_text(f"Archived: {path}")
        except Exception as error:  # any is shown
            self._kept.set_text(f"Not archived: {error}")
        self._archive.enable()


def _list_needs(place: ui.element, needs: list[Need]) -> None:
    place.clear()
    with place:
        for need in needs:
            kind = "need wrong" if need.wrong else "need more" if need.more else "need"
            ui.label(need.words).classes(kind).props(f"data-need={need.thing}")
    place.set_visibility(bool(needs))


def _on_photograph(folder: Path, state: State) -> AbstractContextManager[None]:
    """The context in which plans are drawn on the board's photograph, where its scale was set."""
    from retrodict.report.figures.photograph import Photograph, under_plans

    backdrop, found = state.backdrop, image_at(folder, state.backdrop)
    if backdrop is None or found is None or not backdrop.scaled:
        return under_plans(None)
    photograph = Photograph(
        path=found[0],
        sha256=backdrop.sha256,
        width=backdrop.width,
        height=backdrop.height,
        metres=backdrop.metres,
        x=backdrop.x,
        y=backdrop.y,
        turn=backdrop.turn,
    )
    return under_plans(photograph)


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
