"""Bands of uniform ranks, what leaves them, and coverage, on ranks of known laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import beta, norm

from retrodict.studies.calibration import DRAWS, Calibration, Row, design
from retrodict.studies.uniformity import uniformity


def ranked(probabilities, name="speed_b") -> Calibration:
    """Ranks of truths at these cumulative probabilities of their posteriors."""
    ranks = np.minimum(np.asarray(probabilities) * (DRAWS + 1), DRAWS).astype(int)
    rows = tuple(Row(i, {name: int(rank)}) for i, rank in enumerate(ranks))
    return Calibration(design(), "momentum+slide", "importance", 0, len(rows), rows)


@pytest.mark.slow
def test_a_band_holds_as_many_uniform_samples_as_it_says() -> None:
    rng = np.random.default_rng(4)
    inside = [uniformity(ranked(rng.random(80)))["speed_b"].inside for _ in range(1500)]
    assert np.mean(inside) == pytest.approx(0.95, abs=0.02)  # three standard errors, and the band's


@pytest.mark.parametrize(
    "wrong",
    [
        lambda u: norm.cdf(norm.ppf(u) + 0.4),  # posteriors too low by 0.4 of their sd
        lambda u: norm.cdf(norm.ppf(u) * 1.4),  # too narrow
        lambda u: norm.cdf(norm.ppf(u) / 1.4),  # too wide
    ],
)
def test_a_shift_and_a_wrong_width_are_distinguished_from_uniform(wrong) -> None:
    u = np.random.default_rng(5).random(300)
    assert uniformity(ranked(u))["speed_b"].inside_jointly
    assert not uniformity(ranked(wrong(u)))["speed_b"].inside_jointly


def test_coverage_is_that_of_central_intervals_with_a_binomial_error() -> None:
    """Of a beta law of probabilities its share between the limits is known."""
    law = beta(2, 2)
    found = uniformity(ranked(law.rvs(1000, random_state=6)))["speed_b"].coverage
    for level, (share, error) in found.items():
        exact = law.cdf(0.5 + level / 200) - law.cdf(0.5 - level / 200)
        assert share == pytest.approx(exact, abs=3 * error)
        assert error == pytest.approx(np.sqrt(level / 100 * (1 - level / 100) / 1000))


def test_a_rank_is_no_step_in_the_curve() -> None:
    """Ranks stand for intervals: truths all over one rank's interval are not heaped at its edge."""
    found = uniformity(ranked(np.repeat((np.arange(DRAWS + 1) + 0.5) / (DRAWS + 1), 5)))
    assert np.abs(found["speed_b"].difference).max() < 0.011  # one interval's width


def test_the_quantities_share_one_level() -> None:
    """Bonferroni: more quantities, a wider band for each."""
    rng = np.random.default_rng(7)
    for _ in range(200):
        u = rng.random(60)
        one = ranked(u)
        two = replace(one, rows=tuple(replace(r, ranks=r.ranks | {"e": 50}) for r in one.rows))
        alone, shared = uniformity(one)["speed_b"], uniformity(two)["speed_b"]
        assert alone.inside == alone.inside_jointly
        if alone.inside != shared.inside_jointly:
            assert shared.inside_jointly
            return
    raise AssertionError("the wider band made no difference")


def test_no_ranks_are_no_verdict() -> None:
    assert uniformity(replace(ranked([0.5]), rows=(Row(0, reason="no"),))) == {}
