"""A run anew beside a recorded one: same to the bit, to the printed digits, or not."""

import copy
import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from retrodict.findings import compute
from retrodict.findings.reproduction import compare
from retrodict.findings.summary import summarise
from retrodict.report.reproduction import reproduction_lines


@pytest.fixture(scope="module")
def found(outcome):
    return compute(outcome)


@pytest.fixture
def recorded(found):
    return json.loads(json.dumps(summarise(found)))


def compared(recorded, found, outcome, draws=None):
    idata = outcome.idata
    return compare("ab12", recorded, idata if draws is None else draws, found, idata)


def of_name(reproduction, name):
    (number,) = [each for each in reproduction.numbers if each.name == name]
    return number


def test_the_same_run_is_the_same_to_the_bit(recorded, found, outcome):
    same = compared(recorded, found, outcome)
    assert same.reproduced
    assert {each.sameness for each in same.numbers} == {"bits"}
    assert all(same.draws.values())
    names = {each.name for each in same.numbers}
    assert {"parameters.speed_b.mean", "derived.pdof_a.interval_95.0", "checks.max_rhat"} <= names
    assert {"measured.mass_a.mean", "left_out.rest_x_a.expected", "seed"} <= names
    assert not [name for name in names if "seconds" in name]


def test_every_number_of_a_summary_is_compared(recorded, found, outcome):
    def count(value):
        if isinstance(value, dict | list):
            return sum(map(count, value.values() if isinstance(value, dict) else value))
        return value is None or (isinstance(value, int | float) and not isinstance(value, bool))

    of_times = count(recorded["seconds"])
    assert len(compared(recorded, found, outcome).numbers) == count(recorded) - of_times


def test_a_number_is_judged_by_its_digits_and_its_error(recorded, found, outcome):
    quantity = found.quantities["speed_b"]
    decimals, mean = quantity.precision["si"].decimals, quantity.mean
    nearest = round(mean, decimals)
    # beyond the nearest number that rounds otherwise: a unit of the last digit is below ten errors
    beyond = nearest + np.copysign(10.0**-decimals / 2 + 1e-9, mean - nearest)
    assert abs(beyond - mean) < 5 * quantity.error
    cases = {mean + 1e-12: "digits", beyond: "error", mean + 30 * quantity.error: "no"}
    for moved, sameness in cases.items():
        recorded["parameters"]["speed_b"]["mean"] = moved
        result = compared(recorded, found, outcome)
        assert of_name(result, "parameters.speed_b.mean").sameness == sameness
        assert result.reproduced == (sameness == "digits")


def test_a_number_that_went_missing_or_came_anew_is_not_reproduced(recorded, found, outcome):
    gone = copy.deepcopy(recorded)
    gone["derived"]["energy_lost"]["mean"] = None
    assert of_name(compared(gone, found, outcome), "derived.energy_lost.mean").sameness == "no"
    del recorded["derived"]["energy_lost"]
    assert not compared(recorded, found, outcome).reproduced


def test_draws_that_differ_and_versions_that_differ_are_named(recorded, found, outcome):
    recorded["versions"]["jax"] = "0.1"
    draws = outcome.idata.copy()
    posterior = draws["posterior"].to_dataset().copy(deep=True)
    posterior["mu"][0, 0] = np.nextafter(float(posterior["mu"][0, 0]), 1)
    draws["posterior"] = xr.DataTree(posterior)
    result = compared(recorded, found, outcome, draws)
    assert [name for name, same in result.draws.items() if not same] == ["posterior/mu"]
    assert result.versions == {"jax": ("0.1", "0.12.0")}
    assert "jax 0.1 (now 0.12.0)" in "\n".join(reproduction_lines(result))


def test_the_lines_say_what_differs(recorded, found, outcome):
    assert "every number reproduced" in reproduction_lines(compared(recorded, found, outcome))[0]
    recorded["parameters"]["speed_b"]["mean"] = 30.0
    recorded["seed"] = 4
    lines = reproduction_lines(compared(recorded, found, outcome))
    assert "NOT every number reproduced" in lines[0]
    text = "\n".join(lines)
    assert "parameters.speed_b.mean: 30.0 was recorded" in text
    assert "  seed: 4 was recorded, now 20 (not the same)" in text
    assert "ab12" in text


def test_findings_of_a_failed_run_compare_too(failing):
    found = compute(replace(failing, checks=replace(failing.checks, max_rhat=float("inf"))))
    recorded = json.loads(json.dumps(summarise(found)))
    assert compare("", recorded, failing.idata, found, failing.idata).reproduced
