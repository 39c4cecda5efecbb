"""Randomised quasi-Monte Carlo: scrambled Sobol points, and the errors that scramblings show.

Points that fill space evenly leave means of smooth functions with less error than independent draws
(Owen 1997). Each scrambling is unbiased by itself, and their spread is the error of their mean, but no
more than independent draws of the same weights would leave: the spread of a few scramblings is off by
chance, and the largest of many quantities by a lot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from retrodict.inference.pareto import weighted_quantiles

Values = Float[np.ndarray, " points"]
_INSIDE = (
    2.0**-33
)  # how near a point may be to a face of the cube, where normal quantiles are infinite


def scrambled(
    size: int, count: int, scramblings: int, seed: int
) -> Float[np.ndarray, "points size"]:
    """Points of the unit cube, those of each scrambling in a row.

    Args:
        size: dimension of the cube.
        count: number of points in each scrambling, a power of two.
        scramblings: number of independent scramblings.
        seed: integer seed of the scramblings.
    """
    from scipy.stats.qmc import Sobol  # slow to import

    own = np.random.default_rng([seed, size]).spawn(scramblings)
    points = np.concatenate([Sobol(size, rng=rng).random(count) for rng in own])
    return np.clip(points, _INSIDE, 1 - _INSIDE)


@dataclass(frozen=True)
class Weighted:
    """Weights of draws from several scramblings, one scrambling after the other.

    Args:
        weights: weight of each draw, shape (points,); they sum to one.
        scramblings: number of scramblings, at least two.
    """

    weights: Values
    scramblings: int

    def mean(self, values: Values) -> tuple[float, float]:
        """The mean of a quantity, and its standard error."""
        return self._with_error(values)

    def sd(self, values: Values) -> tuple[float, float]:
        """The standard deviation of a quantity, and its standard error to first order."""
        middle = self.weights @ values
        variance, error = self._with_error((values - middle) ** 2)
        sd = float(np.sqrt(variance))
        return sd, error / (2 * sd) if sd > 0 else 0.0

    def quantiles(
        self, values: Values, levels: Float[np.ndarray, " levels"]
    ) -> tuple[Float[np.ndarray, " levels"], Float[np.ndarray, " levels"]]:
        """Quantiles of a quantity, and the standard error of the probability below each.

        Args:
            values: the quantity at each draw, shape (points,).
            levels: probabilities between 0 and 1, shape (levels,).
        """
        found = weighted_quantiles(self.weights, values, levels)
        return found, np.array([self._with_error(values <= limit)[1] for limit in found])

    def _with_error(self, values: np.ndarray) -> tuple[float, float]:
        mean = float(self.weights @ values)
        # a ratio of two means, each off by chance: to first order (Owen 2013, section 9.2)
        terms = self.weights * (values - mean)
        off = terms.reshape(self.scramblings, -1).sum(axis=1)
        spread = self.scramblings / (self.scramblings - 1) * np.sum((off - off.mean()) ** 2)
        alone = np.sum(terms**2)  # by independent draws
        return mean, float(np.sqrt(min(spread, alone)) / self.weights.sum())
