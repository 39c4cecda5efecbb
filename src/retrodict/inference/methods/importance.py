"""Importance sampling from a Student-t in the flattened coordinates: no chain, no warm-up."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gammaln

from retrodict.inference.methods.draws import Draws, Task
from retrodict.inference.methods.weights import judged, log_mean, resampled, smoothed
from retrodict.inference.posterior import Posterior

_FREEDOM = 20  # degrees of freedom: tails heavier than a normal's, at little cost in the middle
_FOR_EVIDENCE = 2000  # draws


@dataclass(frozen=True)
class Evidence:
    """Log of the mean weight.

    Args:
        value: of the log evidence.
        error: its standard error.
        faults: for which it must not be relied on.
    """

    value: float
    error: float
    faults: tuple[str, ...]


def draw(task: Task) -> Draws:
    """Draw from the proposal, weigh by the posterior, resample."""
    posterior, (chains, draws) = task.posterior, (task.chains, task.draws)
    rng = np.random.default_rng(task.seed)
    w, log_weight, sites = weighed(posterior, chains * draws, rng)
    weights, k = smoothed(log_weight)
    # each chain is a replicate of its own, so that R-hat has something to compare
    shares = weights.reshape(chains, draws)
    sums = shares.sum(axis=1, keepdims=True)  # of none, or none finite, all are taken; k tells
    shares = np.where(sums > 0, shares / np.where(sums > 0, sums, 1.0), 1 / draws)
    index = np.concatenate([i * draws + resampled(share, rng) for i, share in enumerate(shares)])
    task.progress(1, 1)
    return Draws(
        w[index].reshape(chains, draws, -1),
        {"log_weight": log_weight.reshape(chains, draws)},
        **judged(k),
        sites={name: values[index] for name, values in sites.items()},
        more=lambda: draw(replace(task, draws=2 * draws)),
    )


def log_evidence(posterior: Posterior, rng: np.random.Generator) -> Evidence:
    """The evidence of a posterior, by the mean of its importance weights.

    Args:
        posterior: whose evidence it is.
        rng: of the draws.

    Returns:
        The evidence; at fault where the weights have no variance to judge it by.
    """
    _, log_weight, _ = weighed(posterior, _FOR_EVIDENCE, rng)
    return Evidence(*log_mean(log_weight), judged(smoothed(log_weight)[1])["faults"])


def weighed(
    posterior: Posterior, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Draws from the proposal, not yet resampled.

    Args:
        posterior: whose weights they carry.
        count: of draws.
        rng: of the draws.

    Returns:
        w, shape (count, q), the logs of their weights, and the model's unknowns there.
    """
    n = posterior.size
    scale = np.sqrt(_FREEDOM / rng.chisquare(_FREEDOM, (count, 1)))
    w = scale * rng.standard_normal((count, n))
    log_proposal = -(_FREEDOM + n) / 2 * np.log1p(np.sum(w**2, axis=1) / _FREEDOM)
    log_proposal += gammaln((_FREEDOM + n) / 2) - gammaln(_FREEDOM / 2)
    log_proposal -= n / 2 * np.log(_FREEDOM * np.pi)
    log_density, sites = posterior.weighed(w)
    return w, log_density - log_proposal, sites
