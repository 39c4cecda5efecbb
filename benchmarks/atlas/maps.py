"""Where methods fail: heat maps over two parameters of a scene, each cell fine, flagged or wrong."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from retrodict.inference import Unanswerable
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.plan import ways
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.records import Scene
from tests.shared.known_truth import made
from tests.shared.posteriors import draw, faults, off, sites

ASKED = ("speed_b", "e", "e_m", "mu")
SHOWN = ("nuts", "importance", "laplace", "linear")
CHAINS, WARMUP = 4, 150  # as `reconstruct` has them
LONG = 5000  # draws a chain of the longer importance run
WRONG = 0.25  # posterior sd: by which a mean may be off, and a sd, relative
STATES = ("fine", "flagged", "wrong", "unknown")
COLOURS = ("#009E73", "#F0E442", "#D55E00", "#DDDDDD")

Array = np.ndarray


class Cell(NamedTuple):
    """A method on a scene.

    Args:
        scenes: the map's name.
        method: of inference.
        x, y: the scene's parameters.
        state: fine, flagged, wrong (and not flagged), or unknown: no reference.
        error: of mean or sd, the worst of four quantities, in posterior sd; nan without reference.
        why: what it was flagged for.
    """

    scenes: str
    method: str
    x: float
    y: float
    state: str
    error: float
    why: str


class Map(NamedTuple):
    """Two parameters of `made`.

    Args:
        name: of the map.
        y_name: of the second.
        x, y: values; the first is a factor on all speeds.
        arguments: their names in `made`; a turn is given in degrees.
        truth: the true value that stands for x in the figure, and x_label its name.
    """

    name: str
    y_name: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    arguments: tuple[str, str]
    truth: str  # the true value that stands for x
    x_label: str


MAPS = (
    Map(
        "spin and friction",
        "friction's relative sd",
        (0.1, 0.4, 1.0),
        (0.01, 0.1, 0.6),
        ("speed", "friction_sd"),
        "spin",
        "spin of B after the impact, rad/s",
    ),
    Map(
        "closing speed and Gamma",
        "contact line turned by, deg",
        (0.1, 0.4, 1.0),
        (-60.0, 0.0, 60.0),
        ("speed", "turn"),
        "closing",
        "closing speed without the turn, m/s",
    ),
)


def judge(scene: Scene) -> Iterator[tuple[str, str, float, str]]:
    """Each method on a scene, in its coordinates: its name, state, error, and what it was flagged for.

    The reference of nuts is a longer importance run, that of the others nuts; where a reference is
    itself flagged, the other takes its place.
    """
    prepared = cache(partial(prepare, scene, DEFAULT_RUNG))  # methods share coordinates
    x, held, raised = {}, {}, set()
    for name in (*SHOWN, "long"):
        long = name == "long"
        method = "importance" if long else name
        try:
            posterior = prepared(ways(method, scene)[0].coordinates)
            drawn = draw(posterior, method, LONG if long else None, int(long))
            x[name] = sites(posterior, drawn)
            held[name] = faults(posterior, drawn, x[name])
        except Unanswerable as refusal:
            held[name] = [str(refusal)]
        except (ValueError, IndexError) as error:  # LinAlgError is one
            raised.add(name)
            held[name] = [f"traceback: {error}"]
    for method in SHOWN:
        # importance is not judged by itself, however long
        others = ("nuts",) if method == "importance" else ("nuts", "long")
        sure = [r for r in others if r != method and not held[r]]
        error = off(x[method], x[sure[0]]) if sure and method in x else np.nan
        if held[method]:
            state = "wrong" if method in raised else "flagged"
        elif not sure:
            state = "unknown"
        else:
            state = "wrong" if error > WRONG else "fine"
        yield method, state, error, "; ".join(held[method])


def cells(chosen: Map, every: int = 1) -> Iterator[Cell]:
    """All cells of a map, or of every so manyth row and column."""
    first, second = chosen.arguments
    for x in chosen.x[::every]:
        for y in chosen.y[::every]:
            degree = np.pi / 180 if second == "turn" else 1.0
            scene, truth = made(**{first: x, second: y * degree})  # type: ignore[arg-type]
            for method, state, error, why in judge(replace(scene, title="A cell")):
                yield Cell(chosen.name, method, round(truth[chosen.truth], 3), y, state, error, why)


def picture(found: list[Cell], file: Path) -> None:
    """A row a map, a column a method; a number is the worst error in posterior sd."""
    figure = Figure(figsize=(15, 8), layout="constrained")
    panels = figure.subplots(len(MAPS), len(SHOWN), squeeze=False)
    for chosen, row in zip(MAPS, panels, strict=True):
        for method, axes in zip(SHOWN, row, strict=True):
            mine = [c for c in found if (c.scenes, c.method) == (chosen.name, method)]
            _panel(axes, chosen, mine)
            axes.set_title(method, loc="left", fontsize=10)
    handles = [Patch(color=c, label=s) for c, s in zip(COLOURS, STATES, strict=True)]
    figure.legend(handles=handles, loc="outside upper center", ncols=len(STATES), fontsize=10)
    figure.supxlabel(
        f"wrong: not flagged, and a mean off by over {WRONG} posterior sd or a sd by over {WRONG:.0%}; "
        "numbers: the worst of speed of B, e, e_m, μ.",
        fontsize=9,
    )
    figure.savefig(file, dpi=120)


def _panel(axes: Any, chosen: Map, mine: list[Cell]) -> None:
    """Cells in the order they were made: x by x."""
    ys = list(dict.fromkeys(c.y for c in mine))
    columns = [mine[i : i + len(ys)] for i in range(0, len(mine), len(ys))]
    states = np.array([[STATES.index(c.state) for c in column] for column in columns]).T
    axes.imshow(states, origin="lower", cmap=ListedColormap(COLOURS), vmin=0, vmax=3, aspect="auto")
    for i, column in enumerate(columns):
        for j, c in enumerate(column):
            text = "" if np.isnan(c.error) else f"{c.error:.2g}" if c.error < 100 else "> 99"
            axes.text(i, j, text, ha="center", va="center", fontsize=8)
    middle = [column[len(ys) // 2].x for column in columns]
    axes.set_xticks(range(len(columns)), [f"{x:.2g}" for x in middle])
    axes.set_yticks(range(len(ys)), [f"{y:g}" for y in ys])
    axes.set_xlabel(chosen.x_label, fontsize=8)
    axes.set_ylabel(chosen.y_name, fontsize=8)
