"""Slope and curvature of a density from its values alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

Heights = Callable[[Float[np.ndarray, "points n"]], Float[np.ndarray, " points"]]

_STEP = 1e-3  # of slopes, in coordinates of order one
_RISE = 0.05  # of the curvature's steps: the function's second differences are to be of this size


def slope(heights: Heights, w: Float[np.ndarray, " n"]) -> tuple[float, Float[np.ndarray, " n"]]:
    """A function's value and gradient, by central differences.

    Args:
        heights: the function at many points at once.
        w: where, shape (n,).

    Returns:
        Both.
    """
    steps = _STEP * np.eye(w.size)
    found = heights(np.concatenate([w[None], w + steps, w - steps]))
    ahead, behind = found[1:].reshape(2, -1)
    return float(found[0]), (ahead - behind) / (2 * _STEP)


def curvature(heights: Heights, w: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n n"]:
    """A function's Hessian by differences, with steps as long as the function's curvature asks.

    Args:
        heights: the function at many points at once.
        w: where, shape (n,).

    Returns:
        The Hessian, shape (n, n).
    """
    n = w.size
    i, j = np.triu_indices(n, k=1)
    h = np.full(n, _STEP)
    for _ in range(2):  # the diagonal, then once more with steps that suit it
        steps = np.diag(h)
        found = heights(np.concatenate([w[None], w + steps, w - steps]))
        here, (ahead, behind) = found[0], found[1:].reshape(2, -1)
        diagonal = (ahead + behind - 2 * here) / h**2
        h = np.sqrt(_RISE / np.clip(np.nan_to_num(diagonal), 1.0, 1e8))
    pairs = steps[i] + steps[j]
    both, neither = heights(np.concatenate([w + pairs, w - pairs])).reshape(2, -1)
    sums = ahead + behind
    H = np.diag(diagonal)
    of_steps = np.diag(steps)
    H[i, j] = (both + neither - sums[i] - sums[j] + 2 * here) / (2 * of_steps[i] * of_steps[j])
    return np.triu(H) + np.triu(H, 1).T
