"""Laplace's approximation: a normal in the flattened coordinates, centred and whitened at the mode.

The coordinates are not linear in the unknowns, so neither is what comes out; how far it is from the
posterior, its importance weights tell: by their Pareto k, and by where they move the mean.
"""

from __future__ import annotations

import numpy as np

from retrodict.inference.methods.draws import Draws, Task
from retrodict.inference.methods.weights import judged, smoothed

_MOVED = 0.25  # standard deviations by which the weighted mean may differ


def draw(task: Task) -> Draws:
    """Draw from the normal approximation."""
    rng = np.random.default_rng(task.seed)
    n = task.posterior.size
    w = rng.standard_normal((task.chains, task.draws, n))
    log_weight = task.posterior.log_density(w.reshape(-1, n)) + np.sum(w.reshape(-1, n) ** 2, 1) / 2
    weights, k = smoothed(log_weight)
    verdict = judged(k)
    moved = float(np.linalg.norm(weights @ w.reshape(-1, n)))
    if not moved <= _MOVED:
        verdict["faults"] += (
            f"the weighted mean lies {moved:.2f} standard deviations from that of the approximation, "
            f"more than {_MOVED}",
        )
    return Draws(w, {"log_weight": log_weight.reshape(w.shape[:2])}, **verdict)
