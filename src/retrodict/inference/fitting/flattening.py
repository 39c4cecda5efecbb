"""Coordinates about a mode in standard normal deviates: along the pinned directions, bent with them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.quadratic import as_quadratic, least_squares, terms
from retrodict.inference.fitting.search import Peak
from retrodict.inference.transforms.parameters import Flattening, Quadratic
from retrodict.inference.transforms.standard import pinned_of, unbent

_ROUNDS, _LEAST, _EACH = 3, 2048, 3  # fits; least crashes of a fit; crashes for each coefficient
_WIDE = 1.2  # standard deviations of these crashes
_NEAR = 6.0  # error of the fit in a residual over which a crash loses its weight
_PINNED = 2.0  # change of the residuals per deviate above which evidence pins a direction

Points = Float[np.ndarray, "points n"]


def flattened(crashes: Crashes, peak: Peak, seed: int) -> Flattening:
    """A flattening about a peak, fitted to crashes about it.

    Args:
        crashes: crashes that the model allows.
        peak: mode of the posterior.
        seed: integer seed of the crashes.
    """
    n, rng = peak.u.size, np.random.default_rng([seed, 7])
    flat = straight(crashes, peak)
    return bent(crashes, peak, flat, lambda count: _WIDE * rng.standard_normal((count, n)), _ROUNDS)


def straight(crashes: Crashes, peak: Peak) -> Flattening:
    """A flattening about a peak without a shear; arguments as of `flattened`."""
    n, items = peak.u.size, pinned_of(crashes.programs.structure)
    _, s, directions = np.linalg.svd(peak.slopes)
    sd = np.append(1 / np.sqrt(1 + s[:items] ** 2), np.ones(n - items))
    return unbent(peak.u, directions.T * sd, items)


def bent(
    crashes: Crashes,
    peak: Peak,
    flat: Flattening,
    draw: Callable[[int], Points],
    rounds: int = 1,
) -> Flattening:
    """A flattening whose shear is fitted to the crashes at points v.

    Args:
        crashes: crashes that the model allows.
        peak: peak that the flattening is about, whose slopes determine the axes.
        flat: flattening before the fit.
        draw: function from a number of points to points v of that number, shape (points, n).
        rounds: number of fits, each at new points.
    """
    across, s, _ = np.linalg.svd(peak.slopes)
    pinned, items = int((s > _PINNED).sum()), flat.bend.constant.size
    n = peak.u.size
    if not 0 < pinned < n:
        return flat
    across, s = across[:, :pinned], s[:pinned]
    by_v = s / np.sqrt(1 + s**2)
    for _ in range(rounds):
        v = draw(max(_LEAST, _EACH * (n - pinned + 2) ** 2 // 2))
        residuals = crashes.residuals(flat.deviates(v, np)) @ across
        missed = residuals - (peak.residuals @ across + by_v * v[:, :pinned])
        worst = np.abs(missed).max(axis=1)
        weight = np.where(np.isfinite(worst), np.exp(-0.25 * (worst / _NEAR) ** 2), 0.0)
        shift = flat.deviates(v, np) - peak.u  # next expressed along the axes
        shift = np.linalg.solve(flat.axes, shift.T).T[:, :pinned] - v[:, :pinned]
        wanted = shift - np.nan_to_num(missed) * by_v
        own = as_quadratic(
            least_squares(terms(v[:, pinned:]), wanted, np.nan_to_num(weight)), n - pinned
        )
        constant, linear = np.zeros(items), np.zeros((items, n))
        quadratic = np.zeros((items, n, n))
        constant[:pinned], linear[:pinned, pinned:] = own.constant, own.linear
        quadratic[:pinned, pinned:, pinned:] = own.quadratic
        flat = flat._replace(bend=Quadratic(constant, linear, quadratic))
    return flat
