"""Which corners make an outline: laws of simple polygons."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from retrodict.scene.outlines import MOST_CORNERS, outline_fault


@pytest.mark.parametrize("seed", range(60))
def test_four_points_make_one_outline_in_convex_position_and_else_three(seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-50, 50, (4, 2))
    a, b, c, d = map(tuple, points.tolist())
    orders = ([a, b, c, d], [a, b, d, c], [a, c, b, d])
    outlines = sum(not outline_fault(each) for each in orders)
    assert outlines == (1 if len(ConvexHull(points).vertices) == 4 else 3)


@given(
    radii=st.lists(st.floats(1, 900), min_size=5, max_size=MOST_CORNERS),
    first=st.integers(0, 99),
    back=st.booleans(),
    pair=st.tuples(st.integers(0, 99), st.integers(2, 50)),
)
def test_a_star_is_an_outline_from_any_corner_either_way_round_and_in_no_other_order(
    radii: list[float], first: int, back: bool, pair: tuple[int, int]
) -> None:
    count = len(radii)
    star = [
        (r * math.cos(math.tau * i / count), r * math.sin(math.tau * i / count))
        for i, r in enumerate(radii)
    ]
    turned = star[first % count :] + star[: first % count]
    assert outline_fault(turned[::-1] if back else turned) == ""
    assert "again" in outline_fault([*star, star[first % count]]) or count == MOST_CORNERS
    # a round one, whose corners i and j are not neighbours, crosses itself with these exchanged
    circle = [
        (math.cos(math.tau * i / count), math.sin(math.tau * i / count)) for i in range(count)
    ]
    i = pair[0] % count
    j = (i + 2 + pair[1] % (count - 3)) % count
    circle[i], circle[j] = circle[j], circle[i]
    assert "meet" in outline_fault(circle)


@pytest.mark.parametrize(
    ("corners", "said"),
    [
        ([(0, 0), (1, 0)], "2 corners"),
        ([(0, 0), (4, 0), (2, 0)], "meet"),  # there and back
        ([(0, 0), (4, 0), (4, 4), (4, 2)], "meet"),  # a side that leads back along another
        ([(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)], "meet"),  # a corner on a side
        ([(0, 0), (4, 4), (4, 0), (0, 4)], "meet"),  # a bow tie
        ([(0, 0), (2, 2), (4, 4), (4, 0), (2, 2), (0, 4)], "corner 5 is corner 2 again"),
        ([(0, 0), (0.1, 0), (0, 0.1)], "less than 0.01 m²"),
    ],
)
def test_what_makes_no_outline(corners: list[tuple[float, float]], said: str) -> None:
    assert said in outline_fault(corners)
    assert said.partition(" ")[2] in outline_fault(corners[::-1])


def test_a_corner_on_a_straight_side_is_allowed() -> None:
    assert outline_fault([(0, 0), (2, 0), (4, 0), (4, 4)]) == ""
