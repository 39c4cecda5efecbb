"""Staged collisions: each speed's intervals beside what was measured and what others found."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from retrodict.report.figures import drawing
from retrodict.scene.quantities import Units, unit_of

if TYPE_CHECKING:
    from retrodict.studies.validation import Validation

CAPTION = (
    "A row is a speed before impact. The bars are its central 95, 90 and 50 % intervals, thicker as "
    "they narrow; the white line is the median. The diamond is the speed that was measured, and "
    "triangles are what others reconstructed. Where an answer is withheld, none is drawn."
)
_BARS = {95: 1.2, 90: 4.0, 50: 9.0}  # widths, in points
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
        figure = drawing.new_figure(7.2, 1.3 + 0.36 * max(2, len(scores)))
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
