"""Laplace's approximation: a normal in the flattened coordinates, centred and whitened at the mode.

The coordinates are not linear in the unknowns, so the draws of these are not normal. The Pareto k of
their importance weights, and a comparison with importance sampling, show how far they are off.
"""

from __future__ import annotations

import numpy as np

from retrodict.inference.samplers.draws import Draws, Task
from retrodict.inference.samplers.importance import disagreements
from retrodict.inference.samplers.psis import judged, smoothed


def draw(task: Task) -> Draws:
    """Draw from the normal approximation."""
    rng = np.random.default_rng(task.seed)
    n = task.posterior.size
    w = rng.standard_normal((task.chains, task.draws, n))
    log_density, quantities = task.posterior.evaluate(w.reshape(-1, n))
    log_weight = log_density + np.sum(w.reshape(-1, n) ** 2, 1) / 2
    verdict = judged(smoothed(log_weight)[1])
    verdict["faults"] = verdict["faults"] or disagreements(quantities, task)
    return Draws(
        w, {"log_weight": log_weight.reshape(w.shape[:2])}, **verdict, quantities=quantities
    )
