"""The chart: error of the rest pose against what it costs."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from benchmarks.integrators.rows import BATCHED, POSITION, WORST, Row, by_set, p99
from benchmarks.integrators.solvers import DEFAULT, INFERENCE

LOOKS = {
    DEFAULT: ("#000000", "*"),
    "W, RK4": ("#0072B2", "o"),
    "W, RK4, in turn": ("#56B4E9", "P"),
    "W, Tsit5": ("#D55E00", "s"),
    "W, Tsit5, in turn": ("#E69F00", "v"),
    "W, Dopri8, in turn": ("#009E73", "^"),
    "time, Tsit5, event, in turn": ("#CC79A7", "D"),
    "time, Tsit5, regularised, in turn": ("#882255", "d"),
    "time, SciPy RK45": ("#555555", "x"),
    "time, SciPy DOP853": ("#555555", "+"),
}
Error = Callable[[np.ndarray], Any]


def _curve(axes: Axes, rows: Sequence[Row], cost: str, error: Error, linestyle: str) -> None:
    for name, (colour, marker) in LOOKS.items():
        mine = [row for row in rows if row.method == name and getattr(row, cost) > 0]
        x, y = [getattr(row, cost) for row in mine], [error(row.position) for row in mine]
        look: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": linestyle}
        if linestyle != "-":
            look["markerfacecolor"] = "white"
        axes.plot(x, y, markersize=8 if marker == "*" else 5, linewidth=1.2, **look)
    for row in rows:
        if row.mark:
            at = (getattr(row, cost), error(row.position))
            axes.plot(*at, "o", markersize=12, markerfacecolor="none", color="black")
            text = row.setting.split()[0] if row.method == "W, RK4" else "rest"
            if linestyle != ":":
                axes.annotate(text, at, (7, 5), textcoords="offset points", fontsize=9)


def draw(rows: Sequence[Row], file: Path, below: Sequence[str]) -> None:
    """Error against cost, a row a set of scenes: batched twice, then singly and with Jacobian."""
    sets = by_set(rows)
    figure = Figure(figsize=(16, 3.9 * len(sets) + 2.2), layout="constrained")
    panels = figure.subplots(len(sets), 3, squeeze=False)
    for (name, mine), (left, middle, right) in zip(sets.items(), panels, strict=True):
        number = max(len(row.of) for row in mine)
        _curve(left, mine, "batched", np.median, "-")
        _curve(middle, mine, "batched", p99, "--")
        _curve(middle, mine, "batched", np.max, ":")
        _curve(right, mine, "single", np.median, "-")
        _curve(right, mine, "jacobian", np.median, "--")
        left.set_title(f"{name} ({number} scenes), batched: median", loc="left", fontsize=10)
        middle.set_title("batched: dashed p99, dotted worst", loc="left", fontsize=10)
        right.set_title("median: solid singly, dashed with Jacobian", loc="left", fontsize=10)
        for axes in (left, middle, right):
            axes.axhline(POSITION, color="#777777", linewidth=0.8, linestyle=":")
            axes.set(xscale="log", yscale="log", xlabel="µs a scene")
            axes.grid(which="major", color="#d9d9d9", linewidth=0.5)
        for axes in (left, middle):
            axes.axvline(BATCHED, color="#777777", linewidth=0.8, linestyle=":")
        middle.axhline(WORST, color="#777777", linewidth=0.8, linestyle=":")
        left.set_ylabel("position error, mm")
    handles = [
        Line2D([], [], color=colour, marker=marker, label=name)
        for name, (colour, marker) in LOOKS.items()
    ]
    figure.legend(handles=handles, loc="outside right upper", fontsize=9, title="clock, solver")
    lines = [
        f"Circles: the defaults, of rest and of inference ({INFERENCE} steps). Dotted lines:"
        f" targets, {POSITION:.0f} mm for 99 %, {WORST:.0f} mm for the worst, {BATCHED:.0f} µs.",
        *below,
    ]
    text = "\n".join(textwrap.fill(line, 240, subsequent_indent="   ") for line in lines)
    figure.supxlabel(text, fontsize=8.5, x=0.01, ha="left")
    figure.savefig(file, dpi=120)
