"""Staged collisions: each speed's intervals beside what was measured and what others found."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from retrodict.report.figures import drawing
from retrodict.scene.quantities import Units, unit_of

if TYPE_CHECKING:
    from retrodict.studies.validation import Score, Validation

CAPTION = (
    "A row is a speed before impact. The bars are its central 95, 90 and 50 % intervals, thicker as "
    "they narrow; the white line is the median. The diamond is the speed that was measured, and "
    "triangles are what others reconstructed. Where an answer is withheld, none is drawn."
)
ERRORS_CAPTION = (
    "Left: error of each median over the posterior's sd, by kind of case. Of a calibrated normal "
    "posterior 90 % lie in the grey band. Right: share of the speeds below whose true value at most "
    "this share of the draws lies. Calibrated answers stay within the grey band throughout in 95 % of "
    "sets of so many independent speeds."
)
_BARS = {95: 1.2, 90: 4.0, 50: 9.0}  # widths, in points
_FEW = 20  # speeds that have room for high rows
_NAMED = 24  # characters of a case's name that have room


def validation_figure(validation: Validation, units: Units = "si") -> Figure:
    """Intervals across, one row per speed.

    Args:
        validation: validation whose scores are plotted.
        units: "si" or "us".

    Returns:
        The figure.
    """
    unit = unit_of("speed", units)
    scores = [score for score in validation.scores if score.truth is not None]
    with mpl.rc_context(drawing.STYLE):
        row_height = 0.36 if len(scores) <= _FEW else 0.2  # inches
        figure = drawing.new_figure(7.2, 1.3 + row_height * max(2, len(scores)))
        axes = figure.subplots()
        if not scores:
            drawing.nothing_here(axes, "no case was finished")
            return figure
        for row, score in enumerate(scores):
            truth = (score.truth or 0.0) / unit.worth
            axes.plot(truth, row, "D", ms=5, color=drawing.ORANGE, mec=drawing.INK, zorder=4)
            for speed in score.published.values():
                axes.plot(speed / unit.worth, row, "v", ms=6, color="white", mec=drawing.INK)
            if not score.counts or score.answer is None:
                axes.annotate(
                    "withheld" if score.answer else "no answer",
                    (truth, row), xytext=(8, -3), textcoords="offset points", color=drawing.GREY,
                )  # fmt: skip
                continue
            for level, width in _BARS.items():
                bounds = [bound / unit.worth for bound in score.answer.intervals[level]]
                axes.plot(bounds, [row, row], lw=width, color=drawing.BLUE, solid_capstyle="butt")
            median = score.answer.median / unit.worth
            axes.plot([median] * 2, [row - 0.16, row + 0.16], color="white", lw=1.4)
        names = [f"{s.case[:_NAMED]}, {s.quantity[-1:].upper()}" for s in scores]
        axes.set_yticks(range(len(scores)), [name.replace("$", r"\$") for name in names])
        axes.set_ylim(len(scores) - 0.5, -0.5)
        axes.set_xlim(left=0)
        axes.grid(axis="x", color=drawing.PALE, lw=0.5)
        axes.set_axisbelow(True)
        axes.set_xlabel(f"speed before impact ({unit.symbol})")
        figure.legend(handles=_legend(), loc="outside lower center", ncols=5)
    return figure


def _legend() -> list[Line2D]:
    bars = [
        Line2D([], [], color=drawing.BLUE, lw=width, label=f"{level} %")
        for level, width in _BARS.items()
    ]
    true = Line2D([], [], ls="", marker="D", color=drawing.ORANGE, mec=drawing.INK)
    true.set_label("measured")
    others = Line2D([], [], ls="", marker="v", color="white", mec=drawing.INK)
    others.set_label("reconstructed by others")
    return [*bars, true, others]


def errors_figure(validation: Validation) -> Figure:
    """Errors over sd by kind of case, and how the shares of draws below the truth are distributed.

    Args:
        validation: validation whose answers that count are plotted.

    Returns:
        The figure.
    """
    counted = [score for score in validation.scores if score.standardised is not None]
    with mpl.rc_context(drawing.STYLE):
        figure = drawing.new_figure(7.2, 3.2)
        left, right = figure.subplots(1, 2, width_ratios=(1.3, 1))
        if not counted:
            for axes in (left, right):
                drawing.nothing_here(axes, "no case was answered")
            return figure
        _plot_errors(left, counted)
        _plot_shares(right, [score.below for score in counted if score.below is not None])
    return figure


def _plot_errors(axes: Axes, scores: list[Score]) -> None:
    kinds = list(dict.fromkeys(score.groups.get("kind", "case") for score in scores))
    axes.axvspan(-1.645, 1.645, color=drawing.PALE, lw=0)
    axes.axvline(0, color=drawing.GREY, lw=0.8)
    for row, kind in enumerate(kinds):
        errors = sorted(
            score.standardised or 0.0
            for score in scores
            if score.groups.get("kind", "case") == kind
        )
        # spread over the row, in order, so that none hides another
        places = row + np.linspace(-0.3, 0.3, len(errors)) if len(errors) > 1 else [row]
        axes.plot(errors, places, "o", ms=4, color=drawing.BLUE, mec="white", mew=0.5)
    axes.set_yticks(range(len(kinds)), kinds)
    axes.set_ylim(len(kinds) - 0.5, -0.5)
    widest = max(3.0, 1.1 * max(abs(score.standardised or 0.0) for score in scores))
    axes.set_xlim(-widest, widest)
    axes.set_xlabel("error of the median over sd")


def _plot_shares(axes: Axes, shares: list[float]) -> None:
    from scipy.stats import kstwo

    axes.set_xlabel("share of draws below the truth")
    axes.set_ylabel("share of speeds")
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    if not shares:
        return
    grid, n = np.linspace(0, 1, 101), len(shares)
    off = float(kstwo.ppf(0.95, n))
    axes.fill_between(
        grid, np.clip(grid - off, 0, 1), np.clip(grid + off, 0, 1), color=drawing.PALE, lw=0
    )
    axes.plot([0, 1], [0, 1], color=drawing.GREY, lw=0.8)
    steps = np.array([0.0, *sorted(shares), 1.0])
    axes.step(steps, [*(np.arange(n + 1) / n), 1.0], where="post", color=drawing.BLUE)
