"""Decimals of a printed number: what its uncertainty asks for, and what its draws support."""

import math

import numpy as np
import pytest
import xarray as xr

from retrodict.inference.digits import decimals_of, monte_carlo_error, rhat_text


@pytest.mark.parametrize(
    ("sd", "digits", "decimals"),
    [(0.89, 2, 2), (0.89, 1, 1), (0.96, 1, 0), (9.4, 2, 1), (95.0, 2, 0), (1234.0, 2, -2)],
)
def test_decimals_keep_so_many_digits(sd, digits, decimals):
    assert decimals_of(sd, digits) == decimals


@pytest.mark.parametrize("sd", [0.0, -1.0, math.inf, math.nan, None])
def test_no_uncertainty_asks_for_no_decimals(sd):
    assert decimals_of(sd) is None


@pytest.mark.parametrize(
    ("error", "decimals"),
    [(0.0099, 2), (0.011, 1), (0.099, 1), (0.11, 0), (1.2, -1), (None, 2), (math.nan, 2)],
)
def test_no_digit_is_printed_that_the_draws_do_not_bear_out(error, decimals):
    """The error is below a unit of the last digit."""
    assert decimals_of(0.89, error=error) == decimals


@pytest.mark.parametrize(("level", "most"), [(0.0, 1.2), (0.5, 1.4), (0.95, 1.4)])
def test_monte_carlo_error_is_the_spread_over_repetitions(level, most):
    """Of 300 sets of normal draws; the larger of two estimates errs upwards."""
    draws = np.random.default_rng(0).normal(size=(300, 4, 500))
    spread = np.quantile(draws, [0.5 - level / 2, 0.5 + level / 2], axis=(1, 2)).std(axis=1).max()
    sets = [xr.Dataset({"x": (("chain", "draw"), each)}) for each in draws[:40]]
    estimate = np.mean([float(monte_carlo_error(each, level)["x"]) for each in sets])
    assert 0.9 < estimate / spread < most


def test_rhat_of_chains_that_stand_still_is_no_long_number() -> None:
    assert [rhat_text(v) for v in (1.00349, 99.9, 5.6e15, np.nan, np.inf, None)] == [
        "1.003", "99.900", "over 100", "–", "–", "–",
    ]  # fmt: skip
