"""Statistics are those of the draws."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from retrodict.findings.statistics import statistics
from retrodict.report.results import result_rows
from retrodict.studies.fit import summary
from retrodict.studies.short import of_draws
from tests.findings.test_summary import with_posterior
from tests.report.conftest import found_of


def test_statistics_are_those_of_the_draws(outcome):
    draws = outcome.idata["posterior"]["speed_b"].values
    found = found_of(outcome).quantities["speed_b"]
    assert found.mean == pytest.approx(draws.mean())
    assert found.median == pytest.approx(np.median(draws))
    assert found.sd == pytest.approx(draws.std(ddof=1))
    assert found.mcse_mean == pytest.approx(draws.std() / np.sqrt(draws.size), rel=0.25)


def test_every_interval_is_central(outcome):
    """As many draws lie below as above, in every place where an interval is printed."""
    skewed = np.random.default_rng(1).gamma(2.0, 5.0, size=(4, 500))
    outcome = with_posterior(outcome, speed_b=skewed)
    intervals = found_of(outcome).quantities["speed_b"].intervals  # terminal, files and reports
    of_models = summary(skewed.ravel()).intervals  # ladder, sweeps and validation
    for level in (50, 90, 95):
        limits = np.quantile(skewed, [0.5 - level / 200, 0.5 + level / 200])
        assert intervals[level] == pytest.approx(limits, abs=1e-3)
        assert of_models[level] == pytest.approx(limits, abs=1e-3)
    short = of_draws(outcome)["speed_b"]  # batch, sessions and the page with sliders
    assert (short["low_95"], short["high_95"]) == pytest.approx(limits, abs=1e-3)
    (row,) = (row for row in result_rows(found_of(outcome), "si") if row.label.endswith("of B"))
    printed = [float(each) for each in row.intervals[95].split(" to ")]
    assert printed == pytest.approx(limits, abs=5)  # its last digit


@pytest.mark.parametrize(("level", "z"), [(50, 0.674), (90, 1.645), (95, 1.960)])
def test_central_intervals_of_normal_draws_are_known(outcome, level, z):
    rng = np.random.default_rng(1)
    many = xr.Dataset({"speed_b": (("chain", "draw"), rng.normal(size=(4, 10000)))})
    normal = replace(outcome, idata=xr.DataTree(children={"posterior": xr.DataTree(many)}))
    found = statistics(normal, ("speed_b",))["speed_b"]
    assert found.intervals[level] == pytest.approx((-z, z), abs=0.03)
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
