"""The effect of each measurement on each speed that was sought, largest first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from retrodict.report.figures import drawing
from retrodict.scene.quantities import Units, label_and_unit
from retrodict.studies.one_at_a_time import Effect

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.findings.answers import Answered
    from retrodict.inference.outcome import Outcome

CAPTION = (
    "By how much the answer would move, were each measurement alone one standard deviation higher "
    "(filled) or lower (open), to first order. The largest effects are at the top."
)
_MOST, _ROW = 10, 0.22  # bars; inches


@drawing.styled
def tornado_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """A bar for each measurement, to either side of the answer."""
    tables = [each for each in findings.questions if each.kind == "one_at_a_time" and each.numbers]
    figure = drawing.new_figure(7.2, (_MOST * _ROW + 0.9) * max(len(tables), 1))
    panels = figure.subplots(max(len(tables), 1), 1, squeeze=False)[:, 0]
    if not tables:
        drawing.nothing_here(panels[0], "no effect of a measurement was computed")
    for axes, each in zip(panels, tables, strict=False):
        _panel(axes, each, units)
    return figure


def _panel(axes: Axes, asked: Answered, units: Units) -> None:
    assert isinstance(asked.numbers, tuple)
    label, unit = label_and_unit(asked.quantity or "", units)
    effects = [each for each in asked.numbers[:_MOST] if isinstance(each, Effect)]
    for row, effect in enumerate(effects):
        moved = effect.moved / unit.worth
        axes.barh(row, moved, height=0.7, color=drawing.BLUE)
        axes.barh(row, -moved, height=0.7, facecolor="white", edgecolor=drawing.BLUE)
    names = [label_and_unit(effect.name, units)[0] for effect in effects]
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.axvline(0, color=drawing.INK, linewidth=0.7)
    axes.set_xlabel(f"change of the {label} ({unit.symbol})")
