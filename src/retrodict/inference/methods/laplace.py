"""Laplace's approximation: a normal in the flattened coordinates, centred and whitened at the mode.

The coordinates are not linear in the unknowns, so neither is what comes out; how far it is from the
posterior, the Pareto k of its importance weights tells.
"""

from __future__ import annotations

import numpy as np

from retrodict.inference.methods.draws import Draws, Task
from retrodict.inference.methods.weights import judged, pareto_k


def draw(task: Task) -> Draws:
    """Draw from the normal approximation."""
    rng = np.random.default_rng(task.seed)
    n = task.posterior.size
    w = rng.standard_normal((task.chains, task.draws, n))
    log_weight = task.posterior.log_density(w.reshape(-1, n)) + np.sum(w.reshape(-1, n) ** 2, 1) / 2
    k = pareto_k(log_weight)
    return Draws(w, {"log_weight": log_weight.reshape(w.shape[:2])}, **judged(k))
