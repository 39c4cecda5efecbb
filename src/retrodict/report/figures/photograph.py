"""A photograph of the ground under the plan of a scene, such as a drone's, where its scale is known.

It belongs to no scene file: who draws the figures says which photograph lies under them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Affine2D

from retrodict.report.figures import drawing

_ACROSS = 2400  # pixels of a side, at most, that a page prints
_PALE = 0.6  # what is drawn stays the darkest
_DIGITS = 16  # of the digest


@dataclass(frozen=True, slots=True)
class Photograph:
    """A photograph that is to scale.

    Args:
        path: path of a PNG or JPEG image.
        sha256: digest of the photograph as it was brought.
        width: width of the image, pixels.
        height: height of the image, pixels.
        metres: length of a pixel on the ground, m.
        x: x coordinate of the image's upper left corner, m.
        y: y coordinate of the image's upper left corner, m.
        turn: angle by which the image is turned counter-clockwise about that corner, rad.
    """

    path: Path
    sha256: str
    width: int
    height: int
    metres: float
    x: float
    y: float
    turn: float


_UNDER: ContextVar[Photograph | None] = ContextVar("photograph", default=None)


@contextmanager
def under_plans(photograph: Photograph | None) -> Iterator[None]:
    """Draw every plan on a photograph, in this context.

    Args:
        photograph: photograph; None for white paper.
    """
    token = _UNDER.set(photograph)
    try:
        yield
    finally:
        _UNDER.reset(token)


def draw_photograph(axes: Axes, worth: float) -> bool:
    """Draw the photograph of this context on a plan, and which it is.

    Args:
        axes: axes of the plan, whose limits stay.
        worth: length of the printed unit, m.

    Returns:
        Whether there was one that could be read.
    """
    photograph = _UNDER.get()
    pixels = _pixels(photograph.path) if photograph else None
    if photograph is None or pixels is None:
        return False
    limits = axes.get_xlim(), axes.get_ylim()
    across = photograph.width * photograph.metres / worth
    down = photograph.height * photograph.metres / worth
    placed = Affine2D().rotate(photograph.turn)
    placed = placed.translate(photograph.x / worth, photograph.y / worth)
    axes.imshow(
        pixels,
        extent=(0.0, across, -down, 0.0),
        transform=placed + axes.transData,
        alpha=_PALE,
        zorder=0.05,
        interpolation="bilinear",
    )
    axes.set_xlim(*limits[0])
    axes.set_ylim(*limits[1])
    name = photograph.path.name.replace("$", r"\$")
    axes.text(
        0.995, 0.005, f"photograph {name}, SHA-256 {photograph.sha256[:_DIGITS]}…",
        transform=axes.transAxes, ha="right", va="bottom", size=6, color=drawing.INK,
        path_effects=drawing.HALO, zorder=9.5,
    )  # fmt: skip
    return True


def _pixels(path: Path) -> np.ndarray | None:
    """The image, no larger than a page prints; None where it cannot be read."""
    from PIL import Image

    try:
        with Image.open(path, formats=("PNG", "JPEG")) as image:
            image.draft("RGB", (_ACROSS, _ACROSS))  # a JPEG is decoded no larger than needed
            image.thumbnail((_ACROSS, _ACROSS))
            return np.asarray(image.convert("RGBA"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None
