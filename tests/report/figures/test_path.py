"""A run-out drawn from above, in its numbers and its units."""

import numpy as np
import pytest

from retrodict.mechanics import Car, Path
from retrodict.report.figures.path import plot_path

CAR = Car(1.8, 1.3, 1.5, 1.5)


@pytest.fixture
def path():
    """12 m straight ahead in 2 s, evenly slowed down."""
    time = np.linspace(0, 2, 41)
    x = 12 * time - 3 * time**2
    zero = np.zeros_like(x)
    velocity = np.stack([12 - 6 * time, zero, zero], axis=1)
    return Path(np.stack([x, zero, zero], axis=1), velocity, time)


def test_the_path_its_length_and_its_outlines_are_drawn(path):
    figure = plot_path(path, CAR, "us")
    axes = figure.axes[0]
    assert axes.get_xlabel() == "x (ft)"
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts[0] == "centre of gravity: 39.4 ft to rest (dot), in 2 s"
    assert texts[2] == "the wheels' outline every 0.5 s, front in bold"
    corners = [outline.vertices[:4] for outline in axes.collections[0].get_paths()]
    assert len(corners) == 5  # at 0, 0.5, 1, 1.5 and 2 s
    ends = np.array([[12 - 1.5, -0.75], [12 + 1.3, 0.75]])
    np.testing.assert_allclose([corners[-1].min(axis=0), corners[-1].max(axis=0)], ends / 0.3048)


def test_without_a_car_the_centre_of_gravity_is_drawn_alone(path):
    figure = plot_path(path)
    assert not figure.axes[0].collections
    assert len(figure.legends[0].get_texts()) == 1


def test_a_path_that_cannot_be_drawn_is_refused_in_a_line(path):
    with pytest.raises(ValueError, match=r"one run-out is drawn, of shape \(steps, 3\)"):
        plot_path(path._replace(pose=np.stack([path.pose, path.pose])))
    with pytest.raises(ValueError, match="did not reach rest"):
        plot_path(path._replace(pose=path.pose * np.nan))
