"""The common parts of the figures: size, colours, mark of a failed run, and plots of draws.

Figures are drawn with matplotlib directly and not with ArviZ's plots: they need units, fixed
panels, line styles that survive a greyscale printer, and the mark of a failed run.
"""

from __future__ import annotations

import functools
import io
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Concatenate

import matplotlib as mpl
import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imsave
from matplotlib.layout_engine import ConstrainedLayoutEngine

from retrodict.scene import quantities
from retrodict.scene.quantities import REPORTED, Unit, Units, unit_of

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

DPI = 200
_MARGIN = 16  # pixels of white about what is drawn
STEPS = [1, 2, 5, 10]  # between ticks, times a power of ten
# Okabe and Ito's palette, safe for the colour-blind; dark and light enough apart in grey
INK, GREY, PALE = "#222222", "#777777", "#d9d9d9"
BLUE, ORANGE = "#0072B2", "#D55E00"
OF_VEHICLE = {"a": BLUE, "b": ORANGE}
LINE_OF_VEHICLE = {"a": "-", "b": (0, (4, 1.5))}
_DOTS, _FOR_DENSITY, _GRID = 500, 1000, 45  # of a cloud: dots, draws for its density, grid side
SHORT = {k: re.sub(r"_(\w)", r"$_\1$", label) for k, label in quantities.SHORT.items()}

STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "hatch.linewidth": 0.4,
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
}
# drawn around texts that stand on lines
HALO = [patheffects.withStroke(linewidth=2.5, foreground="white")]


def styled[**P](
    draw: Callable[Concatenate[Findings, Outcome, Units, P], Figure],
) -> Callable[Concatenate[Findings, Outcome, Units, P], Figure]:
    """A figure's function made to draw in the common style, under a banner where checks failed.

    Args:
        draw: function of the findings of a reconstruction, its outcome with the draws, and the units,
            "si" or "us"; returns the figure. One that draws what is in the findings leaves the outcome.
    """

    @functools.wraps(draw)
    def drawn(
        findings: Findings,
        outcome: Outcome,
        units: Units = "si",
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> Figure:
        from retrodict.findings.sentences import NOT_TO_BE_RELIED_ON

        with mpl.rc_context(STYLE):
            figure = draw(findings, outcome, units, *args, **kwargs)
            if not findings.checks.passed:
                # the style's banner is a title of the figure, which its layout makes room for
                figure.suptitle(
                    f"{NOT_TO_BE_RELIED_ON}: checks of the draws failed",
                    color="white",
                    weight="bold",
                    size=10,
                    bbox={
                        "facecolor": "#b00000",
                        "edgecolor": "none",
                        "boxstyle": "square,pad=0.4",
                    },
                )
            return figure

    return drawn


class _Drawing(Figure):
    """A figure that a notebook shows; it shows matplotlib's own once pyplot was imported."""

    def _repr_png_(self) -> bytes:
        return to_png(self)


def new_figure(width: float, height: float) -> Figure:
    """An empty figure (inches) that belongs to no window and lays itself out."""
    layout = ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06)
    return _Drawing(figsize=(width, height), layout=layout, facecolor="white")


def to_png(figure: Figure) -> bytes:
    """A figure as a PNG image, with a narrow margin about what is drawn."""
    # savefig's tight box does the same, but lays out and draws every figure twice
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())
    drawn = pixels.view(np.uint32)[..., 0] != np.uint32(0xFFFFFFFF)  # not white
    for axis in (0, 1):
        found = np.flatnonzero(drawn.any(axis=1 - axis))
        if found.size:
            pixels = pixels.take(range(found[0], found[-1] + 1), axis=axis)
    margin = ((_MARGIN, _MARGIN), (_MARGIN, _MARGIN), (0, 0))
    pixels = np.pad(pixels, margin, constant_values=255)
    buffer = io.BytesIO()
    # level 3 is twice as fast as the default, for images a tenth larger
    imsave(buffer, pixels, format="png", dpi=DPI, pil_kwargs={"compress_level": 3})
    return buffer.getvalue()


def to_svg(figure: Figure) -> bytes:
    """A figure as an SVG drawing; equal figures give equal bytes."""
    buffer = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "retrodict"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def to_pdf(figure: Figure) -> bytes:
    """A figure as a PDF page; equal figures give equal bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="pdf", metadata={"CreationDate": None})
    return buffer.getvalue()


# functions that encode a figure, by file suffix
IMAGES: dict[str, Callable[[Figure], bytes]] = {".png": to_png, ".svg": to_svg, ".pdf": to_pdf}


def shown(findings: Findings) -> tuple[str, ...]:
    """The quantities whose marginals are drawn, in their order."""
    return tuple(name for name in SHORT if name in findings.scene.reported())


def axis_label(name: str, units: Units) -> str:
    """A quantity's axis label with its unit."""
    unit = unit_of(REPORTED[name][1], units)
    return f"{SHORT[name]} ({unit.symbol})" if unit.symbol else SHORT[name]


def worth(name: str, units: Units) -> Unit:
    """The unit that a reported quantity is drawn in."""
    return unit_of(REPORTED[name][1], units)


def density(values: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """A smooth density of draws, corrected at bounds; None where they do not vary."""
    if values.size < 10 or np.ptp(values) <= 0:
        return None
    from arviz_stats.base import array_stats  # a plan of a scene does not wait for it

    grid, height, _ = array_stats.kde(values)
    return grid, height


def cloud(axes: Axes, x: np.ndarray, y: np.ndarray, colour: str) -> None:
    """Draws of two quantities, thinned, and the smallest regions that hold 50 and 90 % of them."""
    from scipy.stats import gaussian_kde  # a plan of a scene does not wait for it

    thin = np.linspace(0, x.size - 1, min(_DOTS, x.size)).astype(int)
    axes.plot(x[thin], y[thin], ".", color=GREY, ms=2.2, alpha=0.5, mew=0)
    some = np.linspace(0, x.size - 1, min(_FOR_DENSITY, x.size)).astype(int)
    points = np.stack([x[some], y[some]])
    try:
        kernel = gaussian_kde(points)
    except (np.linalg.LinAlgError, ValueError):
        return  # the draws lie on a line or are too few: the dots say all there is
    # no density is drawn beyond the draws, so that none seems to lie past a bound
    low, high = points.min(axis=1), points.max(axis=1)
    mesh = np.meshgrid(*np.linspace(low, high, _GRID).T)
    height = kernel(np.stack([m.ravel() for m in mesh])).reshape(_GRID, _GRID)
    # the region of highest density that holds 90 % is where density exceeds its 10 % quantile
    at_90, at_50 = np.quantile(kernel(points), [0.1, 0.5])
    if at_90 < at_50 < height.max():
        axes.contour(
            *mesh, height, [at_90, at_50], colors=colour, linestyles=["--", "-"],
            linewidths=[1.2, 1.6],
        )  # fmt: skip


def nothing_here(axes: Axes, what: str) -> None:
    """Say in an otherwise empty panel that there is nothing to draw."""
    axes.set_axis_off()
    axes.text(0.5, 0.5, what, ha="center", va="center", color=GREY, transform=axes.transAxes)
