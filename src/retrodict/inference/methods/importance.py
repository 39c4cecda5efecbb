"""Importance sampling from a Student-t in the flattened coordinates: no chain, no warm-up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from retrodict.inference.methods.draws import Draws, Task
from retrodict.inference.methods.weights import judged, resampled, smoothed

_FREEDOM = 20  # degrees of freedom: tails heavier than a normal's, at little cost in the middle


def draw(task: Task) -> Draws:
    """Draw from the proposal, weigh by the posterior, resample."""
    posterior, (chains, draws) = task.posterior, (task.chains, task.draws)
    n = posterior.size
    rng = np.random.default_rng(task.seed)
    scale = np.sqrt(_FREEDOM / rng.chisquare(_FREEDOM, (chains * draws, 1)))
    w = scale * rng.standard_normal((chains * draws, n))
    log_proposal = -(_FREEDOM + n) / 2 * np.log1p(np.sum(w**2, axis=1) / _FREEDOM)
    log_weight = posterior.log_density(w) - log_proposal
    weights, k = smoothed(log_weight)
    # each chain is a replicate of its own, so that R-hat has something to compare
    shares = weights.reshape(chains, draws)
    index = np.concatenate(
        [i * draws + resampled(share / share.sum(), rng) for i, share in enumerate(shares)]
    )
    task.progress(1, 1)
    return Draws(
        w[index].reshape(chains, draws, n),
        {"log_weight": log_weight.reshape(chains, draws)},
        **judged(k),
        more=lambda: draw(replace(task, draws=2 * draws)),
    )
