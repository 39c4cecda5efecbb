"""Decimals of a printed number: what its uncertainty asks for, and what its draws bear out."""

import math

import numpy as np
import pytest
import xarray as xr

from retrodict.inference.digits import decimals_of, monte_carlo_errors


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
    [(0.0049, 2), (0.0051, 1), (0.049, 1), (0.051, 0), (0.6, -1), (None, 2), (math.nan, 2)],
)
def test_no_digit_is_printed_that_the_draws_do_not_bear_out(error, decimals):
    """The error is below half a unit of the last digit (JCGM 101:2008, 7.9.2)."""
    assert decimals_of(0.89, error=error) == decimals


def test_monte_carlo_errors_are_the_spread_over_repetitions():
    """Of median and limits, whose errors are the larger ones, over 300 sets of normal draws."""
    draws = np.random.default_rng(0).normal(size=(300, 4, 500))
    spread = np.quantile(draws, [0.025, 0.5, 0.975], axis=(1, 2)).std(axis=1)
    told = [monte_carlo_errors(xr.Dataset({"x": (("chain", "draw"), d)})) for d in draws[:40]]
    middle, limits = np.mean([[float(each["x"]) for each in pair] for pair in told], axis=0)
    assert middle == pytest.approx(spread[1], rel=0.2)
    # the larger of two estimates errs upwards
    assert 1 < limits / max(spread[0], spread[2]) < 1.4
