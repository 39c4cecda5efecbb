"""The page: a scene with its controls on one side, its answer, marginals and joint on the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, cast

from nicegui import ui

from retrodict.explore import answers
from retrodict.explore.answers import Answer
from retrodict.explore.controls import GROUPS, Control, controls
from retrodict.explore.explorer import Explorer, Setting
from retrodict.explore.templates import template, text_of
from retrodict.report.figures.drawing import BLUE, GREY
from retrodict.report.scene_svg import scene_svg, view_of
from retrodict.scene.errors import SceneError
from retrodict.scene.quantities import SHORT, Units, label_and_unit
from retrodict.scene.units import QuantityError

_OCTAVES = 2.0  # powers of 2 that an uncertainty's slider reaches to either side
_BEAT = 0.25  # s between looks at how far the work is
_UNITS = {"si": "m/s", "us": "mph"}


class Page:
    """The page on which a browser shows an explorer.

    Args:
        explorer: explorer whose scene the page changes.
        setting: settings of the page, besides the scene.
    """

    def __init__(self, explorer: Explorer, setting: Setting) -> None:
        self.explorer, self.setting = explorer, setting
        self.units = setting.units
        self._begun = False
        self._count = 0
        self._windows: dict[str, tuple[float, float]] = {}
        assert explorer.original is not None, "its sliders are shown once it is complete"
        self._original = explorer.original
        self._view = view_of(self._original)
        self._rows: list[ControlRow] = []
        self._marginals: dict[str, ui.echart] = {}

    def build(self) -> None:
        """Make the page's elements, and begin to show."""
        ui.add_css(text_of("page.css"))
        scene = self._original
        with ui.element("header").classes("top"):
            ui.label(scene.title).classes("title")
            ui.select(
                ["auto", *self.setting.models], value=self.explorer.model, label="model",
                on_change=lambda e: self.explorer.choose(e.value),
            ).props("dense outlined options-dense").classes("model")  # fmt: skip
            ui.select(
                _UNITS, value=self.units, label="units", on_change=lambda e: self._use(e.value)
            ).props("dense outlined options-dense").classes("units")
        with ui.element("div").classes("board"):
            with ui.element("section").classes("answer"):
                self._progress = ui.linear_progress(value=0, show_value=False, size="3px").props(
                    "indeterminate instant-feedback"
                )
                self._answer = ui.html("", sanitize=False).props("aria-live=polite")
                self._doing = ui.label("").classes("doing")
            with ui.element("section").classes("controls"):
                self._controls()
            with ui.element("section").classes("pictures"):
                self._pictures = ui.element("div").classes("marginals")
                self._joint_part()
                self._scene = ui.html("", sanitize=False).classes("scene")
            with ui.element("section").classes("actions"):
                self._actions()
        with ui.dialog().props("persistent") as self._elsewhere, ui.card():
            ui.label("This scene was opened on another page, which goes on with it.")
            ui.button("Go on here", on_click=lambda: ui.navigate.reload())
        self._draw_scene()
        ui.timer(_BEAT, self._tick)
        client = ui.context.client
        client.on_connect(self._begin)  # not sooner: a browser may load a page that nobody sees
        client.on_delete(lambda: self.explorer.leave(self))

    # what the explorer calls

    def working(self, busy: bool) -> None:
        """Say whether an answer is being computed."""
        self._progress.set_visibility(busy)

    def answered(self, answer: Answer) -> None:
        """Show an answer."""
        self._count += 1
        self._answer.set_content(answers.html(answer, self.units, self._count))
        self._draw_marginals(answer)
        self._draw_joint(answer)

    def failed(self, why: str) -> None:
        """Say why there is no answer."""
        self._answer.set_content(template("failed.html.j2").render(why=why))
        for chart in self._marginals.values():
            chart.options["series"][-1]["data"] = []
            chart.update()
        self._joint.options["series"][0]["data"] = []
        self._joint.update()

    def superseded(self) -> None:
        """Say that another page has taken over."""
        self._elsewhere.open()

    # what the user does

    def change(self, row: ControlRow, text: str) -> None:
        """Change a quantity to a text; say at its row why that is refused, if it is."""
        if not self.explorer.shown_in(self):
            return
        control = row.control
        try:
            self.explorer.change(control.key, text, control.changes(text))
        except SceneError as error:
            row.refuse("; ".join(str(problem) for problem in error.problems))
            return
        row.accept(text)
        self._draw_scene()

    def _use(self, units: Units) -> None:
        self.units = units
        self._windows = {}
        self._draw_scene()
        if self.explorer.answer:
            self.answered(self.explorer.answer)

    def _reset(self) -> None:
        self.explorer.reset()
        for row in self._rows:
            row.accept(row.control.text())
        self._windows = {}
        self._draw_scene()

    def _tick(self) -> None:
        self._doing.set_text(self.explorer.doing)

    def _begin(self) -> None:
        if self._begun:  # a connection that was lost for a moment
            return
        self._begun = True
        self.explorer.show_in(self)

    # parts of the page

    def _controls(self) -> None:
        every = controls(self._original)
        with ui.row().classes("heading"):
            ui.label("Measurements and priors").classes("part")
            ui.button("Reset all", on_click=self._reset).props("flat dense no-caps")
        for group in GROUPS:
            if members := [each for each in every if each.group == group]:
                opened = group == every[0].group
                part = ui.expansion(group, value=opened).classes("group")
                if opened:
                    self._fill(part, members)
                else:  # half a hundred controls take a browser some time
                    part.on_value_change(partial(self._fill, part, members))

    def _fill(self, part: ui.expansion, members: Sequence[Control]) -> None:
        if part.default_slot.children:
            return
        with part:
            for control in members:
                text = self.explorer.texts.get(control.key)
                self._rows.append(ControlRow(control, self.change, text))

    def _joint_part(self) -> None:
        with ui.element("div").classes("joint"):
            with ui.row().classes("pair"):
                look = "dense outlined options-dense"
                self._one = ui.select([], label="across", on_change=self._paired).props(look)
                self._other = ui.select([], label="up", on_change=self._paired).props(look)
            self._joint = ui.echart(_joint_options(), renderer="svg").classes("chart")

    def _paired(self) -> None:
        if self.explorer.answer:
            self._draw_joint(self.explorer.answer)

    def _actions(self) -> None:
        ui.label("Confirm and keep").classes("part")
        ui.label(
            "While you drag, the posterior is computed by importance sampling. NUTS computes it anew."
        ).classes("small")
        self._confirm = ui.button(
            "Confirm by NUTS and write the report", on_click=self._confirmed
        ).props("no-caps")
        self._written = ui.html("", sanitize=False).classes("small")
        with ui.row().classes("save"):
            self._file = ui.input("save as", value=f"{self.setting.file.stem}-changed.toml").props(
                "dense outlined"
            )
            self._replace = ui.checkbox("replace it")
            ui.button("Save the changed scene", on_click=self._saved).props("no-caps outline")
        self._kept = ui.label("").classes("small")

    async def _confirmed(self) -> None:
        self._confirm.disable()
        self._written.set_content("")
        try:
            path = await self.explorer.confirm(self.setting.out, self.units)
            said = template("written.html.j2").render(path=str(path), why="")
        except Exception as error:  # any is shown beside the button
            said = template("written.html.j2").render(path="", why=str(error))
        self._written.set_content(said)
        self._confirm.enable()

    def _saved(self) -> None:
        try:
            path = self.explorer.save(
                self.setting.file.parent, self._file.value, self._replace.value
            )
            self._kept.set_text(f"Saved: {path}")
        except (SceneError, OSError) as error:
            self._kept.set_text(str(error))

    # drawing

    def _draw_scene(self) -> None:
        scene = self.explorer.scene
        if scene is None:
            return
        self._view = view_of(scene, self._view)
        self._scene.set_content(scene_svg(scene, self.units, self._view))

    def _draw_marginals(self, answer: Answer) -> None:
        names = answers.drawn(answer)
        if tuple(self._marginals) != names:
            self._pictures.clear()
            with self._pictures:
                self._marginals = {
                    name: ui.echart(_marginal_options(name, self.units), renderer="svg").classes(
                        "chart"
                    )
                    for name in names
                }
        first = self.explorer.of_file
        if first is not None and set(names) - set(answers.drawn(first)):
            first = None  # its checks withhold some
        for name, chart in self._marginals.items():
            curve = answers.curve(answer, name, self.units)
            before = [] if first is None else answers.curve(first, name, self.units)
            low, high = self._window(name, before + curve)
            chart.options["title"]["text"] = _title(name, self.units)
            chart.options["xAxis"] |= {"min": low, "max": high}
            for series, data in zip(chart.options["series"], (before, curve), strict=True):
                series["data"] = data
            chart.update()
        if list(self._one.options) != list(names):
            self._one.set_options(_labels(names), value=names[0] if names else None)
            self._other.set_options(_labels(names), value=names[1] if len(names) > 1 else None)

    def _draw_joint(self, answer: Answer) -> None:
        one, other = self._one.value, self._other.value
        if not one or not other or {one, other} - set(answers.drawn(answer)):
            return
        options = self._joint.options
        for axis, name in (("xAxis", one), ("yAxis", other)):
            low, high = self._windows[name]
            options[axis] |= {"min": low, "max": high, "name": _title(name, self.units)}
        options["series"][0]["data"] = answers.dots(answer, one, other, self.units)
        self._joint.update()

    def _window(self, name: str, curve: list[list[float]]) -> tuple[float, float]:
        """Limits of an axis; they only widen, so that a density is seen to move."""
        if curve:
            low, high = min(x for x, _ in curve), max(x for x, _ in curve)
            room = 0.25 * (high - low)
            now = self._windows.get(name, (low - room, high + room))
            if low < now[0] or high > now[1]:
                now = (min(low - room, now[0]), max(high + room, now[1]))
            self._windows[name] = now
        return self._windows.get(name, (0.0, 1.0))


