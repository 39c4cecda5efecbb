"""Importance weights: smoothed, judged, and turned into draws that count equally."""

from __future__ import annotations

from typing import Any

import numpy as np

MAX_PARETO_K = 0.7  # Vehtari et al. (2024): above, weighted means do not settle


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


def effective(weights: np.ndarray) -> float:
    """How many draws of equal weight say as much as these, whose weights sum to one."""
    return float(1 / np.sum(weights**2))


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
    """The verdict on a k: for the arguments of `Draws`."""
    faults: tuple[str, ...] = ()
    if not k <= MAX_PARETO_K:
        faults = (
            f"Pareto k {k:.2f} of the importance weights is above {MAX_PARETO_K}: the approximation "
            "misses part of the posterior",
        )
    return {"faults": faults, "attributes": {"pareto_k": k}}


def resampled(weights: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Indices of `count` draws, each as often as its weight asks (systematic resampling).

    In the order of the draws: copies of one follow each other, so an effective sample size made for
    chains counts them as it should.
    """
    total = weights.sum()
    if not total > 0:  # of none, or none finite, all are taken in turn; Pareto k shows it
        return np.arange(count) % weights.size
    steps = (rng.random() + np.arange(count)) / count
    return np.minimum(np.searchsorted(np.cumsum(weights / total), steps), weights.size - 1)
