"""The rectangle of a drawing holds what it shows, and an edge ends at the circle about it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retrodict.interchange.plan_drawing import (
    Drawing,
    Ellipse,
    Layer,
    Line,
    Point,
    edge_within,
    on_one_line,
)

BOUNDS = (-10.0, 30.0, -5.0, 25.0)  # of a circle of 25 m about (10, 10)


def test_bounds_hold_every_shape():
    shapes = (
        Line(np.array([[0.0, 1.0], [2.0, -3.0]])),
        Ellipse((5.0, 5.0), (2.0, 4.0)),
        Point((-1.0, 0)),
    )
    assert Drawing("", (Layer("L", "#222222", shapes),)).bounds == (-1.0, 7.0, -3.0, 9.0)


@given(x=st.floats(-100, 100), y=st.floats(-100, 100), direction=st.floats(-7, 7))
def test_an_edge_ends_on_the_circle_or_passes_it_by(x, y, direction):
    line = edge_within((x, y), direction, BOUNDS)
    along = np.array([np.cos(direction), np.sin(direction)])
    left = np.array([-along[1], along[0]])
    distance = abs((np.array([x, y]) - 10) @ left)
    if line is None:
        assert distance >= 25 - 1e-9
        return
    assert np.hypot(*(line.points - 10).T) == pytest.approx([25, 25])
    assert (line.points - [x, y]) @ left == pytest.approx([0, 0], abs=1e-6)  # on the edge
    assert (line.points[1] - line.points[0]) @ along >= 0  # in its direction


def test_one_line_has_no_breaks_and_nothing_that_steers_a_reader():
    assert on_one_line("a\r\nb\x1b[2J\u202eµ") == "a  b [2J µ"
