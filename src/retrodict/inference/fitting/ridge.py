"""The ridge of a posterior along e_m: a proposal that follows it where a normal about the peak does not.

The spins after the impact determine e_m times the spin that the force alone gives, so that the posterior
of both is a hyperbola. From the peak, e_m is moved step by step in either direction, and all else is
fitted anew by damped least squares: each step gives the mode and the covariance of all else given e_m
(nested Laplace approximations, Rue et al. 2009). Without the ridge the upper tail of e_m was missed: of
851 simulated crashes 32 had e_m above all 99 draws, where 9 are expected (`benchmarks.calibration`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.special import gammaln, logsumexp, softmax

from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.search import SUFFICIENT, Peak, Search, descended
from retrodict.models.standard_normal import sizes

_STEP, _MOST = 0.5, 8  # step of e_m's deviate; most steps in either direction
_FAR = 9.0  # drop of the log evidence below the highest at which the steps end
_SEARCH = Search(rounds=12, stride=2.0, still=0.05)  # at each step
_FREEDOM = 8.0  # degrees of freedom of the Student's t about each step
_LEAST = 0.1  # share of the draws that is divided equally among the steps


@dataclass(frozen=True)
class Step:
    """The posterior about one value of e_m.

    Args:
        u: deviates at the mode given e_m, shape (n,).
        tangent: change of the other deviates per deviate of e_m, shape (m,).
        root: Cholesky factor of the covariance of the other deviates given e_m, shape (m, m).
        log_evidence: log evidence given e_m by the Laplace approximation, up to a constant.
    """

    u: Float[np.ndarray, " n"]
    tangent: Float[np.ndarray, " m"]
    root: Float[np.ndarray, "m m"]
    log_evidence: float


@dataclass(frozen=True)
class Ridge:
    """A mixture of Student's t about steps along the ridge.

    Args:
        at: index of the deviate of e_m.
        steps: steps along the ridge.
    """

    at: int
    steps: tuple[Step, ...]

    @property
    def _shares(self) -> Float[np.ndarray, " steps"]:
        shares = softmax([step.log_evidence for step in self.steps])
        return (1 - _LEAST) * shares + _LEAST / len(shares)

    def draw(self, count: int, rng: np.random.Generator) -> Float[np.ndarray, "count n"]:
        """Draws of deviates, a number of `count`."""
        z = rng.standard_normal((count, self.steps[0].u.size))
        z *= np.sqrt(_FREEDOM / rng.chisquare(_FREEDOM, (count, 1)))
        return self._placed(z, rng.choice(len(self.steps), count, p=self._shares))

    def _placed(
        self, z: Float[np.ndarray, "count n"], of_step: Int[np.ndarray, " count"]
    ) -> Float[np.ndarray, "count n"]:
        """Draws about steps from draws about zero: the first coordinate along the ridge."""
        u = np.empty_like(z)
        for i, step in enumerate(self.steps):
            own = of_step == i
            moved = _STEP * z[own, :1]
            others = np.delete(step.u, self.at) + moved * step.tangent + z[own, 1:] @ step.root.T
            u[own] = np.insert(others, self.at, step.u[self.at] + moved[:, 0], axis=1)
        return u

    def log_density(self, u: Float[np.ndarray, "count n"]) -> Float[np.ndarray, " count"]:
        """Log density of the draws."""
        n, heights = u.shape[1], []
        constant = gammaln((_FREEDOM + n) / 2) - gammaln(_FREEDOM / 2)
        constant -= n / 2 * np.log(_FREEDOM * np.pi) + np.log(_STEP)
        for step in self.steps:
            off = u - step.u
            moved, others = off[:, self.at], np.delete(off, self.at, axis=1)
            z = (others - moved[:, None] * step.tangent) @ np.linalg.inv(step.root).T
            squares = (moved / _STEP) ** 2 + np.square(z).sum(axis=1)
            volume = np.log(np.diag(step.root)).sum()
            heights.append(constant - volume - (_FREEDOM + n) / 2 * np.log1p(squares / _FREEDOM))
        return logsumexp(heights, axis=0, b=self._shares[:, None])


def ridge_of(crashes: Crashes, peak: Peak) -> Ridge | None:
    """The ridge through a peak; None if the model has no e_m.

    Args:
        crashes: crashes that the model allows.
        peak: peak at which the ridge begins.
    """
    structure = crashes.programs.structure
    counts = sizes(crashes.programs.target.rung.impact, structure, crashes.data)
    if "e_m" not in counts:
        return None
    crashes = crashes.in_steps(SUFFICIENT)
    names = list(counts)
    at = sum(counts[name] for name in names[: names.index("e_m")])
    first = _step(at, peak.u, peak.residuals, peak.slopes)
    steps, last = [first], {_STEP: first, -_STEP: first}
    for _ in range(_MOST):
        starts = np.stack([_beyond(step, at, way) for way, step in last.items()])
        ends = descended(crashes, starts, _SEARCH, held=at)
        ways = list(last)
        last = {
            ways[own]: _step(at, *end)
            for own, *end in zip(*ends, strict=True)
            if np.isfinite(end[1]).all()
        }
        steps += last.values()
        least = max(step.log_evidence for step in steps) - _FAR
        last = {way: step for way, step in last.items() if step.log_evidence >= least}
        if not last:
            break
    return Ridge(at, tuple(steps))


def _beyond(step: Step, at: int, way: float) -> np.ndarray:
    """Deviates where the ridge would go on, were it straight."""
    others = np.delete(step.u, at) + way * step.tangent
    return np.insert(others, at, step.u[at] + way)


def _step(at: int, u: np.ndarray, residuals: np.ndarray, slopes: np.ndarray) -> Step:
    precision = np.eye(u.size) + slopes.T @ slopes
    others = np.delete(np.delete(precision, at, axis=0), at, axis=1)
    covariance = np.linalg.inv(others)
    height = -(u @ u + residuals @ residuals) / 2 - np.linalg.slogdet(others)[1] / 2
    tangent = -covariance @ np.delete(precision[:, at], at)
    return Step(u, tangent, np.linalg.cholesky(covariance), float(height))
