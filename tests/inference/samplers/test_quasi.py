"""Scrambled Sobol points: their means are right, their errors are reported, and small."""

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtri

from retrodict.inference.samplers.quasi import Weighted, scrambled

SCRAMBLINGS = 8
LEVELS = np.array([0.025, 0.5, 0.975])
OF_EACH = 128


def _normal(seed: int, size: int) -> np.ndarray:
    return ndtri(scrambled(size, OF_EACH, SCRAMBLINGS, seed))


def _weighted(log_weight: np.ndarray) -> Weighted:
    weights = np.exp(log_weight - log_weight.max())
    return Weighted(weights / weights.sum(), SCRAMBLINGS)


def test_points_fill_each_scrambling_evenly_and_no_face_is_touched() -> None:
    points = scrambled(5, OF_EACH, SCRAMBLINGS, 0)
    assert points.shape == (SCRAMBLINGS * OF_EACH, 5)
    assert np.isfinite(ndtri(points)).all()
    for own in points.reshape(SCRAMBLINGS, OF_EACH, 5):
        for coordinate in own.T:  # one point in each of so many slices
            assert (np.bincount((coordinate * OF_EACH).astype(int)) == 1).all()
    np.testing.assert_array_equal(points, scrambled(5, OF_EACH, SCRAMBLINGS, 0))
    assert (points != scrambled(5, OF_EACH, SCRAMBLINGS, 1)).all()


def test_errors_are_those_that_estimates_have() -> None:
    """Of a skewed target, from a wider normal: off by their own errors, as Student's t has it."""
    target = stats.skewnorm(3.0)
    mean, sd = target.mean(), target.std()
    off: dict[str, list[float]] = {"mean": [], "sd": [], "low": [], "median": [], "high": []}
    for seed in range(200):
        x = 1.5 * _normal(seed, 6)
        log_weight = target.logpdf(x[:, 0]) + stats.norm.logpdf(x[:, 1:]).sum(axis=1)
        weighted = _weighted(log_weight - stats.norm.logpdf(x, 0, 1.5).sum(axis=1))
        for name, (value, error), true in (
            ("mean", weighted.mean(x[:, 0]), mean),
            ("sd", weighted.sd(x[:, 0]), sd),
        ):
            off[name].append((value - true) / error)
        found, errors = weighted.quantiles(x[:, 0], LEVELS)
        missed = (target.cdf(found) - LEVELS) / errors
        for name, each in zip(("low", "median", "high"), missed, strict=True):
            off[name].append(each)
    beyond = stats.t(SCRAMBLINGS - 1).ppf(0.975)
    for name, each in off.items():
        # 5 % lie beyond; of 200 runs 0 to 11 % do, at five standard errors of that share
        assert np.mean(np.abs(each) > beyond) < 0.13, name
        assert np.mean(np.abs(each)) > 0.4, name  # errors are not reported larger than they are


def test_a_mean_is_surer_than_by_as_many_independent_draws() -> None:
    """A standard normal by itself in 20 coordinates: the variance of means falls tenfold at least."""
    means = [_normal(seed, 20)[:, 0].mean() for seed in range(50)]
    independent = 1 / (SCRAMBLINGS * OF_EACH)
    assert np.var(means) < independent / 10


def test_no_error_is_above_that_of_independent_draws() -> None:
    """Of a probability in a tail, that eight scramblings would often show twice as large."""
    for seed in range(50):
        x = _normal(seed, 20)
        log_weight = -(x[:, 1] ** 2) / 4
        weighted = _weighted(log_weight)
        below = x[:, 0] <= stats.norm.ppf(0.025)
        alone = np.sqrt(np.sum((weighted.weights * (below - weighted.weights @ below)) ** 2))
        assert weighted.mean(below.astype(float))[1] <= alone * (1 + 1e-9)


def test_quantiles_of_equal_weights_are_those_of_the_draws() -> None:
    x = np.random.default_rng(0).normal(size=1000)
    weighted = Weighted(np.full(1000, 1e-3), SCRAMBLINGS)
    found = weighted.quantiles(x, LEVELS)[0]
    np.testing.assert_allclose(found, np.quantile(x, LEVELS, method="hazen"), atol=1e-9)


def test_a_quantity_that_does_not_vary_has_no_error() -> None:
    weighted = _weighted(np.random.default_rng(0).normal(size=800))
    value, error = weighted.mean(np.full(800, 3.0))
    assert value == pytest.approx(3.0)
    assert error == pytest.approx(0.0, abs=1e-12)
