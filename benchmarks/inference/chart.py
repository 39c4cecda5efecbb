"""The chart: errors of mean, sd and limits against seconds."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from benchmarks import competitors
from benchmarks.inference.cost import SCENES, Point

LOOKS = {
    "nuts": ("#000000", "*"),
    "importance": ("#0072B2", "o"),
    "smc": ("#56B4E9", "P"),
    "laplace": ("#009E73", "^"),
    "monte-carlo": ("#E69F00", "v"),
    "linear": ("#CC79A7", "D"),
    competitors.DEFAULT_NAME: ("#D55E00", "s"),
    competitors.DENSE_NAME: ("#D55E00", "d"),
    competitors.BLACKJAX_NAME: ("#8B0000", "h"),
    competitors.EMCEE_NAME: ("#555555", "x"),
    competitors.SCIPY_NAME: ("#555555", "+"),
}


def draw(points: Sequence[Point], file: Path, below: Sequence[str]) -> None:
    """Errors of mean, sd and limits against seconds, a row a scene."""
    figure = Figure(figsize=(16, 11), layout="constrained")
    panels = figure.subplots(len(SCENES), 3, sharex=True)
    for scene, row in zip(SCENES, panels, strict=True):
        for axes, what in zip(row, ("mean", "sd", "limits"), strict=True):
            for method, (colour, marker) in LOOKS.items():
                mine = [p for p in points if (p.scene, p.method) == (scene, method)]
                for part, style in ((False, "-"), (True, "--")):
                    chosen = [p for p in mine if p.extrapolated is part]
                    if part and chosen:  # from the last that was measured
                        chosen = [p for p in mine if not p.extrapolated][-1:] + chosen
                    x, y = [p.seconds for p in chosen], [getattr(p, what) for p in chosen]
                    look: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": style}
                    face = "white" if part else colour
                    axes.plot(x, y, linewidth=1.2, markersize=6, markerfacecolor=face, **look)
            axes.set(xscale="log", yscale="log", xlabel="seconds of sampling")
            title = {"limits": "95 % limits"}.get(what, what)
            axes.set_title(f"{scene}: error of the {title}", loc="left", fontsize=10)
            axes.grid(which="major", color="#d9d9d9", linewidth=0.5)
        row[0].set_ylabel("worst of four quantities, posterior sd")
    handles = [
        Line2D([], [], color=colour, marker=marker, label=name)
        for name, (colour, marker) in LOOKS.items()
    ]
    figure.legend(handles=handles, loc="outside upper center", fontsize=9, ncols=4)
    text = "\n".join(textwrap.fill(line, 230, subsequent_indent="   ") for line in below)
    figure.supxlabel(text, fontsize=8.5, x=0.01, ha="left")
    figure.savefig(file, dpi=120)
