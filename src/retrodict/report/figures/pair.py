"""The unknowns two by two: how they depend on one another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from retrodict.findings.rounding import format_value
from retrodict.findings.statistics import finite_draws
from retrodict.report.figures import drawing
from retrodict.report.results import marked
from retrodict.scene.quantities import UNKNOWNS, Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

CAPTION = (
    "Joint posterior of the unknowns. Lower left: draws (dots; thinned), and the smallest regions "
    "that hold 50 % (solid line) and 90 % (dashed line) of them, from a Gaussian kernel density. "
    "Diagonal: marginal densities. Upper right: coefficients of correlation over all draws."
)


@drawing.styled
def pair_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """Pair plot of the unknown speeds, e, e_m and μ with density regions and correlations."""
    names = [name for name in UNKNOWNS if name in drawing.shown(findings)]
    values = {
        name: None if (v := finite_draws(outcome, "posterior", name)) is None
        else v / drawing.worth(name, units).worth
        for name in names
    }  # fmt: skip
    figure = drawing.new_figure(7.2, 6.9)
    grid = figure.subplots(len(names), len(names))
    for i, row in enumerate(names):
        for j, column in enumerate(names):
            axes, x, y = grid[i, j], values[column], values[row]
            if x is None or y is None:
                drawing.nothing_here(axes, "no draws")
            elif i == j:
                _marginal(axes, x)
            elif i > j:
                _joint(axes, x, y)
            else:
                _correlation(axes, findings, (row, column))
            _frame(axes, i, j, units, values)
    figure.align_ylabels(grid[:, 0])
    figure.legend(
        handles=[
            Line2D([], [], ls="", marker=".", color=drawing.GREY, label="draws"),
            Line2D([], [], color=drawing.BLUE, lw=1.6, label="50 % of the draws"),
            Line2D([], [], color=drawing.BLUE, lw=1.2, ls="--", label="90 % of the draws"),
        ],
        loc="outside lower center",
        ncols=3,
    )
    return figure


def _frame(axes: Axes, i: int, j: int, units: Units, values: dict[str, np.ndarray | None]) -> None:
    """Limits shared along rows and columns; ticks and labels at the outer panels only."""
    if i < j:
        return
    names = list(values)
    bottom = i == len(names) - 1
    for axis, k, outer in ((axes.xaxis, j, bottom), (axes.yaxis, i, j == 0 and i > 0)):
        if axis is axes.yaxis and i == j:
            axes.set_yticks([])
            continue
        axis.set_major_locator(MaxNLocator(5, steps=drawing.STEPS, prune="both"))
        axis.set_tick_params(labelleft=outer, labelbottom=outer)
        if outer:
            axis.set_label_text(drawing.axis_label(names[k], units))
        data = values[names[k]]
        if data is not None and np.ptp(data) > 0:
            low, high = np.quantile(data, [0.001, 0.999])
            margin = 0.08 * (high - low)
            limits = (low - margin, high + margin)
            _ = axes.set_xlim(limits) if axis is axes.xaxis else axes.set_ylim(limits)


def _marginal(axes: Axes, x: np.ndarray) -> None:
    curve = drawing.density(x)
    axes.spines["left"].set_visible(False)
    if curve is None:
        return
    axes.fill_between(*curve, color=drawing.BLUE, alpha=0.25, lw=0)
    axes.plot(*curve, color=drawing.BLUE, lw=1.4)
    axes.set_ylim(0, None)


def _joint(axes: Axes, x: np.ndarray, y: np.ndarray) -> None:
    if x.size != y.size:
        drawing.nothing_here(axes, "no joint draws")
        return
    drawing.cloud(axes, x, y, drawing.BLUE)


def _correlation(axes: Axes, findings: Findings, names: tuple[str, str]) -> None:
    axes.set_axis_off()
    r = findings.correlations.get(names)
    if r is None:
        return
    withheld = any(findings.quantities[name].withheld for name in names)
    text = marked(findings, format_value(r, 2), withheld)
    size = 10 + 7 * abs(r) if text[0].isdigit() or text[0] == "−" else 10
    kwargs: dict[str, Any] = {"ha": "center", "transform": axes.transAxes}
    axes.text(0.5, 0.52, text, va="center", size=size, color=drawing.INK, **kwargs)
    pair = " and ".join(drawing.SHORT[name] for name in reversed(names))
    axes.text(0.5, 0.28, pair, va="center", size=8, color=drawing.GREY, **kwargs)
