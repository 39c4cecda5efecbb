"""The chart: CPU seconds of each scene over those of the paper's example, and time by stage."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from benchmarks.users.runs import AGAIN, FIRST
from benchmarks.users.scores import PASSES, Score
from retrodict.report.figures import drawing

_COLOURS = {"passed": drawing.BLUE, "withheld": drawing.ORANGE}
_OTHER = drawing.GREY  # no numbers
_FACES = {FIRST: "white", AGAIN: None}  # of a mark
_STAGES = {
    "compile": drawing.INK,
    "sample": drawing.BLUE,
    "rest of the computation": "#56B4E9",
    "imports, figures and report": drawing.PALE,
    "no summary": drawing.GREY,
}


def draw(found: Sequence[Score], file: Path) -> None:
    """Ratios of both passes, and time by stage of the last, a line a scene.

    Args:
        found: scores of the scenes.
        file: picture to write.
    """
    ordered = sorted(found, key=lambda score: max(score.ratios.values(), default=0.0))
    with mpl.rc_context(drawing.STYLE):
        figure = drawing.new_figure(7.4, 1.6 + 0.17 * len(ordered))
        ratios, stages = figure.subplots(1, 2, sharey=True)
        for y, score in enumerate(ordered):
            for which in PASSES:
                if which in score.ratios:
                    row = score.rows[which]
                    colour = _COLOURS.get(row["verdict"], _OTHER)
                    look = ">" if row["verdict"] == "timed out" else "o"
                    face = _FACES[which] or colour
                    ratios.plot(score.ratios[which], y, look, ms=4, color=colour, mfc=face)
            left = 0.0
            for colour, width in zip(_STAGES.values(), _stages(score), strict=True):
                stages.barh(y, width, left=left, color=colour, height=0.7)
                left += width
        ratios.axvline(1, color=drawing.INK, lw=0.7)
        ratios.set_xscale("log")
        ratios.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        ratios.xaxis.set_major_formatter("{x:g}")
        ratios.minorticks_off()
        ratios.set_yticks(range(len(ordered)), [score.scene.name for score in ordered])
        ratios.set_ylim(-0.7, len(ordered) - 0.3)
        ratios.set_title("CPU seconds, ratio")
        ratios.set_xlabel("times the paper's example (hollow: first)")
        stages.axvline(1, color=drawing.INK, lw=0.7)
        stages.set_title("seconds by the clock, ratio, by stage")
        stages.set_xlabel("times the paper's example, again")
        marks = [
            Line2D([], [], marker="o", ls="", color=colour, label=name)
            for name, colour in (_COLOURS | {"no numbers": _OTHER}).items()
        ]
        bars = [Patch(color=colour, label=name) for name, colour in _STAGES.items()]
        figure.legend(handles=[*marks, *bars], loc="outside lower center", ncols=4)
        file.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(file)


def _stages(score: Score) -> list[float]:
    """Time of each stage in `_STAGES`, over that of the paper's whole command."""
    row = score.row
    wall = float(row["wall"])
    if not row["total"]:
        return [0.0, 0.0, 0.0, 0.0, wall / score.clock]
    total, compilation, sampling = (float(row[k] or 0) for k in ("total", "compile", "sample"))
    between = max(total - compilation - sampling, 0.0)
    outside = max(wall - compilation - sampling - between, 0.0)
    return [part / score.clock for part in (compilation, sampling, between, outside, 0.0)]
