"""The answers if sliding ended and if it went on stand beside each other, with a caution."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from retrodict.models.friction import Friction
from rich.console import Console

from retrodict.findings import Findings
from retrodict.findings.summary import summarise
from retrodict.report.sliding import CAUTION, sliding_table
from retrodict.report.terminal import print_summary
from retrodict.result import Result
from tests.report.conftest import found_of
from tests.report.documents import document_of, text_of

CRITICAL = 0.4


@pytest.fixture(scope="module")
def both(outcome) -> Findings:
    """B's speed is 15 m/s where no sliding was left, and 1 m/s higher for every tenth that was."""
    rng = np.random.default_rng(3)
    tree = outcome.idata.copy()
    posterior = tree["posterior"].to_dataset()
    left = np.abs(rng.normal(0, 0.2, posterior["speed_b"].shape))
    speed = posterior["speed_b"] * 0 + 15 + 10 * left
    posterior = posterior.assign(
        speed_b=speed, mu=speed * 0 + CRITICAL * (1 - left), mu_critical=speed * 0 + CRITICAL
    )
    tree["posterior"] = posterior
    law = Friction(np.full(speed.shape, CRITICAL), *outcome.scene.priors["mu"].numbers)
    density = posterior["mu"].copy(data=np.asarray(law.log_prob(posterior["mu"].values)))
    tree["log_prior"] = xr.DataTree(xr.Dataset({"mu": density}))
    return Result(replace(outcome, idata=tree)).findings


def test_both_rows_have_their_own_numbers(both: Findings) -> None:
    table = sliding_table(both, "si")
    assert table is not None
    ended, went_on = table.rows
    assert "ended within the contact" in ended[0]
    assert "more than 5% of it was left" in went_on[0]
    (found,) = both.sliding
    assert float(ended[1]) == pytest.approx(found.ended.median, abs=0.05)
    assert found.ended.median == pytest.approx(15.14, abs=0.05)
    assert float(went_on[1]) == pytest.approx(found.went_on.median, abs=0.5)
    in_mph = sliding_table(both, "us")
    assert in_mph is not None
    assert float(in_mph.rows[0][1]) == pytest.approx(found.ended.median / 0.44704, abs=0.5)


def test_the_first_page_and_the_terminal_have_them(both: Findings, outcome) -> None:
    first = text_of(document_of(outcome, sliding=both.sliding).first)
    assert "if more than 5% of it was left, as in a sideswipe" in first
    assert CAUTION in first
    assert CAUTION not in text_of(document_of(outcome).first)
    text = io.StringIO()
    print_summary(both, Console(file=text, width=200))
    assert "If sliding ended, and if it went on" in text.getvalue()
    assert CAUTION[:40] in text.getvalue()


def test_the_summary_has_them(both: Findings, outcome) -> None:
    found = summarise(both)["sliding"]["speed_b"]
    assert found["ended"]["median"] < found["went_on"]["median"]
    assert summarise(found_of(outcome))["sliding"] == {}


def test_nothing_is_said_where_checks_failed(failing) -> None:
    assert found_of(failing).sliding == ()
    assert sliding_table(found_of(failing), "si") is None
