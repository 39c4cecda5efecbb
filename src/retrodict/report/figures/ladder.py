"""The ladder of models: what each rung costs, and how far its answer lies from the fullest's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, SymmetricalLogLocator

from retrodict.report.figures import drawing

if TYPE_CHECKING:
    from retrodict.studies.comparison import Ladder, Step

CAPTION = (
    "Each mark is a rung of the ladder of models: across, the seconds that it took without "
    "compilation; up, how far its answer (the median) lies from that of the fullest rung that fits, "
    "in the latter's standard deviations, the most over the quantities asked; linear below the "
    "dashed line and logarithmic above. Dark marks are sufficient models: they fit the evidence, and "
    "every more complete sufficient model agrees with them. Light marks fit, but a more complete model "
    "disagrees. White marks do not fit, or their draws failed checks. The ring marks the chosen model; "
    "the dashed line is the largest accepted change of its answer."
)

_ENOUGH, _FITS, _WRONG = drawing.BLUE, drawing.PALE, "white"


def ladder_figure(ladder: Ladder) -> Figure:
    """Run time across, distance from the fullest fitting rung's answer up; one mark per rung.

    Args:
        ladder: results of every rung of the ladder of models.

    Returns:
        The figure.
    """
    ran = [step for step in ladder.steps if step.answers]
    with mpl.rc_context(drawing.STYLE):
        figure = drawing.new_figure(7.2, 4.0)
        axes = figure.subplots()
        if not ran:
            drawing.nothing_here(axes, "no rung was finished")
            return figure
        fullest = next((s for s in reversed(ran) if s.counts), ran[-1])
        for step in ran:
            place = (step.seconds or 0.0, distance(step, fullest))
            axes.plot(*place, "o", color=_colour(step), mec=drawing.INK)
            axes.annotate(step.name, place, xytext=(6, 4), textcoords="offset points", size=8)
            if step.name == ladder.choice:
                axes.plot(*place, "o", ms=13, mfc="none", mec=drawing.ORANGE, mew=1.8)
        axes.axhline(ladder.share, color=drawing.GREY, lw=0.8, ls=(0, (4, 2)))
        axes.set_xscale("log")
        axes.set_yscale("symlog", linthresh=ladder.share)
        top = max(ladder.share, *(distance(step, fullest) for step in ran))
        axes.set_ylim(-0.3 * ladder.share, 2 * top)
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_locator(
            SymmetricalLogLocator(base=10, linthresh=ladder.share, subs=(1, 2, 5))
        )
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter("{x:g}")
        axes.minorticks_off()
        axes.margins(x=0.25)
        axes.set_xlabel("seconds, without compilation")
        axes.set_ylabel("distance from the fullest rung's answer (its sd)")
        figure.legend(handles=_legend(), loc="outside lower center", ncols=4)
    return figure


def distance(step: Step, fullest: Step) -> float:
    """Largest distance of a median from the fullest rung's, in its sd, over the asked quantities."""
    return max(
        abs(answer.median - step.answers[name].median) / answer.sd
        for name, answer in fullest.answers.items()
    )


def _colour(step: Step) -> str:
    return _ENOUGH if step.enough else _FITS if step.counts else _WRONG


def _legend() -> list[Line2D]:
    colors = {
        "enough": _ENOUGH,
        "fits, not enough": _FITS,
        "does not fit, or not to be relied on": _WRONG,
    }
    marks = [
        Line2D([], [], ls="", marker="o", color=color, mec=drawing.INK, label=label)
        for label, color in colors.items()
    ]
    ring = Line2D([], [], ls="", marker="o", ms=10, mfc="none", mec=drawing.ORANGE, mew=1.8)
    ring.set_label("chosen")
    return [*marks, ring]
