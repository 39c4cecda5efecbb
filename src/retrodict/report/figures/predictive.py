"""Evidence and inputs against what the reconstruction makes of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from retrodict.findings.inputs import InputRow
from retrodict.findings.rounding import format_value
from retrodict.report.figures import drawing
from retrodict.scene.quantities import Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

CAPTION = (
    "Top: for each item of evidence, what the model predicts for a measurement like it, as "
    "distance from the measured value in its standard deviations, which hold how far the run-out is "
    "taken to miss a car. Bottom: for each measured "
    "input, its posterior, likewise. Bars hold the middle 50 % (thick) and 95 % (thin) of the "
    "draws; dots are medians, filled where they lie more than two standard deviations from the "
    "measured value. Bands reach one and two measured standard deviations. At the right, what was "
    "measured, and after a comma how far the run-out is taken to miss; * marks a default uncertainty, "
    "** a default value."
)
_STARS = {"": "", "sd": " *", "value": " **"}
_ROW = 0.19  # inches


@drawing.styled
def predictive_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """Evidence as predicted and inputs as inferred, about what was measured."""
    rows = [row for row in findings.measured if row.measured.sd > 0]
    kinds = [
        ("evidence", "Evidence: predicted about measured"),
        ("input", "Inputs: posterior about measured"),
    ]
    counts = [max(sum(row.kind == kind for row in rows), 2) for kind, _ in kinds]
    figure = drawing.new_figure(7.2, _ROW * sum(counts) + 2.0)
    panels = figure.subplots(2, 1, height_ratios=counts, sharex=True)
    reach = 3.0
    for axes, (kind, title) in zip(panels, kinds, strict=True):
        shown = [row for row in rows if row.kind == kind]
        reach = max(reach, _panel(axes, shown, units))
        axes.set_title(title)
    reach = min(1.08 * reach, 12.0)  # an item further out is drawn at the edge by its own arrow
    panels[0].set_xlim(-reach, reach)
    panels[1].xaxis.set_major_locator(MaxNLocator(9, integer=True))
    panels[1].set_xlabel("distance from the measured value (measured standard deviations)")
    figure.legend(handles=_legend(), loc="outside lower center", ncols=5)
    return figure


def _panel(axes: Axes, rows: list[InputRow], units: Units) -> float:
    """Draw the rows, first on top; return how far the furthest bar reaches."""
    reach = 0.0
    for band, shade in ((2, "#efefef"), (1, "#dedede")):
        axes.axvspan(-band, band, color=shade, lw=0, zorder=0)
    axes.axvline(0, color=drawing.INK, lw=0.8, zorder=1)
    bars = []  # y, then the quantiles
    for y, row in enumerate(rows):
        quantiles = row.quantiles
        if quantiles is None:
            axes.text(0, y, "no draws", ha="center", va="center", color=drawing.GREY, size=8)
            continue
        bars.append((y, *quantiles))
        reach = max(reach, *np.abs(quantiles))
        middle = quantiles[2]
        if abs(middle) > 12:
            right = middle > 0
            axes.annotate(
                format_value(middle, 0) + " sd", (0.99 if right else 0.01, y), va="center",
                ha="right" if right else "left", xycoords=axes.get_yaxis_transform(),
                weight="bold", color=drawing.ORANGE,
            )  # fmt: skip
    if bars:  # all of a kind at once, which is faster than one by one
        y, low, q1, middle, q3, high = np.transpose(bars)
        axes.hlines(y, low, high, color=drawing.BLUE, lw=1.2, capstyle="butt", zorder=2)
        axes.hlines(y, q1, q3, color=drawing.BLUE, lw=4.5, capstyle="butt", zorder=2)
        far = np.abs(middle) > 2
        for which, fill in ((~far, "white"), (far, drawing.ORANGE)):
            axes.plot(
                middle[which], y[which], "o", color=fill, mec=drawing.INK, mew=0.9, ms=4.8, zorder=3
            )
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_yticks(range(len(rows)), [row.label for row in rows])
    axes.tick_params(axis="y", length=0)
    opposite = axes.secondary_yaxis("right")
    opposite.set_yticks(
        range(len(rows)),
        [_measured(row, units) for row in rows],
    )
    opposite.tick_params(length=0, labelsize=8)
    for spine in ("left", "right"):
        axes.spines[spine].set_visible(False)
        opposite.spines[spine].set_visible(False)
    return reach


def _measured(row: InputRow, units: Units) -> str:
    missed = f", {row.format_model(units)}" if row.measured.model_sd else ""
    return f"{row.format_measured(units)}{missed} {row.unit(units)}{_STARS[row.assumed]}"


def _legend() -> list[Patch | Line2D]:
    return [
        Line2D([], [], color=drawing.BLUE, lw=4.5, label="50 % of draws"),
        Line2D([], [], color=drawing.BLUE, lw=1.2, label="95 % of draws"),
        Line2D([], [], ls="", marker="o", color="white", mec=drawing.INK, label="median"),
        Patch(color="#dedede", label="±1 sd measured"),
        Patch(color="#efefef", label="±2 sd"),
    ]
