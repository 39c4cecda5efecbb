"""Importance sampling from a normal with heavy tails in the flattened coordinates: no chain, no warm-up.

Where its weights are too uneven, further draws come from Student-t's with the weighted mean and
covariance of all draws so far, and every draw is weighed against the mixture of all proposals
(Cornuet et al. 2012, adaptive multiple importance sampling). Written out here: no library of those
this project uses has it, and it is a dozen lines.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import gammaln, logsumexp

from retrodict.inference.methods.draws import Draws, Task
from retrodict.inference.methods.weights import judged, log_mean, resampled, smoothed
from retrodict.inference.posterior import Posterior
from retrodict.inference.threads import one_blas_thread

# Share of the draws in tails, and their degrees of freedom. In tens of coordinates a Student-t alone
# costs a quarter of the effective draws (measured); so first it is a fifth of the proposal, which
# bounds the weights as well, and all of it only for posteriors whose tails asked for more.
_FIRST, _LATER = (0.2, 4.0), (1.0, 8.0)
_ROUNDS = 10  # of adaptation, the first included
_EVEN, _SHARE = (
    0.6,
    1 / 3,
)  # Pareto k, and effective share of the draws, that ask for no other round
_FOR_EVIDENCE = 2000  # draws


@dataclass(frozen=True)
class Evidence:
    """Log of the mean weight.

    Args:
        value: of the log evidence.
        error: its standard error.
        faults: for which it must not be relied on.
    """

    value: float
    error: float
    faults: tuple[str, ...]


def draw(task: Task) -> Draws:
    """Draw from the proposal, weigh by the posterior, resample."""
    posterior, (chains, draws) = task.posterior, (task.chains, task.draws)
    rng = np.random.default_rng(task.seed)
    w, log_weight, told = weighed(posterior, chains * draws, rng)
    weights, k = smoothed(log_weight)
    # each chain is a replicate of its own, so that R-hat has something to compare; proposals are
    # shuffled, for draws of one stand for a part of the posterior only
    places = np.arange(weights.size).reshape(-1, chains, draws).swapaxes(0, 1).reshape(chains, -1)
    places = rng.permuted(places, axis=1)
    index = np.concatenate([own[resampled(weights[own], draws, rng)] for own in places])
    evidence, error = log_mean(log_weight)
    verdict = judged(k)
    verdict["attributes"] |= {
        "log_evidence": evidence, "log_evidence_sd": error, "evaluations": float(weights.size)
    }  # fmt: skip
    task.progress(1, 1)
    return Draws(
        w[index].reshape(chains, draws, -1),
        {"log_weight": log_weight[index].reshape(chains, draws)},
        **verdict,
        told={name: values[index] for name, values in told.items()},
        more=lambda: draw(replace(task, draws=2 * draws)),
    )


def log_evidence(posterior: Posterior, rng: np.random.Generator) -> Evidence:
    """The evidence of a posterior, by the mean of its importance weights.

    Args:
        posterior: whose evidence it is.
        rng: of the draws.

    Returns:
        The evidence; at fault where the weights have no variance to judge it by.
    """
    _, log_weight, _ = weighed(posterior, _FOR_EVIDENCE, rng)
    return Evidence(*log_mean(log_weight), judged(smoothed(log_weight)[1])["faults"])


def weighed(
    posterior: Posterior, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Draws from the proposals, not yet resampled.

    Args:
        posterior: whose weights they carry.
        count: of draws from each proposal.
        rng: of the draws.

    Returns:
        w, shape (rounds x count, q), the logs of their weights, and what is told there.
    """
    proposals = [_Proposal(np.zeros(posterior.size), np.eye(posterior.size), *_FIRST)]
    w, log_density = np.zeros((0, posterior.size)), np.zeros(0)
    told = []
    with one_blas_thread():  # twice as fast (measured)
        while True:
            new = proposals[-1].draw(count, rng)
            heights, found = posterior.weighed(new)
            heights = np.where(np.isfinite(heights), heights, -np.inf)  # nothing lies there
            w, log_density = np.concatenate([w, new]), np.concatenate([log_density, heights])
            told.append(found)
            densities = [p.log_density(w) for p in proposals]
            log_weight = log_density - logsumexp(densities, axis=0) + np.log(len(proposals))
            weights, k = smoothed(log_weight)
            effective = 1 / np.sum(weights**2)
            if len(proposals) == _ROUNDS or (k <= _EVEN and effective >= _SHARE * weights.size):
                return w, log_weight, {k: np.concatenate([t[k] for t in told]) for k in told[0]}
            proposals.append(proposals[-1].moved(w, weights, effective))


@dataclass(frozen=True)
class _Proposal:
    """A normal, and for a share of the draws a Student-t: their location, a root of their scale."""

    middle: np.ndarray
    root: np.ndarray
    share: float
    freedom: float

    def draw(self, count: int, rng: np.random.Generator) -> np.ndarray:
        in_tails = rng.permutation(count)[:, None] < self.share * count
        tails = np.sqrt(self.freedom / rng.chisquare(self.freedom, (count, 1)))
        z = rng.standard_normal((count, self.middle.size)) * np.where(in_tails, tails, 1.0)
        return self.middle + z @ self.root.T

    def log_density(self, w: np.ndarray) -> np.ndarray:
        n, freedom = self.middle.size, self.freedom
        z2 = np.sum(solve_triangular(self.root, (w - self.middle).T, lower=True) ** 2, axis=0)
        normal = -n / 2 * np.log(2 * np.pi) - z2 / 2
        tails = gammaln((freedom + n) / 2) - gammaln(freedom / 2) - n / 2 * np.log(freedom * np.pi)
        tails = tails - (freedom + n) / 2 * np.log1p(z2 / freedom)
        both = logsumexp([normal, tails], axis=0, b=[[1 - self.share], [self.share]])
        return both - np.log(np.diag(self.root)).sum()

    def moved(self, w: np.ndarray, weights: np.ndarray, effective: float) -> _Proposal:
        """Towards the mean and covariance of weighted draws, the further the more they say."""
        share = effective / (effective + 2 * self.middle.size)
        mean = weights @ w
        spread = (w - mean).T @ ((w - mean) * weights[:, None])
        scale = share * spread + (1 - share) * self.root @ self.root.T
        middle = share * mean + (1 - share) * self.middle
        return _Proposal(middle, np.linalg.cholesky(scale), *_LATER)
