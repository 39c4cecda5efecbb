"""A calibration: how far the ranks of each quantity lie from uniform, with simultaneous bands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.figure import Figure

from retrodict.report.figures import drawing
from retrodict.scene.quantities import REPORTED

if TYPE_CHECKING:
    from retrodict.studies.calibration import Calibration

CAPTION = (
    "Each panel is a quantity. The line is the share of simulations whose truth lies at or below a "
    "cumulative probability of the posterior, less that probability; a perfect method stays near "
    "nought. 95 % of calibrated methods stay everywhere within the grey band. A line that rises "
    "first and falls then shows true values that lie too low; one that rises at both ends and falls "
    "between shows posteriors that are too narrow."
)
_COLUMNS = 4


def calibration_figure(calibration: Calibration) -> Figure:
    """ECDF of ranks less the diagonal, one panel per quantity.

    Args:
        calibration: calibration whose ranks are plotted.

    Returns:
        The figure.
    """
    from retrodict.studies.uniformity import uniformity  # brings JAX

    found = uniformity(calibration)
    with mpl.rc_context(drawing.STYLE):
        lines = max(1, -(-len(found) // _COLUMNS))
        figure = drawing.new_figure(7.2, 0.7 + 1.7 * lines)
        panels = figure.subplots(lines, _COLUMNS, sharex=True, sharey=True, squeeze=False).ravel()
        if not found:
            drawing.nothing_here(panels[0], "too few ranks to decide")
        for axes, (name, each) in zip(panels, found.items(), strict=False):
            axes.fill_between(each.at, *each.band, step="post", color=drawing.PALE, lw=0)
            color, style = (drawing.BLUE, "-") if each.inside else (drawing.ORANGE, "--")
            axes.plot(each.at, each.difference, color=color, ls=style, lw=1, drawstyle="steps-post")
            axes.axhline(0, color=drawing.GREY, lw=0.5)
            label = REPORTED[name][0] if name in REPORTED else "log likelihood"
            label = drawing.SHORT.get(name, label.replace(" before impact", ""))
            axes.set_title(label, size=8)
            axes.set_xticks([0, 0.5, 1])
        for axes in panels[len(found) :]:
            axes.set_axis_off()
        figure.supxlabel("cumulative probability of the posterior", size=8.5)
        figure.supylabel("share of truths below, less it", size=8.5)
        figure.suptitle(
            f"{calibration.model}, {calibration.method}: {len(calibration.ranked)} simulations",
            size=9,
        )
        return figure
