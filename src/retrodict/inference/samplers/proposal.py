"""The proposal about a mode of importance sampling: a normal with heavy tails."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np
from scipy.special import chdtri, gammaln, logsumexp, ndtri

# Scale of wide axes over `sd`, at most, for a skew's wider half.
_SKEWED = 1.25


class Tails(NamedTuple):
    """Tails of a proposal: a Student-t beside the normal.

    Args:
        share: share of the draws that are of the Student-t, from 0 to 1.
        freedom: degrees of freedom of the Student-t.
    """

    share: float
    freedom: float


# Light tails leave 0.30 of the draws effective, and a Pareto k of up to 0.70, heavy ones 0.17 and 0.63
# (medians and largest of six seeds of seven scenes of users): a session, which knows where the posterior
# is, takes half the time by light ones. Heavy ones show a second mode that nobody sought.
LIGHT, HEAVY = Tails(0.2, 4.0), Tails(1.0, 4.0)


@dataclass(frozen=True)
class Proposal:
    """A multivariate normal, mixed with a Student-t for a share of the draws.

    Args:
        middle: location of both, shape (q,).
        axes: orthonormal columns, the widest first, shape (q, q).
        sd: standard deviation of the posterior along each axis, as far as is known, shape (q,).
        tails: Student-t of a share of the draws.
        worth: number of effective draws that `axes` and `sd` count for beside new draws.
    """

    middle: np.ndarray
    axes: np.ndarray
    sd: np.ndarray
    tails: Tails
    worth: float
    evaluations: ClassVar[int] = 0
    """Density evaluations that a draw takes."""

    @classmethod
    def first(cls, n: int, tails: Tails) -> Proposal:
        """First proposal, for n coordinates in which a posterior is near a standard normal."""
        return cls(np.zeros(n), np.eye(n), np.ones(n), tails, 2.0 * n)

    @property
    def _scale(self) -> np.ndarray:
        """Scale of draws along each axis: above `sd` where the posterior is wider than at its mode."""
        return self.sd * np.clip(np.sqrt(self.sd), 1, _SKEWED)

    def draw(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Independent draws, shape (count, q)."""
        share, freedom = self.tails
        in_tails = rng.permutation(count)[:, None] < share * count
        tails = np.sqrt(freedom / rng.chisquare(freedom, (count, 1)))
        return self._placed(rng.standard_normal((count, self.middle.size)), in_tails, tails)

    def sampled(self, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Independent draws, shape (count, q), and their log densities."""
        w = self.draw(count, rng)
        return w, self.log_density(w)

    def at(self, u: np.ndarray) -> np.ndarray:
        """Draws from points within the unit cube, of which the last two coordinates make the tails.

        Args:
            u: points of the unit cube, shape (any, q + 2).
        """
        share, freedom = self.tails
        in_tails = u[:, -1:] < share
        tails = np.sqrt(freedom / chdtri(freedom, u[:, -2:-1]))
        return self._placed(ndtri(u[:, :-2]), in_tails, tails)

    def _placed(self, z: np.ndarray, in_tails: np.ndarray, tails: np.ndarray) -> np.ndarray:
        """Draws from standard normal ones, of which those in the tails are scaled up by `tails`."""
        z *= np.where(in_tails, tails, 1.0)
        return self.middle + (z * self._scale) @ self.axes.T

    def log_density(self, w: np.ndarray) -> np.ndarray:
        """Log density at points, shape (any,)."""
        n, (share, freedom) = self.sd.size, self.tails
        squares = (((w - self.middle) @ self.axes / self._scale) ** 2).sum(axis=1)
        normal = -n / 2 * np.log(2 * np.pi) - squares / 2
        tails = gammaln((freedom + n) / 2) - gammaln(freedom / 2) - n / 2 * np.log(freedom * np.pi)
        tails = tails - (freedom + n) / 2 * np.log1p(squares / freedom)
        both = logsumexp([normal, tails], axis=0, b=[[1 - share], [share]])
        return both - np.log(self._scale).sum()

    def outgrown(self, spread: np.ndarray, effective: float) -> float:
        """Largest ratio of a covariance to the proposal's, over that which chance gives so few draws."""
        whitened = (self.axes / self.sd).T @ spread @ (self.axes / self.sd)
        # the edge of the spectrum of a sample of the standard normal (Marchenko and Pastur 1967)
        margin = (1 + np.sqrt(self.sd.size / effective)) ** 2
        return float(np.linalg.eigvalsh(whitened)[-1] / margin)

    def moved(self, mean: np.ndarray, spread: np.ndarray, effective: float) -> Proposal:
        """The proposal moved towards a mean and a covariance, further for more effective draws."""
        share = effective / (effective + self.worth)
        scale = share * spread + (1 - share) * (self.axes * self.sd**2) @ self.axes.T
        share = effective / (effective + 2 * self.sd.size)
        middle = share * mean + (1 - share) * self.middle
        variances, axes = np.linalg.eigh(scale)
        return replace(self, middle=middle, axes=axes[:, ::-1], sd=np.sqrt(variances[::-1]))
