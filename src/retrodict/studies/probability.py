"""How probable a proposition is, and how much better one explains the evidence than another."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from retrodict.scene.measured import Measured
from retrodict.studies.draws import NotAnswered, draws_of, effective_draws, error_of_mean

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.asked import Comparison, Proposition
    from retrodict.scene.priors import Prior
    from retrodict.scene.speed_record import SpeedRecord

CONFIDENCE = 0.95  # of a bound
_MOMENTS = 400  # of an impact, over which the law of a recorded speed is a mean
_FEW = 10  # effective draws below which a share has bounds, and no standard error that tells much


@dataclass(frozen=True, slots=True)
class Probability:
    """How probable a proposition is (SI units).

    Args:
        proposition: the proposition, or the compound of several.
        value: share of the posterior draws in which it holds.
        error: Monte Carlo standard error; None where it holds in none of the draws, or in all.
        at_least, at_most: lower and upper bound, each of confidence `CONFIDENCE`, by the effective
            number of draws.
        effective: number of independent draws that would have this error.
        pareto_k: Pareto k of the importance weights; None for a method without weights.
    """

    proposition: Proposition
    value: float
    error: float | None
    at_least: float
    at_most: float
    effective: float
    pareto_k: float | None

    @property
    def few(self) -> bool:
        """Whether so few draws hold it, or do not, that its bounds tell more than its error."""
        return self.error is None or self.effective * min(self.value, 1 - self.value) < _FEW


@dataclass(frozen=True, slots=True)
class LikelihoodRatio:
    """How many times better one proposition explains the evidence than another.

    Args:
        first, second: posterior probabilities of the two propositions.
        prior_first, prior_second: prior probabilities of the two propositions.
        prior: the prior of the speed, in words.
        value: posterior odds over prior odds; where `bound` says so, a bound of confidence `CONFIDENCE`.
        error: Monte Carlo standard error of the natural logarithm of `value`; None for a bound.
        bound: "" (`value` is the ratio), "at least" or "at most".
    """

    first: Probability
    second: Probability
    prior_first: float
    prior_second: float
    prior: str
    value: float
    error: float | None
    bound: Literal["", "at least", "at most"]


def probability(outcome: Outcome, proposition: Proposition) -> Probability:
    """How probable a proposition is, given the evidence.

    Args:
        outcome: the reconstruction.
        proposition: proposition about quantities that the outcome has draws of.

    Returns:
        The share of the draws in which it holds. Its error is that of a mean of correlated draws
        (Vehtari et al. 2021), its bounds are those of Clopper and Pearson (1934) for as many
        independent ones; where it holds in none of n, the upper is 1 - 0.05^(1/n).

    Raises:
        NotAnswered: the model has no such quantity.
    """
    return _probability(outcome, proposition, partial(draws_of, outcome))


def _probability(
    outcome: Outcome, proposition: Proposition, values: Callable[[str], np.ndarray]
) -> Probability:
    holds = proposition.holds_for(values).astype(float)
    value, error = float(holds.mean()), None
    if min(holds.sum(), (1 - holds).sum()) >= _FEW:
        error = error_of_mean(holds)
        effective = value * (1 - value) / error**2
    else:  # too few to tell how they are correlated
        effective = min(_effective(draws) for draws in proposition.compared(values))
        if 0 < value < 1:
            error = math.sqrt(value * (1 - value) / effective)
    return bounded(proposition, value, error, effective, outcome.checks.pareto_k)


def _effective(draws: np.ndarray) -> float:
    """Effective draws of a quantity; infinite for one that is exact."""
    found = effective_draws(draws)
    return found if math.isfinite(found) else math.inf


def bounded(
    proposition: Proposition,
    value: float,
    error: float | None,
    effective: float,
    pareto_k: float | None,
) -> Probability:
    """A share of draws with its bounds, by so many independent ones; arguments as of `Probability`."""
    from scipy.stats import beta  # slow to import

    if math.isinf(effective):
        low = high = value
    else:
        count = value * effective
        low = float(beta.ppf(1 - CONFIDENCE, count, effective - count + 1)) if value > 0 else 0.0
        high = float(beta.ppf(CONFIDENCE, count + 1, effective - count)) if value < 1 else 1.0
    return Probability(proposition, value, error, low, high, effective, pareto_k)


def likelihood_ratio(outcome: Outcome, comparison: Comparison) -> LikelihoodRatio:
    """How many times more probable the evidence is under one proposition about a speed than another.

    Under each proposition the speed has the model's prior, cut to it; all else has the model's prior.
    The ratio is then (P(first | evidence) / P(second | evidence)) / (P(first) / P(second)), by Bayes'
    theorem. That the vehicles came together at the contact is part of the evidence.

    Args:
        outcome: the reconstruction.
        comparison: two propositions about one speed before the impact.

    Returns:
        The ratio, or a bound where almost no draw satisfies one of them.

    Raises:
        NotAnswered: the speed is exact or has no draws, the prior excludes a proposition, or
            almost no draw satisfies either.
    """
    name = comparison.first.name
    draws = draws_of(outcome, name)
    both = (comparison.first, comparison.second)
    first, second = (_probability(outcome, each, lambda _: draws) for each in both)
    prior, words = _prior(outcome, name)
    priors = [prior(each) for each in both]
    for each, share in zip((first, second), priors, strict=True):
        if not share > 0:
            raise NotAnswered(
                f'the prior ({words}) excludes "{each.proposition.text}": no evidence could speak for '
                "it; compare propositions that were possible"
            )
    odds = priors[0] / priors[1]
    rare = [each.few and each.value < 0.5 for each in (first, second)]
    if all(rare):
        raise NotAnswered(
            f'hardly a posterior draw holds "{first.proposition.text}" or "{second.proposition.text}": '
            "compare propositions nearer to the answer"
        )
    error: float | None = None
    bound: Literal["", "at least", "at most"] = ""
    if rare[1]:
        value, bound = first.value / second.at_most, "at least"
    elif rare[0]:
        value, bound = first.at_most / second.value, "at most"
    else:
        value = first.value / second.value
        holds = [
            each.holds(draws) / found.value - 1
            for each, found in zip(both, (first, second), strict=True)
        ]  # to first order, what a draw adds to the logarithm of each share
        error = error_of_mean(holds[0] - holds[1])
    return LikelihoodRatio(first, second, priors[0], priors[1], words, value / odds, error, bound)


def _prior(outcome: Outcome, name: str) -> tuple[Callable[[Proposition], float], str]:
    """Prior probability of propositions about a speed, and the prior in words."""

    speed = name.removeprefix("travelling_")
    scene = outcome.scene
    measured = scene.inputs().get(speed)
    if measured is None:
        prior = scene.priors[speed]
        law, words = _law_of_prior(speed, prior), prior.text
    elif measured.sd == 0:
        raise NotAnswered(f"{speed} is taken as exact: no evidence speaks of it")
    elif (record := scene.approach[speed[-1]].record) is not None:
        law = _OfRecord(record, cut=speed == "speed_b")
        words = f"as recorded from {record.low:g} to {record.high:g} s, ± {record.sd:.2g} m/s"
    else:
        law, words = _law_of(measured, cut=speed == "speed_b")
    if name == speed:
        return lambda each: float(law.cdf(each.high) - law.cdf(each.low)), words

    # v0² = v² + K: the mean over the prior's draws of K, which do not depend on v
    if "prior" not in outcome.idata.children or name not in outcome.idata["prior"].data_vars:
        raise NotAnswered(f"no draws of the prior of {name} were kept")
    drawn = outcome.idata["prior"]
    gained = np.asarray(drawn[name]).ravel() ** 2 - np.asarray(drawn[speed]).ravel() ** 2

    def below(limit: float) -> float:
        if limit == math.inf:
            return 1.0
        return float(law.cdf(np.sqrt(np.maximum(max(limit, 0.0) ** 2 - gained, 0.0))).mean())

    return lambda each: below(each.high) - below(each.low), f"{words}, and the prior of the skid"


def _law_of_prior(speed: str, prior: Prior) -> Any:
    """The prior of a speed, as the model has it: a law with a `cdf`."""
    from scipy import stats

    match prior.family:
        case "":
            return stats.halfnorm(scale=prior.numbers[0])
        case "normal":
            mean, sd = prior.numbers
            return _law_of(Measured(mean, sd), cut=True)[0]
        case "lognormal":
            mean, sd = prior.numbers
            return _law_of(Measured(mean, sd, law="lognormal"), cut=True)[0]
        case "uniform":
            low, high = prior.numbers
            return stats.uniform(low, high - low)
        case "python":
            from retrodict.models.priors import Cut  # a stored result is read without JAX

            return Cut(prior.law, 0.0, math.inf)
    raise NotAnswered(f"{speed} is fixed by its prior: no evidence speaks of it")


class _OfRecord:
    """The law of a speed of which the recorder's time zero is uncertain, as the model has it."""

    def __init__(self, record: SpeedRecord, cut: bool) -> None:
        from scipy import stats

        moments = record.low + (np.arange(_MOMENTS) + 0.5) / _MOMENTS * (record.high - record.low)
        speeds = np.interp(moments, record.times, record.speeds)
        low = -speeds / record.sd if cut else -math.inf
        self._each = stats.truncnorm(low, math.inf, speeds, record.sd)

    def cdf(self, speed: np.ndarray | float) -> np.ndarray:
        """Probability of lower speeds, the mean over the possible moments of the impact."""
        return self._each.cdf(np.asarray(speed)[..., None]).mean(-1)


def _law_of(m: Measured, cut: bool) -> tuple[Any, str]:
    """The law of a measured speed, as the model has it: of B cut at zero."""
    from scipy import stats

    words = f"as measured, {m.law}, {m.value:.4g} ± {m.sd:.2g} m/s"
    if m.law == "lognormal":
        scale = math.sqrt(math.log1p((m.sd / m.value) ** 2))
        return stats.lognorm(scale, scale=m.value * math.exp(-(scale**2) / 2)), words
    low = -m.value / m.sd if cut else -math.inf
    return stats.truncnorm(low, math.inf, m.value, m.sd), words
