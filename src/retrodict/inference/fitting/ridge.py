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
from jaxtyping import Float
from scipy.special import gammaln, logsumexp, softmax

from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.search import Peak
from retrodict.models.standard_normal import sizes

_STEP, _MOST = 0.5, 8  # step of e_m's deviate; most steps in either direction
_FAR = 9.0  # drop of the log evidence below the highest at which the steps end
# search at each step: rounds, longest move, decrease of the sum of squares at which it ends
_ROUNDS, _STRIDE, _STILL = 12, 2.0, 1e-2
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
        n = self.steps[0].u.size
        of_step = rng.choice(len(self.steps), count, p=self._shares)
        z = rng.standard_normal((count, n))
        z *= np.sqrt(_FREEDOM / rng.chisquare(_FREEDOM, (count, 1)))
        u = np.empty((count, n))
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
    names = list(counts)
    at = sum(counts[name] for name in names[: names.index("e_m")])
    first = _step(at, peak.u, peak.residuals, peak.slopes)
    steps = [first]
    for way in (_STEP, -_STEP):
        last = first
        for _ in range(_MOST):
            u = np.insert(np.delete(last.u, at) + way * last.tangent, at, last.u[at] + way)
            found = _sought(crashes, at, u)
            if found is None:
                break
            last = found
            steps.append(found)
            if found.log_evidence < max(step.log_evidence for step in steps) - _FAR:
                break
    return Ridge(at, tuple(steps))


def _sought(crashes: Crashes, at: int, u: np.ndarray) -> Step | None:
    """The step at a value of e_m, from a crash near it; None where there is no crash."""
    (residuals,), (slopes,) = crashes.linearised(u[None])
    if not np.isfinite(residuals).all():
        return None
    damping, potential = 1e-3, u @ u + residuals @ residuals
    for _ in range(_ROUNDS):
        own = np.delete(slopes, at, axis=1)
        normal = own.T @ own + (1 + damping) * np.eye(u.size - 1)
        move = np.linalg.solve(normal, -(np.delete(u, at) + own.T @ residuals))
        move *= min(1.0, _STRIDE / max(float(np.linalg.norm(move)), 1e-300))
        there = u + np.insert(move, at, 0.0)
        (residuals_there,), (slopes_there,) = crashes.linearised(there[None])
        gained = potential - there @ there - residuals_there @ residuals_there
        if not gained > 0:  # nor where there is no crash
            damping = max(8 * damping, 1e-2)
            continue
        u, residuals, slopes, potential = there, residuals_there, slopes_there, potential - gained
        damping = max(damping / 5, 1e-6)
        if gained < _STILL:
            break
    return _step(at, u, residuals, slopes)


def _step(at: int, u: np.ndarray, residuals: np.ndarray, slopes: np.ndarray) -> Step:
    precision = np.eye(u.size) + slopes.T @ slopes
    others = np.delete(np.delete(precision, at, axis=0), at, axis=1)
    covariance = np.linalg.inv(others)
    height = -(u @ u + residuals @ residuals) / 2 - np.linalg.slogdet(others)[1] / 2
    tangent = -covariance @ np.delete(precision[:, at], at)
    return Step(u, tangent, np.linalg.cholesky(covariance), float(height))
