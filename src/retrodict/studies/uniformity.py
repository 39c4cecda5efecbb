"""How evenly the ranks of a calibration lie: against simultaneous bands, and as coverage."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float

from retrodict.studies.calibration import DRAWS, Calibration

LEVELS = (50, 80, 90, 95)  # per cent
BAND = 0.95  # share of all samples that lie within the band everywhere

_SAMPLES = 2000  # simulated samples that the bands are found by


@dataclass(frozen=True, slots=True)
class Uniformity:
    """How evenly the ranks of a quantity lie.

    Args:
        at: cumulative probabilities, shape (n + 1,).
        difference: share of scaled ranks up to each of `at`, less `at`, shape (n + 1,).
        band: lower and upper edge of the simultaneous 95 % band of `difference`, shape (2, n + 1).
        inside: whether the ranks stay within the band.
        inside_jointly: whether the ranks stay within the wider band whose level all quantities share
            (Bonferroni).
        coverage: share of truths within the central interval, and its binomial standard error if the
            level is right, by level in per cent.
    """

    at: Float[np.ndarray, " points"]
    difference: Float[np.ndarray, " points"]
    band: Float[np.ndarray, "2 points"]
    inside: bool
    inside_jointly: bool
    coverage: dict[int, tuple[float, float]]


def uniformity(calibration: Calibration) -> dict[str, Uniformity]:
    """How evenly the ranks of each quantity lie, against simultaneous bands (Säilynoja et al. 2022).

    Args:
        calibration: the calibration, with the ranks of its simulations.

    Returns:
        By quantity; nothing where fewer than two simulations were ranked.
    """
    from arviz_stats.ecdf_utils import compute_ecdf  # slow to import

    rows, names = calibration.ranked, calibration.quantities
    n = len(rows)
    if n < 2:
        return {}
    ranks = np.array([[row.ranks[name] for name in names] for row in rows])
    # a rank stands for an interval: a point of it at random is uniform without steps
    rng = np.random.default_rng(calibration.seed)
    u = (ranks + rng.random(ranks.shape)) / (DRAWS + 1)
    grid = np.arange(1, n) / n
    band, jointly = _band(n, BAND), _band(n, 1 - (1 - BAND) / len(names))
    found = {}
    for name, values in zip(names, u.T, strict=True):
        ecdf = compute_ecdf(values, grid)
        found[name] = Uniformity(
            np.array([0.0, *grid, 1.0]),
            np.array([0.0, *(ecdf - grid), 0.0]),
            np.pad(band - grid, ((0, 0), (1, 1))),
            _within(ecdf, band),
            _within(ecdf, jointly),
            {
                level: (
                    float(np.mean(np.abs(values - 0.5) <= level / 200)),
                    float(np.sqrt(level * (100 - level) / n) / 100),
                )
                for level in LEVELS
            },
        )
    return found


def _within(ecdf: np.ndarray, band: np.ndarray) -> bool:
    return bool(np.all((band[0] <= ecdf) & (ecdf <= band[1])))


@cache
def _band(n: int, level: float) -> Float[np.ndarray, "2 points"]:
    """Edges that an ECDF of n uniform numbers stays within at 1/n, 2/n, …, with this probability."""
    from arviz_stats.ecdf_utils import get_pointwise_confidence_band, simulate_confidence_bands

    grid, rng = np.arange(1, n) / n, np.random.default_rng(0)
    pointwise = simulate_confidence_bands(n, 1, grid, level, _SAMPLES, rng)
    return np.array(get_pointwise_confidence_band(pointwise, n, grid))
