"""Importance weights: smoothed, judged, and turned into draws that count equally."""

from __future__ import annotations

from typing import Any

import numpy as np

from retrodict.inference.pareto import MAX_PARETO_K, smoothed

__all__ = ["MAX_PARETO_K", "effective", "judged", "log_mean", "resampled", "smoothed"]


def effective(weights: np.ndarray) -> float:
    """Effective sample size of draws whose weights sum to one."""
    return float(1 / np.sum(weights**2))


def log_mean(log_weight: np.ndarray) -> tuple[float, float]:
    """Log of the mean weight, which is the evidence, and its standard error to first order.

    Args:
        log_weight: log importance weight of each draw, constants included; -inf outside the support.
    """
    highest = log_weight.max()
    if highest == -np.inf:
        return -np.inf, np.inf
    weight = np.exp(log_weight - highest)
    error = weight.std(ddof=1) / weight.mean() / np.sqrt(weight.size)
    return float(highest + np.log(weight.mean())), float(error)


def judged(k: float) -> dict[str, Any]:
    """Verdict on a Pareto k, as keyword arguments of `Draws`."""
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
    if not total > 0:  # all zero, or not finite: draws are taken in turn; Pareto k shows it
        return np.arange(count) % weights.size
    steps = (rng.random() + np.arange(count)) / count
    return np.minimum(np.searchsorted(np.cumsum(weights / total), steps), weights.size - 1)
