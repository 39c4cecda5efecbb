"""Importance weights: smoothed, judged, and turned into draws that count equally."""

from __future__ import annotations

from typing import Any

import numpy as np

from retrodict.scene.quantities import REPORTED, describe

MAX_PARETO_K = 0.7  # Vehtari et al. (2024): above, weighted means do not settle
# Of the posterior's sd: what an approximation's mean, or its sd, may be off by. A quarter would be
# wrong; the weights' own Monte Carlo error, some hundredths, is not to let that pass.
_OFF = 0.2


def smoothed(log_weight: np.ndarray) -> tuple[np.ndarray, float]:
    """Pareto-smoothed normalised weights, and the tail's shape k.

    Args:
        log_weight: of each draw, up to a constant; -inf for draws outside the support.

    Returns:
        Weights that sum to one, and k; infinite where the whole tail is copies of one draw, and where
        no draw lies in the support.
    """
    from arviz_stats.base import array_stats  # slow to import

    inside = np.isfinite(log_weight)
    if not inside.any():
        return np.full(inside.size, 1 / inside.size), np.inf
    if np.ptp(log_weight[inside]) < 1e-9:  # a proposal that is the target: there is no tail
        return inside / inside.sum(), 0.0
    # it takes what weights are the inverse of, a log likelihood
    log_weight = np.where(inside, log_weight, log_weight[inside].min())
    try:
        with np.errstate(all="ignore"):  # a tail of copies is met below
            log_smooth, k = array_stats.psislw(-log_weight)
    except ValueError:  # a tail of copies of one draw has no shape
        log_smooth, k = log_weight, np.inf
    # nor has one of a few draws that outweigh all others
    if np.isnan(k) or np.isnan(log_smooth).any():
        log_smooth, k = log_weight, np.inf
    weights = np.exp(log_smooth - np.max(log_smooth)) * inside
    return weights / weights.sum(), float(k)


def log_mean(log_weight: np.ndarray) -> tuple[float, float]:
    """Log of the mean weight, which is the evidence, and its standard error to first order.

    Args:
        log_weight: of each draw, in full; -inf for draws outside the support.
    """
    highest = log_weight.max()
    if highest == -np.inf:
        return -np.inf, np.inf
    weight = np.exp(log_weight - highest)
    error = weight.std(ddof=1) / weight.mean() / np.sqrt(weight.size)
    return float(highest + np.log(weight.mean())), float(error)


def judged(k: float) -> dict[str, Any]:
    """What to tell of a k: for the arguments of `Draws`."""
    faults: tuple[str, ...] = ()
    if not k <= MAX_PARETO_K:
        faults = (
            f"Pareto k {k:.2f} of the importance weights is above {MAX_PARETO_K}: the approximation "
            "misses part of the posterior",
        )
    return {"faults": faults, "attributes": {"pareto_k": k}}


def apart(
    draws: dict[str, np.ndarray], posterior: dict[str, np.ndarray], weights: np.ndarray
) -> tuple[str, ...]:
    """Whether an approximation leaves the posterior: one sentence, or none.

    Args:
        draws: of the approximation, the model's unknowns by name, each of shape (any,).
        posterior: the same of draws that carry weights.
        weights: of these, summing to one.

    Returns:
        Of the reported quantities the one whose mean or spread is off by the most, if by too much.
    """
    off, inside = {}, weights > 0
    weights = weights[inside]  # the others may lie where nothing is a number
    for name in [name for name in REPORTED if name in draws]:
        sure = posterior[name][inside]
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


def resampled(weights: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Indices of `count` draws, each as often as its weight asks (systematic resampling).

    In the order of the draws: copies of one follow each other, so an effective sample size made for
    chains counts them as it should.
    """
    total = weights.sum()
    if not total > 0:  # of none, or none finite, all are taken in turn; Pareto k tells
        return np.arange(count) % weights.size
    steps = (rng.random() + np.arange(count)) / count
    return np.minimum(np.searchsorted(np.cumsum(weights / total), steps), weights.size - 1)
