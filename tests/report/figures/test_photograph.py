"""The photograph under the plan: where its pixels lie, and that a plan without one stays as it was."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from retrodict.report.figures.photograph import Photograph, under_plans
from retrodict.report.figures.scene import plan_figure
from retrodict.scene import load_scene

BRACH = Path(__file__).parents[3] / "examples" / "brach-1977" / "scene.toml"


def photograph(path: Path, turn: float = 0.0) -> Photograph:
    """400 by 300 pixels of 5 cm, all red but for a black quarter at the upper left."""
    pixels = np.full((300, 400, 3), (200, 0, 0), np.uint8)
    pixels[:150, :200] = 0
    Image.fromarray(pixels).save(path)
    return Photograph(path, "ab" * 32, 400, 300, 0.05, -10.0, 7.5, turn)


@pytest.mark.parametrize("turn", [0.0, math.radians(30)])
@pytest.mark.parametrize(("units", "worth"), [("si", 1.0), ("us", 0.3048)])
def test_every_pixel_lies_where_the_board_has_it(
    tmp_path: Path, turn: float, units: str, worth: float
) -> None:
    with under_plans(photograph(tmp_path / "ground.png", turn)):
        figure = plan_figure(load_scene(BRACH), units)
    axes = figure.axes[0]
    (image,) = axes.images
    on_plan = image.get_transform() - axes.transData
    left, right, bottom, top = image.get_extent()
    for corner, (u, w) in {
        (left, top): (0, 0),
        (right, top): (400, 0),
        (left, bottom): (0, 300),
    }.items():
        step = 0.05 * complex(u, -w) * complex(math.cos(turn), math.sin(turn))
        expected = (-10 + step.real) / worth, (7.5 + step.imag) / worth
        assert on_plan.transform(corner) == pytest.approx(expected)
    plain = plan_figure(load_scene(BRACH), units)
    assert len(plain.axes[0].images) == 0
    assert axes.get_xlim() == plain.axes[0].get_xlim()
    assert axes.get_ylim() == plain.axes[0].get_ylim()


def test_a_plan_says_which_photograph_lies_under_it(tmp_path: Path) -> None:
    with under_plans(photograph(tmp_path / "ground.png")):
        figure = plan_figure(load_scene(BRACH))
    assert any("SHA-256 abababab" in text for text in _texts(figure))


def test_a_photograph_that_cannot_be_read_leaves_the_plan_white(tmp_path: Path) -> None:
    broken = photograph(tmp_path / "ground.png")
    broken.path.write_bytes(b"\x89PNG\r\n\x1a\n")
    with under_plans(broken):
        figure = plan_figure(load_scene(BRACH))
    assert len(figure.axes[0].images) == 0


def _texts(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.axes[0].texts]
