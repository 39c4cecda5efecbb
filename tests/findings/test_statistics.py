"""Statistics are those of the draws."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from retrodict.findings.statistics import statistics
from tests.findings.test_summary import with_posterior
from tests.report.conftest import found_of


def test_statistics_are_those_of_the_draws(outcome):
    draws = outcome.idata["posterior"]["speed_b"].values
    found = found_of(outcome).quantities["speed_b"]
    assert found.mean == pytest.approx(draws.mean())
    assert found.median == pytest.approx(np.median(draws))
    assert found.sd == pytest.approx(draws.std(ddof=1))
    assert found.mcse_mean == pytest.approx(draws.std() / np.sqrt(draws.size), rel=0.25)


@pytest.mark.parametrize(("level", "z"), [(50, 0.674), (90, 1.645), (95, 1.960)])
def test_shortest_intervals_of_normal_draws_are_known(outcome, level, z):
    rng = np.random.default_rng(1)
    many = xr.Dataset({"speed_b": (("chain", "draw"), rng.normal(size=(4, 10000)))})
    normal = replace(outcome, idata=xr.DataTree(children={"posterior": xr.DataTree(many)}))
    found = statistics(normal, ("speed_b",))["speed_b"]
    low, high = found.intervals[level]
    # a shortest interval slides easily, its length does not
    assert high - low == pytest.approx(2 * z, rel=0.03)
    assert low == pytest.approx(-z, abs=0.2)
    assert 30_000 < found.ess_bulk < 50_000
    assert found.rhat < 1.001


def test_chains_that_disagree_show_in_rhat(outcome):
    apart = np.random.default_rng(0).normal(size=(4, 500)) + np.arange(4)[:, None]
    found = found_of(with_posterior(outcome, e_m=apart)).quantities["e_m"]
    assert found.rhat > 1.2
    assert found.ess_bulk < 50


def test_a_parameter_that_failed_its_own_checks_says_so(failing):
    found = found_of(failing)
    assert [name for name, each in found.quantities.items() if not each.passed] == ["e_m"]
    assert all(each.withheld for each in found.derived.values())


def test_correlations_are_those_of_the_draws_of_pairs_that_vary(outcome):
    draws = outcome.idata["posterior"].to_dataset()
    r = np.corrcoef(draws["speed_b"].values.ravel(), draws["mu"].values.ravel())[0, 1]
    assert found_of(outcome).correlations["speed_b", "mu"] == pytest.approx(r)
    still = found_of(with_posterior(outcome, e=np.full((4, 500), 0.1))).correlations
    assert set(still) == {("speed_b", "e_m"), ("speed_b", "mu"), ("e_m", "mu")}


def test_digits_to_print_follow_unit_and_monte_carlo_error(outcome):
    precision = found_of(outcome).quantities["speed_b"].precision
    assert (precision["si"].unit.symbol, precision["us"].unit.symbol) == ("m/s", "mph")
    assert (precision["si"].decimals, precision["us"].of_level[95]) == (1, 0)
