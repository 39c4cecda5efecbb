"""Importance sampling from a normal with heavy tails in the flattened coordinates: no chain, no warm-up.

Where its weights are too uneven, or the posterior is wider, further draws come from another, with the
weighted mean and covariance of all draws so far and heavier tails, and so on
(Cornuet et al. 2012, adaptive multiple importance sampling). The answer is the last round's alone,
weighted by a proposal that no draw of its own has shaped: all rounds, weighted by the mixture of their
proposals, were off by 0.05 sd on a skewed normal of known mean. Written out here: no library of those
this project uses has it, and it is a dozen lines.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from scipy.special import logsumexp

from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.samplers.draws import Draws, Task
from retrodict.inference.samplers.nested import Nested, nested
from retrodict.inference.samplers.proposal import HEAVY, Proposal
from retrodict.inference.samplers.psis import (
    MAX_PARETO_K,
    effective,
    judged,
    log_mean,
    resampled,
    smoothed,
)
from retrodict.inference.threads import one_blas_thread
from retrodict.scene.quantities import REPORTED, describe

# Rounds of adaptation at most; of a later adaptation, which begins from where the first ended, and of
# the only one for a solution of little weight.
_ROUNDS, _LATER_ROUNDS = 10, 3
_EVEN, _SHARE = 0.6, 1 / 3  # Pareto k and effective share of draws at which no round follows
# Effective draws of all rounds, for each coordinate, at which no round follows, however uneven the
# weights: mean and covariance are then known as well as they need be.
_KNOWN = 30.0
# Largest ratio of a variance of the posterior, along any line, to that of the last proposal at which
# even weights end the rounds, over the ratio that so few draws of a proposal that fits would show. (A
# Pareto k shows nothing of what was never drawn: at 1.27 means were 0.1 sd off with an effective half of
# the draws.)
_OUTGROWN = 1.1
_FOR_EVIDENCE, _HELD_AGAINST = 2000, 2000  # draws
# Largest error of an approximation's mean, or of its sd, over the posterior's sd. A quarter would be
# wrong; three Monte Carlo errors of the comparison, each of 0.03, are not to let that pass (at 0.2
# two of 500 random crashes passed, 0.26 off).
_OFF = 0.15
# Times as many points as draws were asked for, where their weights fall short; twice as many are kept.
_COUNT = 0.4  # effective points over draws, below which there are more points at once
_MOST, _MOST_PACED = 16, 8  # the latter where run-outs of vehicles that roll are integrated
# Points of each pilot by which the proposal is adapted: before the first draws, and where Pareto k is
# above its limit by so many times half as many points as draws.
_PILOT, _LATER_PILOT, _ADAPTED_AGAIN = 2048, 8192, 4


@dataclass(frozen=True)
class Evidence:
    """Log evidence of a posterior, with its standard error.

    Args:
        value: log evidence.
        error: standard error of the log evidence.
        faults: reasons not to rely on the value, in words.
    """

    value: float
    error: float
    faults: tuple[str, ...]


def draw(task: Task) -> Draws:
    """Draw from a proposal that pilots have adapted, weight by the posterior, resample."""
    rng = np.random.default_rng(task.seed)
    posterior = task.posterior
    rounds = _LATER_ROUNDS if task.slight else _ROUNDS
    return _extended(task, rng, _Points(*_proposal(posterior, rng, rounds)), 1)


def _proposal(
    posterior: Posterior, rng: np.random.Generator, rounds: int
) -> tuple[Proposal | Nested, int]:
    """The proposal for a posterior, and the density evaluations that it took."""
    if (found := nested(posterior)) is not None:
        return found, 0
    first = Proposal.first(posterior.size, HEAVY)
    pilot = adapted(posterior, first, lambda at: at.draw(_PILOT, rng), rounds)
    return pilot.next, pilot.evaluations


@dataclass(frozen=True)
class _Points:
    """Points drawn so far from a proposal, a row for each chain.

    Args:
        proposal: distribution that the points are drawn from.
        evaluations: number of density evaluations, those of the proposal's adaptation included.
        w: the points, shape (chains, points, q); None before any are drawn.
        log_weight: log importance weights of the points, shape (chains, points); None likewise.
        quantities: the model's quantities at the points, by name, each of shape (chains, points, ...).
    """

    proposal: Proposal | Nested
    evaluations: int
    w: np.ndarray | None = None
    log_weight: np.ndarray | None = None
    quantities: dict[str, np.ndarray] = field(default_factory=dict)

    def with_more(self, posterior: Posterior, chains: int, count: int, rng: Any) -> _Points:
        """The points with `count` more for each chain."""
        w, log_density = self.proposal.sampled(chains * count, rng)
        heights, quantities = evaluated(posterior, w)
        new = {"w": w, "log_weight": heights - log_density} | quantities
        rows = {name: v.reshape(chains, count, *v.shape[1:]) for name, v in new.items()}
        if self.w is not None:
            old = {"w": self.w, "log_weight": self.log_weight} | self.quantities
            rows = {name: np.concatenate([old[name], v], axis=1) for name, v in rows.items()}
        w, log_weight = rows.pop("w"), rows.pop("log_weight")
        evaluations = self.evaluations + (1 + self.proposal.evaluations) * len(heights)
        return _Points(self.proposal, evaluations, w, log_weight, rows)


def _extended(
    task: Task, rng: np.random.Generator, points: _Points, times: int, kept: int = 1
) -> Draws:
    """Draws chosen from `times` as many points as are asked for, or more where few of them count.

    Args:
        task: posterior, numbers of chains and draws, and callback.
        rng: random number generator of the draws.
        points: points drawn so far.
        times: number of points at first, as a multiple of the draws asked for.
        kept: number of draws kept, as a multiple of those asked for.
    """
    posterior, chains, draws = task.posterior, task.chains, task.draws * kept
    most = _MOST_PACED if posterior.programs.structure.paced else _MOST
    most = 1 if task.slight else most
    k = 0.0 if points.log_weight is None else smoothed(points.log_weight.ravel())[1]
    while True:
        at_first, short = points.proposal, times == _ADAPTED_AGAIN and k > MAX_PARETO_K
        if short and isinstance(at_first, Nested):  # more points alone would not settle it
            assert points.w is not None, "k is of points"
            assert points.log_weight is not None, "k is of points"
            every = points.w.reshape(-1, points.w.shape[2])
            moved = at_first.moved(every, points.log_weight.ravel())
            points = _Points(moved, points.evaluations)
        elif short and isinstance(at_first, Proposal):
            found = adapted(
                posterior, at_first, lambda at: at.draw(_LATER_PILOT, rng), _LATER_ROUNDS
            )
            points = _Points(found.next, points.evaluations + found.evaluations)
        have = 0 if points.w is None else points.w.shape[1]
        points = points.with_more(posterior, chains, times * task.draws - have, rng)
        w, log_weight = points.w, points.log_weight
        assert w is not None, "points were added"
        assert log_weight is not None, "points were added"
        weights, k = smoothed(log_weight.ravel())
        if times >= most or effective(weights) >= _COUNT * chains * draws:
            break
        times *= 2
    # each chain is a replicate of its own, so that R-hat has something to compare
    places = np.arange(weights.size).reshape(chains, -1)
    index = np.concatenate([own[resampled(weights[own], draws, rng)] for own in places])
    evidence, error = log_mean(log_weight.ravel())
    verdict = judged(k)
    verdict["attributes"] |= {
        "log_evidence": evidence, "log_evidence_sd": error, "evaluations": float(points.evaluations)
    }  # fmt: skip
    enough = effective(weights) >= _COUNT * chains * draws
    task.progress(1, 1)
    flat = {name: v.reshape(-1, *v.shape[2:])[index] for name, v in points.quantities.items()}
    return Draws(
        w.reshape(-1, w.shape[2])[index].reshape(chains, draws, -1),
        {"log_weight": log_weight.ravel()[index].reshape(chains, draws)},
        **verdict,
        quantities=flat,
        more=partial(_extended, task, rng, points, 2 * times, 2) if times < most else None,
        enough=enough,
    )


def log_evidence(
    posterior: Posterior, rng: np.random.Generator, draws: int = _FOR_EVIDENCE
) -> Evidence:
    """The evidence of a posterior, from the mean of its importance weights.

    Args:
        posterior: posterior whose evidence is estimated.
        rng: random number generator of the draws.
        draws: number of points.

    Returns:
        The log evidence, with a fault where the Pareto k of the weights is too high to rely on it.
    """
    _, log_weight, _, _ = weighted_points(posterior, draws, rng)
    return Evidence(*log_mean(log_weight), judged(smoothed(log_weight)[1])["faults"])


def disagreements(draws: dict[str, np.ndarray], task: Task) -> tuple[str, ...]:
    """Errors of draws by an approximation, compared with importance sampling of the posterior.

    (The weights of Laplace's own draws do not show them: a normal's few draws in a heavy tail passed a
    spread of three quarters of the posterior's.)

    Args:
        draws: the model's unknowns as drawn by the approximation, by name, each of shape (any,).
        task: task that the draws were made for.

    Returns:
        A sentence on the reported quantity whose mean or spread is off by the most, if by too much, or
        on why the comparison is unreliable; else empty.
    """
    chance = np.random.default_rng([task.seed, 5])
    _, log_weight, quantities, _ = weighted_points(task.posterior, _HELD_AGAINST, chance)
    weights, k = smoothed(log_weight)
    if faults := judged(k)["faults"]:
        return faults
    off, inside = {}, weights > 0
    weights = weights[inside]  # the others may lie where nothing is a number
    for name in [name for name in REPORTED if name in draws]:
        sure = quantities[name][inside]
        mean = float(weights @ sure)
        sd = float(np.sqrt(weights @ (sure - mean) ** 2))
        errors = [abs(draws[name].mean() - mean), abs(draws[name].std() - sd)]
        off[name] = float(np.max(errors)) / sd if sd > 0 else 0.0
    worst = max(off, key=lambda name: np.nan_to_num(off[name], nan=np.inf))
    if off[worst] <= _OFF:
        return ()
    return (
        f"{describe(worst)[0]}: the approximation is off by {off[worst]:.2f} standard deviations of the "
        f"posterior in its mean or its spread, more than {_OFF}",
    )


def weighted_points(
    posterior: Posterior, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray], int]:
    """Weighted draws from a proposal that pilots have adapted, not yet resampled.

    Args:
        posterior: posterior that the draws are weighted by.
        count: number of draws.
        rng: random number generator of the draws.

    Returns:
        The draws w, shape (count, q); the logs of their weights, shape (count,); the quantities there;
        and the number of points evaluated in all.
    """
    proposal, evaluations = _proposal(posterior, rng, _ROUNDS)
    found = _Points(proposal, evaluations).with_more(posterior, 1, count, rng)
    assert found.w is not None, "points were added"
    assert found.log_weight is not None, "points were added"
    quantities = {name: values[0] for name, values in found.quantities.items()}
    return found.w[0], found.log_weight[0], quantities, found.evaluations


@dataclass(frozen=True)
class Adapted:
    """Draws of the last round of an adaptation, and the proposal that results.

    Args:
        w: draws of the last round, shape (any, q).
        log_weight: log importance weights of the draws, shape (any,).
        quantities: the model's quantities at the draws, by name.
        evaluations: number of points evaluated in all rounds.
        next: proposal that the weighted draws of all rounds suggest.
    """

    w: np.ndarray
    log_weight: np.ndarray
    quantities: dict[str, np.ndarray]
    evaluations: int
    next: Proposal


def adapted(
    posterior: Posterior,
    first: Proposal,
    draw: Callable[[Proposal], np.ndarray],
    rounds: int = _ROUNDS,
) -> Adapted:
    """Rounds of draws, each from a proposal adapted to all before it, until their weights are even.

    Args:
        posterior: posterior that the draws are weighted by.
        first: proposal to begin with.
        draw: function that makes the draws of a round, shape (any, q), from its proposal.
        rounds: largest number of rounds.
    """
    proposals, evaluations = [first], 0
    every, log_densities = np.zeros((0, posterior.size)), np.zeros(0)
    with one_blas_thread():  # twice as fast (measured)
        while True:
            last = proposals[-1]
            w = draw(last)
            heights, quantities = evaluated(posterior, w)
            log_weight = heights - last.log_density(w)
            weights, k = smoothed(log_weight)
            even = k <= _EVEN and effective(weights) >= _SHARE * len(w)
            evaluations += len(w)
            every, log_densities = np.concatenate([every, w]), np.append(log_densities, heights)
            if len(proposals) > 1:
                mixture = logsumexp([p.log_density(every) for p in proposals], axis=0)
                weights, _ = smoothed(log_densities - mixture)
            mean, worth = weights @ every, effective(weights)
            spread = (every - mean).T @ ((every - mean) * weights[:, None])
            fits = even and last.outgrown(spread, worth) <= _OUTGROWN
            fits |= worth >= _KNOWN * posterior.size
            proposals.append(last.moved(mean, spread, worth))
            if fits or len(proposals) > rounds:
                return Adapted(w, log_weight, quantities, evaluations, proposals[-1])


def evaluated(posterior: Posterior, w: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Log densities and the model's quantities at points.

    Args:
        posterior: posterior that is evaluated.
        w: the points, shape (any, q).

    Returns:
        Log densities, shape (any,), and quantities by name; at a point without density, minus infinity
        and the quantities of another point, for its own may be NaN and spoil every sum.
    """
    heights, quantities = posterior.evaluate(w)
    inside = np.isfinite(heights)
    if inside.any() and not inside.all():
        index = np.where(inside, np.arange(len(w)), np.argmax(inside))
        quantities = {name: values[index] for name, values in quantities.items()}
    return np.where(inside, heights, -np.inf), quantities
