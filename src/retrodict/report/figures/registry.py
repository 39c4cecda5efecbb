"""The figures: a new one is a module of its own and one line in `FIGURES`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from retrodict.report.figures import (
    delta_v,
    pair,
    posterior,
    predictive,
    scene,
    timeline,
    tornado,
)
from retrodict.report.figures.drawing import to_png, to_svg
from retrodict.scene.quantities import Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome


@dataclass(frozen=True, slots=True)
class Registered:
    """A figure of the report.

    Args:
        draw: function that draws the figure, under `drawing.styled`.
        title: short title.
        caption: explanation of what is drawn, and how to read it.
        beside: key of the section that the figure stands in: "first page", "results", "evidence" or
            "sensitivity".
        svg: whether the figure is saved as an SVG drawing too, for editing.
    """

    draw: Callable[[Findings, Outcome, Units], Figure]
    title: str
    caption: str
    beside: str = "results"
    svg: bool = False


# in the order of the report; the key is the file's name
FIGURES: dict[str, Registered] = {
    "scene": Registered(scene.scene_figure, "The scene", scene.CAPTION, "first page", svg=True),
    "delta_v": Registered(
        delta_v.delta_v_figure, "Delta-v and direction of force", delta_v.CAPTION
    ),
    "posterior": Registered(posterior.posterior_figure, "The unknowns", posterior.CAPTION),
    "pair": Registered(
        pair.pair_figure, "Correlations between the unknowns", pair.CAPTION, "sensitivity"
    ),
    "predictive": Registered(
        predictive.predictive_figure, "Fit to the evidence", predictive.CAPTION, "evidence"
    ),
    "tornado": Registered(
        tornado.tornado_figure, "The effect of each measurement", tornado.CAPTION, "sensitivity"
    ),
}
# figures that are drawn only where a question asks for them; keys as above
ASKED: dict[str, Registered] = {
    "timeline": Registered(
        timeline.timeline_figure,
        "Times and distances before the impact",
        timeline.CAPTION,
        "results",
    ),
}


def figures_of(findings: Findings) -> dict[str, Registered]:
    """The figures of a report: `FIGURES`, and those that its questions ask for."""
    asked = {each.figure for each in findings.questions}
    return FIGURES | {name: figure for name, figure in ASKED.items() if name in asked}


def images(findings: Findings, outcome: Outcome, units: Units = "si") -> dict[str, bytes]:
    """Figures as PNG images.

    Args:
        findings: findings of the reconstruction.
        outcome: outcome of the reconstruction, with its draws.
        units: "si" or "us".

    Returns:
        The images by name, in the order of the report.
    """
    return {
        name: to_png(figure.draw(findings, outcome, units))
        for name, figure in figures_of(findings).items()
    }


def svgs(findings: Findings, outcome: Outcome, units: Units = "si") -> dict[str, bytes]:
    """SVG drawings of the figures that are saved as SVG too; arguments as in `images`.

    Returns:
        The drawings by name.
    """
    chosen = {name: figure for name, figure in FIGURES.items() if figure.svg}
    return {n: to_svg(figure.draw(findings, outcome, units)) for n, figure in chosen.items()}
