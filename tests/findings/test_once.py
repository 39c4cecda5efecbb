"""Every statistic is computed once, however often and wherever it is printed or drawn."""

import io
import pickle
from collections import Counter
from dataclasses import replace

import arviz_stats
import pytest
import xarray as xr
from rich.console import Console

from retrodict.findings import record, statistics
from retrodict.report.figures import registry as figures
from retrodict.report.figures.registry import FIGURES
from retrodict.report.terminal import print_summary
from retrodict.result import Result
from retrodict.scene.quantities import SPEEDS

ARVIZ = ("eti", "ess", "rhat", "mcse")
RECORD = ("conflicts", "input_rows", "assumptions", "correlations", "answer", "verdict")


@pytest.fixture
def calls(monkeypatch):
    """How often each statistic of each quantity was asked for, and each study of the outcome."""
    counts = Counter()

    def counted(module, function, key):
        original = getattr(module, function)

        def counting(*arguments, **options):
            counts.update(key(function, *arguments, **options))
            return original(*arguments, **options)

        monkeypatch.setattr(module, function, counting)

    def of_each(function, data, **options):
        names = data.data_vars if isinstance(data, xr.Dataset) else ["another"]
        return [(function, str(name), tuple(sorted(options.items()))) for name in names]

    for function in ARVIZ:
        counted(arviz_stats, function, of_each)
    for function in RECORD:
        counted(record, function, lambda name, *arguments: [(name, *arguments[2:])])
    counted(record, "answers_to", lambda name, *_: [(name,)])
    counted(record, "narrowing", lambda name, _, of: [(name, of)])
    monkeypatch.setattr(figures, "to_png", lambda _: b"PNG")  # all is drawn, and nothing rendered
    counted(statistics, "_precision", lambda name, unit, *_: [(name,)])
    return counts


def show(result, folder):
    result.save(folder)
    result.report(folder / "again.html", "us")
    for name in FIGURES:
        getattr(result, f"plot_{name}")()
    for units in ("si", "us"):
        result.summary(units)
        result._repr_html_()
        print_summary(result.findings, Console(file=io.StringIO()), units)


@pytest.mark.parametrize("name", [pytest.param("sparse", marks=pytest.mark.slow), "failing"])
def test_each_statistic_is_computed_once(name, request, calls, tmp_path):
    outcome = request.getfixturevalue(name)
    result = Result(outcome)
    show(result, tmp_path)
    found = result.findings
    quantities = [*found.quantities, *found.derived]
    # errors of the shares of an error that would be believed, two an item of evidence, and of effects
    others = [key for key in calls if key[1:2] == ("another",)]
    effects = [each.numbers for each in found.questions if each.kind == "one_at_a_time"]
    expected = 2 * len(found.left_out) + sum(len(each or ()) for each in effects)
    assert sum(calls.pop(key) for key in others) == expected
    # the digits of each quantity, in SI and in US units
    assert calls.pop(("_precision",)) == 2 * len(quantities)
    assert {key: times for key, times in calls.items() if times != 1} == {}
    expected = Counter({"eti": 3, "ess": 2, "rhat": 1})
    for function, times in expected.items():
        asked = Counter(key[1] for key in calls if key[0] == function)
        assert asked == dict.fromkeys(quantities, times)
    assert {key[0] for key in calls} >= {"conflicts", "input_rows", "assumptions", "correlations"}
    speeds = [name for name in quantities if name in SPEEDS]
    sought = speeds if outcome.checks.passed else []
    assert [key[1] for key in calls if key[0] == "narrowing"] == sought


@pytest.mark.slow
def test_figures_and_documents_compute_nothing(outcome, calls, tmp_path):
    result = Result(outcome)
    _ = result.findings
    calls.clear()
    show(result, tmp_path)
    assert not calls


def test_findings_and_outcomes_are_plain_data(outcome, calls):
    unfinished = replace(outcome, unfinished=b"chains", complete=False)
    again = pickle.loads(pickle.dumps(unfinished))
    assert again.unfinished == b"chains"
    assert (again.scene, again.description, again.checks) == (
        outcome.scene,
        outcome.description,
        outcome.checks,
    )
    assert again.idata["posterior"].to_dataset().identical(outcome.idata["posterior"].to_dataset())
    found = Result(outcome).findings
    assert pickle.loads(pickle.dumps(found)) == found