class ControlRow:
    """A quantity's label, text and sliders.

    Args:
        control: the quantity.
        change: function that is called with this row and the text that was set.
        text: present text of the quantity; None for the file's.
    """

    def __init__(
        self, control: Control, change: Callable[[ControlRow, str], None], text: str | None
    ) -> None:
        self.control = control
        self._change = change
        self._quiet = False  # while the elements are set by the program
        self._said = text or control.text()
        low, high = control.slider_range
        with ui.element("div").classes("control").props(f"data-key={control.key}"):
            with ui.element("div").classes("line"):
                label = ui.label(control.label).classes("label")
                if control.source:
                    label.tooltip(control.source)
                self._text = ui.input(value=self._said).props("dense outlined").classes("quantity")
                self._text.props["aria-label"] = control.label
                self._text.on("keydown.enter", self._typed).on("blur", self._typed)
                self._back = ui.button(icon="undo", on_click=self._undo).props(
                    "flat dense round size=sm"
                )
                self._back.props["aria-label"] = f"{control.label}: as in the file"
            self._value = ui.slider(
                min=low, max=high, step=control.step, on_change=self._moved
            ).props("dense")
            self._value.props["aria-label"] = f"{control.label}: value"
            self._sd = None
            if control.takes_sd and control.sd:
                with ui.element("div").classes("line sd"):
                    ui.label("± sd").classes("label")
                    self._sd = ui.slider(
                        min=-_OCTAVES, max=_OCTAVES, step=_OCTAVES / 40, on_change=self._moved
                    ).props("dense color=grey-7")
                    self._sd.props["aria-label"] = f"{control.label}: uncertainty"
            self._fault = ui.label("").classes("fault").props("role=alert")
        self.accept(self._said)

    def accept(self, text: str) -> None:
        """Show a text that the scene now has."""
        self._said = text
        self._fault.set_text("")
        control = self.control
        try:
            value, sd = control.read(text)
        except QuantityError:  # a word
            value, sd = control.value, 0.0
        self._quiet = True
        self._text.set_value(text)
        self._value.set_value(control.position(value))
        if self._sd is not None:
            self._sd.set_value(control.sd_position(sd))
        self._quiet = False
        changed = text != control.text()
        self._back.classes(add="" if changed else "off", remove="off" if changed else "")

    def refuse(self, why: str) -> None:
        """Say why the text is refused."""
        self._fault.set_text(why)

    def _moved(self) -> None:
        if self._quiet:
            return
        control = self.control
        value = control.value_at(cast(float, self._value.value))
        sd = control.sd_at(cast(float, self._sd.value)) if self._sd is not None else control.sd
        self._change(self, control.text(value, sd))

    def _typed(self) -> None:
        text = str(self._text.value or "").strip()
        if text != self._said or self._fault.text:
            self._change(self, text)

    def _undo(self) -> None:
        self._change(self, self.control.text())


