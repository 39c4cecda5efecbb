"""Answers if sliding ended and if it went on: against closed forms of made-up draws."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from retrodict.models.friction import Friction

from retrodict.scene.priors import default_priors, overridden
from retrodict.scene.records import Contact, Measured
from retrodict.studies.sliding import TOLERANCE, by_sliding, log_ratio_of_ended, weighted

DRAWS = 40_000
CRITICAL = 0.5  # so small that sliding that goes on by a friction of its own hardly counts


def _outcome(slope: float = 10.0, critical: float = CRITICAL, **changed: Any) -> Any:
    """speed_b = 20 + slope × sliding left + noise of 1; μ from its default prior."""
    rng = np.random.default_rng(0)
    prior = default_priors()["mu"]
    law = Friction(np.full(DRAWS, critical), *prior.numbers)
    mu = np.asarray(law.icdf(rng.uniform(size=DRAWS)))
    speed = 20 + slope * (1 - mu / critical) + rng.standard_normal(DRAWS)
    draws = {"mu": mu, "mu_critical": np.full(DRAWS, critical), "speed_b": speed}
    zero = Measured(0.0)
    scene = SimpleNamespace(priors={"mu": prior}, contact=Contact(zero, zero, zero))
    made = SimpleNamespace(**({"scene": scene} | changed))
    return with_draws(made, draws)


def with_draws(outcome: Any, draws: dict[str, np.ndarray]) -> Any:
    """The outcome with other draws, and the density of μ by its prior."""
    density, prior = np.zeros(DRAWS), outcome.scene.priors["mu"]
    if not prior.family:
        law = Friction(draws["mu_critical"], *prior.numbers)
        density = np.asarray(law.log_prob(draws["mu"]))
    groups = {"/posterior": draws, "/log_prior": {"mu": density}}
    trees = {
        group: xr.Dataset({name: (("chain", "draw"), x[None]) for name, x in own.items()})
        for group, own in groups.items()
    }
    return SimpleNamespace(**(vars(outcome) | {"idata": xr.DataTree.from_dict(trees)}))


def test_if_sliding_ended_the_speed_is_that_of_no_sliding_left() -> None:
    (found,) = by_sliding(_outcome(), "speed_b")
    left = TOLERANCE * np.sqrt(2 / np.pi)  # mean of the half-normal that stands for zero
    assert found.ended.median == pytest.approx(20 + 10 * left, abs=0.1)
    assert found.ended.sd == pytest.approx(1.0, abs=0.05)
    low, high = found.ended.intervals[95]
    assert (low, high) == pytest.approx((18.2, 22.1), abs=0.15)


def test_if_it_went_on_the_speed_is_that_of_the_other_draws() -> None:
    outcome = _outcome()
    (found,) = by_sliding(outcome, "speed_b")
    tree = outcome.idata["posterior"]
    rest = np.asarray(tree["speed_b"])[np.asarray(1 - tree["mu"] / CRITICAL) > 0.05]
    assert found.went_on.median == pytest.approx(np.median(rest))
    assert found.went_on.median > found.ended.median + 1


def test_weights_are_one_on_average_over_the_prior() -> None:
    """So that a prior of both kinds of contact is w times the weight, and 1 - w."""
    for critical in (0.5, 1.5, -1.5, 3.0):
        outcome = _outcome(critical=critical)
        ratio = np.exp(log_ratio_of_ended(outcome))
        error = ratio.std() / np.sqrt(ratio.size)
        assert ratio.mean() == pytest.approx(1.0, abs=5 * error + 0.01), critical


def test_where_the_assumption_makes_no_difference_nothing_is_said() -> None:
    assert by_sliding(_outcome(slope=0.5), "speed_b") == ()


def test_where_the_evidence_excludes_one_of_them_nothing_is_said() -> None:
    outcome = _outcome()
    draws = {k: x.values[0] for k, x in outcome.idata["posterior"].data_vars.items()}
    for share in (0.999, 0.5):
        one_of_them = with_draws(outcome, draws | {"mu": share * draws["mu_critical"]})
        assert by_sliding(one_of_them, "speed_b") == ()


@pytest.mark.slow
def test_it_is_for_the_default_prior_of_a_free_friction_that_does_not_reverse() -> None:
    without = _outcome()  # a model that decides on μ samples none
    del without.idata["log_prior"]
    assert by_sliding(without, "speed_b") == ()
    scene = _outcome().scene
    given = replace(default_priors()["mu"], family="normal", numbers=(0.5, 0.1))
    of_user = SimpleNamespace(**(vars(scene) | {"priors": {"mu": given}}))
    assert by_sliding(_outcome(scene=of_user), "speed_b") == ()
    hooked = SimpleNamespace(
        **(vars(scene) | {"contact": replace(scene.contact, interlocked=True)})
    )
    assert by_sliding(_outcome(scene=hooked), "speed_b") == ()


@pytest.mark.slow
def test_other_numbers_of_the_prior_are_used() -> None:
    scene = _outcome().scene
    wider = SimpleNamespace(
        **(vars(scene) | {"priors": {"mu": overridden("mu", {"scale": 0.4}, "")}})
    )
    usual, other = (log_ratio_of_ended(_outcome(scene=each)) for each in (scene, wider))
    near = np.asarray(1 - _outcome().idata["posterior"]["mu"] / CRITICAL).ravel() < 0.01
    assert np.exp(other - usual)[near] == pytest.approx(2.0, rel=0.01)


def test_weighted_draws_of_equal_weight_are_the_draws() -> None:
    draws = np.random.default_rng(2).normal(5, 2, 10_001)
    found = weighted(draws, np.full(draws.size, 0.3))
    assert found.median == pytest.approx(np.median(draws))
    assert found.sd == pytest.approx(draws.std())
    assert found.intervals[90] == pytest.approx(np.quantile(draws, [0.05, 0.95]), abs=0.01)
