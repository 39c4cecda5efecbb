"""Several peaks of one posterior, each with a share of the density about it; the shares sum to one.

So each part has one peak, is sampled by itself, and the parts are mixed by their evidence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.special import logsumexp

from retrodict.inference.fitting.search import Peak
from retrodict.inference.transforms.parameters import Flattening


@dataclass(frozen=True)
class Basin:
    """A peak with the coordinates about it.

    Args:
        peak: mode of the posterior.
        flattening: coordinates in which the posterior is near a standard normal about the peak.
    """

    peak: Peak
    flattening: Flattening

    def log_density(self, u: Float[np.ndarray, "points n"]) -> Float[np.ndarray, " points"]:
        """Log of the normal about the peak times the peak's evidence, but for a constant."""
        v = self.flattening.inverse(u)
        volume = float(self.flattening.log_volume)
        return self.peak.log_evidence - np.square(v).sum(axis=1) / 2 - volume


@dataclass(frozen=True)
class Basins:
    """The share of one of several peaks.

    Args:
        every: all peaks of the posterior.
        own: index of the one peak in `every`.
    """

    every: tuple[Basin, ...]
    own: int

    def log_share(self, u: Float[np.ndarray, "points n"]) -> Float[np.ndarray, " points"]:
        """Log of the share of the density that belongs to the peak.

        Args:
            u: deviates of crashes, shape (points, n).
        """
        heights = np.stack([basin.log_density(u) for basin in self.every])
        return heights[self.own] - logsumexp(heights, axis=0)
