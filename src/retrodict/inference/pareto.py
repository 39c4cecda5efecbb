"""Importance weights, smoothed, and weighted quantiles: without JAX, for findings of stored results."""

from __future__ import annotations

import numpy as np

MAX_PARETO_K = 0.7  # Vehtari et al. (2024): above, weighted means do not settle


def smoothed(log_weight: np.ndarray) -> tuple[np.ndarray, float]:
    """Pareto-smoothed normalised weights, and the tail's shape k.

    Args:
        log_weight: log importance weight of each draw, up to a constant; -inf outside the support.

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
    # psislw takes minus the log weights, as log likelihoods are in leave-one-out
    log_weight = np.where(inside, log_weight, log_weight[inside].min())
    try:
        with np.errstate(all="ignore"):  # a tail of copies is met below
            log_smooth, k = array_stats.psislw(-log_weight)
    except ValueError:  # a tail of copies of one draw has no shape
        log_smooth, k = log_weight, np.inf
    # nor has a tail of a few draws that outweigh all others
    if np.isnan(k) or np.isnan(log_smooth).any():
        log_smooth, k = log_weight, np.inf
    weights = np.exp(log_smooth - np.max(log_smooth)) * inside
    return weights / weights.sum(), float(k)


def weighted_quantiles(
    weights: np.ndarray, values: np.ndarray, levels: np.ndarray | float
) -> np.ndarray:
    """Quantiles of weighted draws.

    Args:
        weights: weight of each draw, shape (draws,); they sum to one.
        values: value of each draw, shape (draws,).
        levels: probabilities between 0 and 1, of any shape.
    """
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - weights[order] / 2
    return np.asarray(np.interp(levels, below, values[order]))