def _labels(names: Sequence[str]) -> dict[str, str]:
    return {name: SHORT[name] for name in names}


def _title(name: str, units: Units) -> str:
    _, unit = label_and_unit(name, units)
    return f"{SHORT[name]}, {unit.symbol}" if unit.symbol else SHORT[name]


def _marginal_options(name: str, units: Units) -> dict[str, Any]:
    line = {"type": "line", "showSymbol": False, "silent": True, "data": []}
    return {
        "animation": False,
        "title": {"text": _title(name, units), "textStyle": {"fontSize": 13}, "left": 4, "top": 0},
        "grid": {"left": 12, "right": 12, "top": 26, "bottom": 22},
        "xAxis": _axis(),
        "yAxis": {"type": "value", "show": False},
        "series": [
            line | {"lineStyle": {"color": GREY, "type": "dashed", "width": 1}},
            line | {"lineStyle": {"color": BLUE}, "areaStyle": {"color": BLUE, "opacity": 0.25}},
        ],
    }


def _joint_options() -> dict[str, Any]:
    named = {"nameLocation": "middle", "nameTextStyle": {"color": "#222"}}
    return {
        "animation": False,
        "grid": {"left": 56, "right": 12, "top": 12, "bottom": 44},
        "xAxis": _axis() | named | {"nameGap": 26},
        "yAxis": _axis() | named | {"nameGap": 38},
        "series": [
            {
                "type": "scatter",
                "symbolSize": 4,
                "silent": True,
                "itemStyle": {"color": BLUE, "opacity": 0.45},
                "data": [],
            }
        ],
    }


def _axis() -> dict[str, Any]:
    labels = {"showMinLabel": False, "showMaxLabel": False, "hideOverlap": True}
    return {"type": "value", "splitLine": {"show": False}, "axisLabel": labels, "splitNumber": 4}
