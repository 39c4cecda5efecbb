"""The way down a potential, against ones whose minimise points are known."""

import numpy as np
import pytest

from retrodict.inference.fitting.optimise import Differenced, Differentiated, Potential, spread

LOWEST, OTHER = np.array([1.0, -2.0, 0.5]), np.array([9.0, 0.0, 0.0])
PRECISION = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 4.0]])


def bowl(w: np.ndarray) -> np.ndarray:
    off = w - LOWEST
    return np.einsum("...i,ij,...j", off, PRECISION, off) / 2


def two_bowls(w: np.ndarray) -> np.ndarray:
    """The likelier about zero, the other far off."""
    far = ((w - OTHER) ** 2).sum(axis=-1) / 2 + 1
    return -np.logaddexp(-(w**2).sum(axis=-1) / 2, -far)


def differenced(values: object, *, cut: float = np.inf, slopes: object = None) -> Differenced:
    """A surrogate_value that misses by nothing; what lies beyond `cut` is outside."""

    def at(w: np.ndarray) -> np.ndarray:
        return np.where(np.linalg.norm(w, axis=-1) < cut, values(w), np.inf)  # type: ignore[operator]

    sloped = slopes and (lambda w: (at(w), slopes(w)))  # type: ignore[operator]
    return Differenced(lambda w: (at(w), np.zeros((len(w), 1))), lambda w, _: at(w), sloped)


def slopes_of_bowl(w: np.ndarray) -> np.ndarray:
    return (w - LOWEST) @ PRECISION


POTENTIALS: dict[str, Potential] = {
    "differenced": differenced(bowl),
    "differenced-with-slopes": differenced(bowl, slopes=slopes_of_bowl),
    "differentiated": Differentiated(lambda w: (float(bowl(w)), PRECISION @ (w - LOWEST))),
}


@pytest.mark.parametrize("which", POTENTIALS)
def test_a_bowl_is_found_out(which: str) -> None:
    potential = POTENTIALS[which]
    w = np.array([0.3, 0.2, -0.1])
    value, slope = potential(w)
    assert value == pytest.approx(bowl(w))
    np.testing.assert_allclose(slope, PRECISION @ (w - LOWEST), atol=1e-9)
    np.testing.assert_allclose(potential.curvature(w), PRECISION, atol=1e-9)
    found = potential.minimise(w)
    np.testing.assert_allclose(found.w, LOWEST, atol=2e-3)
    assert found.value == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("slopes", [None, slopes_of_bowl])
def test_a_search_from_outside_is_led_back(slopes: object) -> None:
    potential = differenced(bowl, cut=6.0, slopes=slopes)
    found = potential.minimise(np.array([8.0, 1.0, 0.0]))
    np.testing.assert_allclose(found.w, LOWEST, atol=2e-3)


def test_nothing_is_found_where_nothing_is() -> None:
    assert differenced(bowl, cut=0.0).minimise(np.ones(3)).value == np.inf


def test_a_search_is_given_up_where_it_will_not_reach_what_is_asked_and_not_before() -> None:
    """Along a bent valley, whose floor is zero."""
    start, counts = np.array([-6.0, 36.0, 1.0]), {}
    for most in (np.inf, 1.0, -50.0):
        asked = []

        def valley(w: np.ndarray, asked: list[int] = asked) -> np.ndarray:
            asked.append(len(w))
            x, y, z = np.moveaxis(w, -1, 0)
            return (1 - x) ** 2 + 20 * (y - x**2) ** 2 + z**2

        found = differenced(valley).minimise(start, most=most)
        counts[most] = len(asked)
        assert found.value < 1.0 or most < 0
    assert counts[-50.0] < counts[1.0] == counts[np.inf]


def test_of_many_searches_each_ends_in_its_own_bowl() -> None:
    potential = differenced(two_bowls, cut=30.0)
    starts = np.array(
        [[4.0, 0, 0], [0, -20.0, 3.0], [12.0, 1.0, 0], [10.0, -8.0, 2.0], [31.0, 0, 0]]
    )
    ends = potential.minimise_from(starts, lambda w: bool(np.linalg.norm(w) < 3))
    here = [end for end in ends if np.linalg.norm(end.w - OTHER) < 1e-2]
    assert len(ends) < len(starts)  # two at least arrive about zero
    assert len(here) >= 2
    assert all(np.isfinite(end.value) for end in ends)


def test_a_spread_squares_to_the_inverse_curvature() -> None:
    axes = spread(PRECISION, 1e-2)
    np.testing.assert_allclose(axes @ axes.T, np.linalg.inv(PRECISION), atol=1e-12)
    flat = spread(np.diag([1.0, 0.0]), 0.25)
    np.testing.assert_allclose(flat @ flat.T, np.diag([1.0, 4.0]), atol=1e-12)
