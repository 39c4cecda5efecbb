"""The unknowns one by one: posterior over prior."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from retrodict.findings.rounding import format_range, format_value
from retrodict.findings.statistics import finite_draws, scaled, scaled_interval
from retrodict.report.figures import drawing
from retrodict.report.results import marked
from retrodict.scene.quantities import REPORTED, Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

CAPTION = (
    "Posterior densities of the unknowns (shaded; smoothed from all draws, no smoothing past a "
    "bound) with the prior's density (dashed). Below each: the median (white dot) with the "
    "central intervals of 50 % (thick bar) and 90 % (thin bar) of the draws. The window "
    "is the posterior's; a prior may reach far beyond it."
)


@drawing.styled
def posterior_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """Marginal posteriors of the unknown speeds, e, e_m and μ over their priors."""
    names = drawing.shown(findings)
    rows = (len(names) + 1) // 2
    figure = drawing.new_figure(7.2, 2.5 * rows)
    panels = figure.subplots(rows, 2).flat
    for axes, name in zip(panels, names, strict=False):
        _panel(axes, findings, outcome, name, units)
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    figure.legend(handles=_legend(), loc="outside lower center", ncols=5)
    return figure


def _panel(axes: Axes, findings: Findings, outcome: Outcome, name: str, units: Units) -> None:
    values = finite_draws(outcome, "posterior", name)
    unit = drawing.worth(name, units)
    curve = None if values is None else drawing.density(values / unit.worth)
    if values is None or curve is None:
        drawing.nothing_here(axes, f"no draws of {REPORTED[name][0]}")
        return
    found = findings.quantities[name]
    precision = found.precision[units]
    median = scaled(found.median, unit.worth)
    half, most = (scaled_interval(found.intervals[level], unit.worth) for level in (50, 90))
    grid, height = curve
    top = float(height.max())
    axes.fill_between(grid, height, color=drawing.BLUE, alpha=0.25, lw=0)
    axes.plot(grid, height, color=drawing.BLUE, lw=1.4)
    margin = 0.25 * np.ptp(grid)
    axes.set_xlim(grid[0] - margin, grid[-1] + margin)
    _prior(axes, outcome, name, unit.worth)
    y = -0.09 * top
    axes.plot(np.array(most, float), [y, y], color=drawing.INK, lw=1.2, marker="|", ms=5)
    axes.plot(np.array(half, float), [y, y], color=drawing.INK, lw=4.5, solid_capstyle="butt")
    axes.plot(np.array(median, float), y, "o", color="white", mec=drawing.INK, ms=5, zorder=5)
    axes.set_ylim(-0.18 * top, 1.12 * top)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=drawing.STEPS))
    axes.set_xlabel(f"{unit.symbol}" if unit.symbol else "dimensionless")
    label = REPORTED[name][0]
    axes.set_title(label[0].upper() + label[1:].replace("e_m", r"$\mathbf{e_m}$"))
    lines = [
        f"{format_value(median, precision.decimals)} {unit.symbol}".rstrip(),
        f"90 %: {format_range(most, precision.of_level[90])}",
    ]
    if found.withheld:
        lines = lines[:1]
    shown = [marked(findings, line, found.withheld) for line in lines]
    axes.text(
        0.99,
        0.98,
        "\n".join(shown),
        transform=axes.transAxes,
        ha="right",
        va="top",
        linespacing=1.4,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.5},
    )


def _prior(axes: Axes, outcome: Outcome, name: str, worth: float) -> None:
    prior = finite_draws(outcome, "prior", name)
    curve = None if prior is None else drawing.density(prior / worth)
    if curve is None:
        return
    grid, height = curve
    # a bound inside the window shows as a cliff, not as a line that hangs in the air
    grid = np.concatenate([grid[:1], grid, grid[-1:]])
    axes.plot(grid, np.concatenate([[0], height, [0]]), color=drawing.GREY, lw=1.1, ls=(0, (4, 2)))


def _legend() -> list[Patch | Line2D]:
    ink = drawing.INK
    return [
        Patch(facecolor=drawing.BLUE, alpha=0.4, label="posterior"),
        Line2D([], [], color=drawing.GREY, lw=1.1, ls=(0, (4, 2)), label="prior"),
        Line2D([], [], color="white", marker="o", mec=ink, label="median"),
        Line2D([], [], color=ink, lw=4.5, label="50 %"),
        Line2D([], [], color=ink, lw=1.2, marker="|", label="90 %"),
    ]
