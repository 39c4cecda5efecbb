"""The way down a potential, against ones whose minimise points are known."""

from collections.abc import Callable

import numpy as np
import pytest

from retrodict.inference.fitting.optimise import Potential, spread

LOWEST = np.array([1.0, -2.0, 0.5])
PRECISION = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 4.0]])


def bowl(w: np.ndarray) -> np.ndarray:
    off = w - LOWEST
    return np.einsum("...i,ij,...j", off, PRECISION, off) / 2


def potential(values: Callable[[np.ndarray], np.ndarray], cut: float = np.inf) -> Potential:
    """With a surrogate that misses by nothing; what lies beyond `cut` is outside."""

    def at(w: np.ndarray) -> np.ndarray:
        return np.where(np.linalg.norm(w, axis=-1) < cut, values(w), np.inf)

    return Potential(lambda w: (at(w), np.zeros((len(w), 1))), lambda w, _: at(w))


def test_a_bowl_is_found_out() -> None:
    down = potential(bowl)
    w = np.array([0.3, 0.2, -0.1])
    value, slope = down(w)
    assert value == pytest.approx(bowl(w))
    np.testing.assert_allclose(slope, PRECISION @ (w - LOWEST), atol=1e-9)
    np.testing.assert_allclose(down.curvature(w), PRECISION, atol=1e-9)
    found = down.minimise(w)
    np.testing.assert_allclose(found.w, LOWEST, atol=2e-3)
    assert found.value == pytest.approx(0, abs=1e-5)


def test_a_search_from_outside_is_led_back() -> None:
    found = potential(bowl, cut=6.0).minimise(np.array([8.0, 1.0, 0.0]))
    np.testing.assert_allclose(found.w, LOWEST, atol=2e-3)


def test_nothing_is_found_where_nothing_is() -> None:
    assert potential(bowl, cut=0.0).minimise(np.ones(3)).value == np.inf


def test_a_search_follows_a_bent_valley() -> None:
    """Its floor is zero; where it ends, a quadratic lies hardly lower."""

    def valley(w: np.ndarray) -> np.ndarray:
        x, y, z = np.moveaxis(w, -1, 0)
        return (1 - x) ** 2 + 20 * (y - x**2) ** 2 + z**2

    assert potential(valley).minimise(np.array([-6.0, 36.0, 1.0])).value < 1.0


def test_a_surrogate_that_misses_is_held_to_what_it_misses_at_the_point() -> None:
    """The exact bowl costs one value a point; slope and curvature are the surrogate's about it."""
    asked = []

    def at(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        asked.append(len(w))
        return bowl(w), np.full((len(w), 1), 5.0)

    found = Potential(at, lambda w, missed: bowl(w) + missed[:, 0]).minimise(np.zeros(3))
    np.testing.assert_allclose(found.w, LOWEST, atol=2e-3)
    assert set(asked) == {1}


def test_a_spread_squares_to_the_inverse_curvature() -> None:
    axes = spread(PRECISION, 1e-2)
    np.testing.assert_allclose(axes @ axes.T, np.linalg.inv(PRECISION), atol=1e-12)
    flat = spread(np.diag([1.0, 0.0]), 0.25)
    np.testing.assert_allclose(flat @ flat.T, np.diag([1.0, 4.0]), atol=1e-12)
