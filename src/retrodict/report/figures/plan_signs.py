"""The signs of a map that the plan of a scene has: names, scale, axes, and where the road rises."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Rectangle

from retrodict.report.figures import drawing
from retrodict.scene.records import Scene


def scale_bar(axes: Axes, view: tuple[float, float, float, float], symbol: str) -> None:
    """A length in the printed unit, in the lower left corner."""
    width = view[1] - view[0]
    fits = [step * 10.0**k for k in range(-1, 5) for step in (1, 2, 5) if step * 10**k < width / 4]
    length = max(fits, default=1.0)
    x = view[0] + 0.03 * width
    y = view[2] + 0.03 * width
    _on_white(axes, (x - 0.012 * width, y - 0.015 * width), length + 0.024 * width, 0.06 * width)
    axes.plot([x, x + length], [y, y], color=drawing.INK, lw=2.5, solid_capstyle="butt", zorder=10)
    axes.text(
        x + length / 2, y + 0.008 * width, f"{length:g} {symbol}", ha="center", va="bottom",
        zorder=10, path_effects=drawing.HALO,
    )  # fmt: skip


def compass(axes: Axes, view: tuple[float, float, float, float]) -> None:
    """The scene's axes, in the upper right corner."""
    reach = 0.07 * (view[1] - view[0])
    x, y = view[1] - 1.7 * reach, view[3] - 1.7 * reach
    _on_white(axes, (x - 0.2 * reach, y - 0.2 * reach), 1.7 * reach, 1.7 * reach)
    look: dict[str, Any] = {"ha": "center", "va": "center", "zorder": 10}
    for name, (along_x, along_y) in {"x": (reach, 0.0), "y": (0.0, reach)}.items():
        arrow = FancyArrowPatch(
            (x, y), (x + along_x, y + along_y), arrowstyle="-|>", mutation_scale=8,
            color=drawing.INK, lw=1.2, shrinkA=0, shrinkB=0, zorder=10,
        )  # fmt: skip
        axes.add_patch(arrow)
        axes.text(x + 1.25 * along_x, y + 1.25 * along_y, name, **look)


def uphill(axes: Axes, scene: Scene, view: tuple[float, float, float, float]) -> None:
    """The direction in which the road rises, and its grade, in the upper left corner."""
    if scene.slope is None:
        return
    reach = 0.07 * (view[1] - view[0])
    x, y, turn = view[0] + 1.2 * reach, view[3] - 1.2 * reach, scene.slope.uphill.value
    along = np.array([np.cos(turn), np.sin(turn)]) * reach / 2
    _on_white(axes, (x - reach, y - 1.2 * reach), 2 * reach, 2 * reach)
    arrow = FancyArrowPatch(
        (x - along[0], y - along[1]), (x + along[0], y + along[1]), arrowstyle="-|>",
        mutation_scale=8, color=drawing.INK, lw=1.2, shrinkA=0, shrinkB=0, zorder=10,
    )  # fmt: skip
    axes.add_patch(arrow)
    text = f"uphill {100 * scene.slope.grade.value:.2g} %"
    axes.text(x, y - 0.6 * reach, text, ha="center", va="top", zorder=10)


def write_name(axes: Axes, place: np.ndarray, text: str, colour: str = drawing.INK) -> None:
    """Write what a thing is beside it; nothing of it reaches beyond the axes."""
    axes.text(
        float(place[0]), float(place[1]), text, color=colour, size=8, ha="center", va="center",
        zorder=9.2, path_effects=drawing.HALO, clip_on=True,
    )  # fmt: skip


def _on_white(axes: Axes, corner: tuple[float, float], width: float, height: float) -> None:
    """A white ground, so that no hatch runs through what is drawn on it."""
    axes.add_patch(Rectangle(corner, width, height, fc="white", ec="none", alpha=0.85, zorder=9.5))
