"""Where surfaces lie: polygons against matplotlib and half-planes."""

import jax.numpy as jnp
import numpy as np
import pytest
from matplotlib.path import Path

from retrodict.mechanics import Zone
from retrodict.mechanics.surface import TYRE_WIDTH, depth_in, friction

# an L with a slanting side
CORNERS = np.array([[0.0, 0], [6, 0], [7, 2], [2, 2], [2, 5], [0, 5]])
NOWHERE = Zone(jnp.zeros((0, 2)), jnp.zeros((0, 2)))


@pytest.mark.parametrize(
    "corners",
    [CORNERS, pytest.param(CORNERS[::-1], marks=pytest.mark.slow)],
    ids=["counter-clockwise", "clockwise"],
)
def test_depth_is_the_distance_to_the_outline(corners: np.ndarray) -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform([-3, -3], [10, 8], (4000, 2))
    found = np.array(depth_in(corners, points[:, 0], points[:, 1]))
    np.testing.assert_array_equal(found > 0, Path(corners).contains_points(points))
    outline = [
        a + t * (b - a)
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
        for t in np.linspace(0, 1, 2000)[:, None]
    ]
    nearest = [np.hypot(*(np.array(outline) - p).T).min() for p in points[:200]]
    np.testing.assert_allclose(np.abs(found[:200]), nearest, atol=5e-3)


@pytest.mark.slow
def test_a_wide_polygon_is_the_half_plane_of_its_side() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-1, 1, (2, 100))
    speed, f, c = rng.uniform(0, 10, 100), jnp.array([0.7, 0.4]), jnp.array([0.0, 0.01])
    half = Zone(jnp.array([[0.2, 0.0]]), jnp.array([[1.0, 0.0]]))
    wide = np.array([[0.2, -99.0], [99, -99], [99, 99], [0.2, 99]])
    np.testing.assert_allclose(
        friction(x, y, speed, f, c, NOWHERE, (wide,)),
        friction(x, y, speed, f, c, half),
        atol=1e-9,
    )


def test_later_surfaces_cover_earlier_ones() -> None:
    f = jnp.array([0.7, 0.4, 0.1])
    half = Zone(jnp.array([[0.0, 0.0]]), jnp.array([[1.0, 0.0]]))
    x, y = np.array([-2.0, 1.0, 3.0, 30.0]), np.array([1.0, 1.0, 1.0, 1.0])
    found = friction(x, y, np.ones(4), f, None, half, (CORNERS,))
    np.testing.assert_allclose(found, [0.7, 0.1, 0.1, 0.4], atol=1e-12)
    middle = friction(np.zeros(1), np.ones(1), np.ones(1), f[:2], None, half)
    assert float(middle[0]) == pytest.approx(0.55)
    off = friction(np.array([TYRE_WIDTH]), np.ones(1), np.ones(1), f[:2], None, half)
    assert float(off[0]) == pytest.approx(0.4)


@pytest.mark.parametrize("inset", [0.4, pytest.param(-0.4, marks=pytest.mark.slow)])
def test_an_inset_rectangle_is_the_one_whose_sides_lie_so_far_within(inset: float) -> None:
    rng = np.random.default_rng(2)
    sides = np.array([[0.0, 0.0], [8.0, 5.0]])
    whole, moved = (
        np.array([[a, b], [c, b], [c, d], [a, d]])
        for (a, b), (c, d) in (sides, sides + inset * np.array([[1], [-1]]))
    )
    x, y = rng.uniform([[-2], [-2]], [[10], [7]], (2, 4000))
    # beyond a corner an outline that lies further out is round
    near = np.hypot(*(np.stack([x, y], axis=1)[:, None] - moved).transpose(2, 0, 1)).min(axis=1)
    x, y = x[near > 0.5], y[near > 0.5]
    f = jnp.array([0.7, 0.2])
    found = friction(x, y, np.ones(len(x)), f, None, NOWHERE, (whole,), np.array([inset]))
    expected = friction(x, y, np.ones(len(x)), f, None, NOWHERE, (moved,))
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert ((np.array(expected) > 0.21) & (np.array(expected) < 0.69)).sum() > 50  # on its sides
    unmoved = friction(x, y, np.ones(len(x)), f, None, NOWHERE, (whole,))
    assert np.abs(np.array(unmoved) - np.array(found)).max() == pytest.approx(0.5)


@pytest.mark.slow
def test_each_polygon_has_its_own_inset() -> None:
    first = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    f, x, y = jnp.array([0.7, 0.4, 0.1]), np.array([0.5, 10.5]), np.array([2.0, 2.0])
    both = (first, first + np.array([10.0, 0.0]))
    for insets, expected in (([1.0, 0.0], [0.7, 0.1]), ([0.0, 1.0], [0.4, 0.7]), (1.0, [0.7, 0.7])):
        found = friction(x, y, np.ones(2), f, None, NOWHERE, both, insets)
        np.testing.assert_allclose(found, expected, atol=1e-12)
