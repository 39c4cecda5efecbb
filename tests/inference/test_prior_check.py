"""Crashes of the prior, weighted by the evidence: what they refute, and what they leave."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from retrodict.inference.prior_check import (
    PriorCheck,
    Reference,
    reference,
    refuted,
    refuted_evidence,
)

SIZE = 3


def crashes(sd: float = 0.5, ruled_out: float = -np.inf) -> SimpleNamespace:
    """Of three deviates the first was measured as 1; where it is less than `ruled_out` is no crash."""

    def of_nearest_turns(u: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        found = np.where(u[:, 0] < ruled_out, -np.inf, -(((u[:, 0] - 1) / sd) ** 2) / 2)
        return found, {"speed_b": u[:, 0], "e": u[:, 1], "other": u[:, 2]}

    return SimpleNamespace(size=SIZE, of_nearest_turns=of_nearest_turns)


def evidence(sd: float = 0.5) -> float:
    """Log evidence of `crashes`: a normal prior against a normal likelihood of height one."""
    return stats.norm.logpdf(1, 0, np.hypot(1, sd)) - stats.norm.logpdf(0, 0, sd)


def normal_reference(count: int, left: int, rng: np.random.Generator) -> Reference:
    """Crashes by which the speed is 20 ± 2 m/s, of which so many count."""
    weights = np.where(np.arange(count) < left, 1 / left, 0.0)
    return Reference({"speed_b": rng.normal(20, 2, count)}, weights, {})


def test_weighted_crashes_have_the_posteriors_moments() -> None:
    """Of a normal prior and a normal likelihood: mean 0.8, variance 0.2."""
    found = reference(crashes(), ("speed_b", "e"), seed=0)
    assert set(found.quantities) == {"speed_b", "e"}
    assert set(found.every) == {"speed_b", "e", "other"}
    assert found.effective > 1000
    mean = found.weights @ found.quantities["speed_b"]
    variance = found.weights @ (found.quantities["speed_b"] - mean) ** 2
    error = np.sqrt(0.2 / found.effective)
    assert mean == pytest.approx(0.8, abs=4 * error)
    assert variance == pytest.approx(0.2, abs=4 * 0.2 * np.sqrt(2 / found.effective))


def test_weighted_crashes_give_the_evidence() -> None:
    found, error = reference(crashes(), ("speed_b",), seed=0).log_evidence
    assert 0 < error < 0.05
    assert found == pytest.approx(evidence(), abs=4 * error)


@pytest.mark.parametrize("seed", range(5))
def test_draws_that_miss_or_double_a_part_are_refuted_by_their_evidence(seed: int) -> None:
    known = reference(crashes(), ("speed_b",), seed)
    exact = evidence()
    assert refuted_evidence(known, exact, 0.02) == ()
    (missing,) = refuted_evidence(known, exact + np.log(0.6), 0.02)
    assert "missing" in missing
    assert "of the posterior by" in missing
    (twice,) = refuted_evidence(known, exact + np.log(2), 0.02)
    assert "counted twice" in twice
    assert refuted_evidence(known, exact + np.log(0.6), 0.3) == ()
    assert refuted_evidence(known, exact + np.log(0.6), np.nan) == ()


@pytest.mark.parametrize(
    ("sd", "ruled_out", "kept"),
    [
        (1e6, -np.inf, 1.0),  # no difference was detected
        (1e6, 0.0, 0.5),
        (1e6, 100.0, 0.0),  # none is a crash: that is not little
        (0.01, 100.0, 0.0),
    ],
)
def test_the_share_of_the_prior_that_evidence_leaves(
    sd: float, ruled_out: float, kept: float
) -> None:
    found = reference(crashes(sd, ruled_out), ("speed_b",), seed=0)
    assert found.weights.sum() == pytest.approx(float(kept > 0))
    assert found.effective / found.weights.size == pytest.approx(kept, abs=0.04)
    assert (found.quantities["speed_b"][found.weights > 0] >= ruled_out).all()


def test_more_crashes_are_drawn_where_the_first_are_promising_and_no_longer_than_that() -> None:
    settings = PriorCheck()
    for sd, drawn in ((0.5, settings.first), (0.01, settings.most), (1e-5, settings.first)):
        assert reference(crashes(sd), ("speed_b",), seed=0).weights.size == drawn


def test_the_same_seed_gives_the_same_crashes() -> None:
    one, again, other = (reference(crashes(), ("speed_b",), seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.quantities["speed_b"], again.quantities["speed_b"])
    assert not np.array_equal(one.quantities["speed_b"], other.quantities["speed_b"])


@pytest.mark.parametrize(
    ("mean", "sd", "numbers"),
    [
        (21.5, 2.0, ("21.5 ± 2 m/s", "20 ± 2 m/s")),
        (20.0, 1.0, ("20 ± 1 m/s", "20 ± 2 m/s")),
        (20.0, 4.0, ("20 ± 4 m/s", "20 ± 2 m/s")),
    ],
)
def test_a_wrong_mean_or_spread_is_refuted_with_both_numbers(
    mean: float, sd: float, numbers: tuple[str, str]
) -> None:
    z = stats.norm.ppf((np.arange(2000) + 0.5) / 2000)
    z /= z.std()
    weights = np.full(2000, 1 / 2000)
    known = Reference({"speed_b": 20 + 2 * z}, weights, {})
    found = refuted(known, {"speed_b": (mean + sd * z).reshape(4, 500)}, {"speed_b": 1500.0})
    assert set(found) == {"speed_b"}
    assert "speed of B" in found["speed_b"]
    assert " against ".join(numbers) in found["speed_b"]
    assert "2000 crashes of the prior" in found["speed_b"]


@pytest.mark.parametrize("left", [60, 1000])
def test_right_draws_are_not_refuted(left: int) -> None:
    """Of 200 references and as many sets of draws, by chance, at most a few."""
    count = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        known = normal_reference(4096, left, rng)
        draws = {"speed_b": rng.normal(20, 2, (4, 500))}
        count += bool(refuted(known, draws, {"speed_b": 2000.0}))
    assert count <= 3


@pytest.mark.slow
def test_right_draws_of_a_weighted_reference_are_not_refuted() -> None:
    """Uneven weights and a skewed quantity, as evidence leaves them."""
    count = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        known = reference(crashes(0.1), ("speed_b", "e"), seed)
        known = Reference(
            {k: np.exp(v) for k, v in known.quantities.items()}, known.weights, known.every
        )
        mean, sd = 1 / 1.01, np.sqrt(0.01 / 1.01)
        draws = {
            "speed_b": np.exp(rng.normal(mean, sd, 2000)),
            "e": np.exp(rng.normal(0, 1, 2000)),
        }
        count += bool(refuted(known, draws, dict.fromkeys(draws, 2000.0)))
    assert count <= 3


def test_few_crashes_and_heavy_ones_refute_nothing() -> None:
    rng = np.random.default_rng(0)
    draws, worth = {"speed_b": rng.normal(40, 2, 2000)}, {"speed_b": 2000.0}
    assert refuted(normal_reference(4096, 60, rng), draws, worth)
    assert refuted(normal_reference(4096, 30, rng), draws, worth) == {}
    heavy = normal_reference(4096, 1000, rng)
    weights = 0.85 * heavy.weights
    weights[0] += 0.15  # of all the weight
    assert refuted(Reference(heavy.quantities, weights, {}), draws, worth) == {}
    nothing = Reference(heavy.quantities, np.zeros(4096), {})
    assert refuted(nothing, draws, worth) == {}


def test_what_was_not_drawn_is_not_compared_and_an_uncertain_mean_refutes_little() -> None:
    rng = np.random.default_rng(0)
    known = normal_reference(4096, 1000, rng)
    assert refuted(known, {"e": rng.normal(size=2000)}, {"e": 2000.0}) == {}
    draws = {"speed_b": rng.normal(21, 2, 2000)}
    assert refuted(known, draws, {"speed_b": 2000.0})
    assert refuted(known, draws, {"speed_b": 10.0}) == {}
