"""Sequential Monte Carlo, tempered from the nested proposal to the posterior; it gives the evidence too.

Particles move by preconditioned Crank-Nicolson steps (Cotter et al. 2013) on random subsets of the
coordinates, whitened by the particles' own mean and covariance, anew as they move; and by draws of the
nested proposal, which reach the end of long tails where such steps do not (`benchmarks.tails`).

Written out here: blackjax's tempering takes the density and its moves as one program, which would be one
more to compile for each structure of scene, and would run on one core.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from math import ceil
from typing import Protocol

import numpy as np
from jaxtyping import Float
from scipy.special import logsumexp, softmax

from retrodict.inference.errors import Interrupted
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.samplers.draws import Draws, Progress, Task
from retrodict.inference.samplers.nested import nested
from retrodict.inference.samplers.psis import effective, resampled
from retrodict.inference.threads import one_blas_thread

_PARTICLES = 512  # of a population
_MOST = 8  # largest multiple of the draws asked for, where they fall short
_ASUNDER = 0.4  # standard deviations between populations from which more moves will not do
_EFFECTIVE = 0.5  # share of the particles that a step in temperature leaves
_STAGES = 60  # steps in temperature at most
# Moves of each particle at a temperature, and at the posterior, before coordinates are whitened anew:
# two left the evidence of a start 3 sd off 0.18 too low, and are as good as four at the posterior.
_SWEEPS, _LAST_SWEEPS = 4, 2
# Rounds of moves at the posterior: before the first draw that is kept, to part particles that were
# resampled from one, and before each further one.
_SETTLING, _LAST = 6, 1
# Steps far and near; the far ones go farthest in the mean, and the near ones are rarely refused.
_KEEP = np.array([0.0, 0.3, 0.7, 0.95])  # factor of a coordinate that a step keeps
_MOVED = np.array([0.15, 0.4, 1.0])  # share of the coordinates that a step moves
_WIDER = 1.15  # scale of the steps over the particles' spread: they need the heavier tails
_ASTRAY = 4.5  # standard deviations from the start at which a posterior is not one that was sought
_UNSURE = 0.5  # standard error of the log evidence: 0.1 is usual
_LEAST = 1e-12  # variance added, so that none is zero
_NOWHERE = -1e12  # log density where there is none

Points = Float[np.ndarray, "chains particles w"]
Values = Float[np.ndarray, "chains particles"]


class Start(Protocol):
    """A distribution that particles are first drawn from."""

    def sampled(self, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Independent draws, shape (count, q), and their log densities."""

    def log_density(self, w: np.ndarray) -> np.ndarray:
        """Log densities at points, shape (any,)."""


def draw(task: Task) -> Draws:
    """Draw by tempered SMC, each chain a population of its own.

    Args:
        task: posterior, numbers of chains and draws, seed and callback. A population has as many
            particles as draws are asked for, up to `_PARTICLES`; for more it is kept several times.

    Raises:
        Interrupted: stopped before any draws were kept.
    """
    start = nested(task.posterior)
    assert start is not None, "tempering is planned in deviates only"
    return tempered(task, start)


def tempered(task: Task, start: Start) -> Draws:
    """`draw` from a given start."""
    try:
        with one_blas_thread():
            populations = _Populations.spread(task, start)
            populations.temper()
    except KeyboardInterrupt:
        raise Interrupted("stopped before any draws were kept") from None
    return _kept(task, populations, 1)


def _kept(task: Task, populations: _Populations, times: int) -> Draws:
    """The last draws, up to twice as many as were asked for, once `times` as many were kept in all."""
    complete = True
    try:
        with one_blas_thread():
            populations.keep(times * task.draws)
    except KeyboardInterrupt:
        complete = False
        if not populations.kept:
            raise Interrupted("stopped before any draws were kept") from None
    faults = []
    if populations.temperature < 1:
        faults.append(
            f"tempering had not reached the posterior after {_STAGES} stages, but a power of "
            f"{populations.temperature:.2g} of its density"
        )
    w = populations.draws(min(times, 2) * task.draws)
    if populations.astray > _ASTRAY:
        faults.append(
            f"the posterior lies {populations.astray:.1f} standard deviations from where it was sought, "
            f"more than {_ASTRAY:g}: parts of it may be missing"
        )
    if (unsure := _error(populations.log_evidence)) > _UNSURE:
        faults.append(
            f"the populations disagree on the log evidence: its standard error is {unsure:.1f}, more "
            f"than {_UNSURE:g}, so that some found what others miss"
        )
    # no number of draws removes a fault: of six times as many, a mean moved from 5.2 to 4.9
    nearly = complete and not faults and times < _MOST and _apart(populations.w) < _ASUNDER
    evidence = populations.log_evidence
    return Draws(
        w,
        {},
        complete=complete,
        faults=tuple(faults),
        attributes={
            "log_evidence": float(logsumexp(evidence) - np.log(len(evidence))),
            # four populations may agree by chance
            "log_evidence_sd": float(np.fmax(_error(evidence), populations.least_error)),
            "evaluations": float(populations.evaluations),
        },
        more=partial(_kept, task, populations, 2 * times) if nearly else None,
    )


def _apart(w: Points) -> float:
    """Largest spread of the populations' means in a coordinate, in standard deviations of particles."""
    spread = w.mean(axis=1).std(axis=0) / np.maximum(w.std(axis=1).mean(axis=0), 1e-300)
    return float(spread.max())


def _error(evidence: Float[np.ndarray, " chains"]) -> float:
    """Standard error of the log of the populations' mean evidence, from the logs of their evidences."""
    if len(evidence) < 2:
        return float("nan")
    return float(np.std(evidence, ddof=1) / np.sqrt(len(evidence)))


@dataclass
class _Populations:
    """Particles on their way from the start to the posterior, a population for each chain.

    Populations are weighted, resampled and moved each for itself. They share temperatures, and the
    covariance of their steps, which more particles determine better.

    Args:
        posterior: posterior to draw from, in coordinates about its mode.
        start: distribution that the particles are first drawn from, and offered draws of as they move.
        rng: generator of all random numbers.
        progress: callback that is called with (done, of all) as the work goes on.
        w: positions of the particles, shape (chains, particles, q).
        height: log density of the posterior at `w`, shape (chains, particles).
        at_start: log density of the start at `w`, shape (chains, particles); of earlier positions at
            temperature one, where nothing but a fresh start asks for it.
        log_evidence: log evidence of the tempered density by each population, shape (chains,); at
            temperature one, of the posterior.
        begun: whitened coordinates of the particles as they were first drawn.
        transform: whitened coordinates of the particles, in which steps are made.
        temperature: power t of the tempered density, start^(1 - t) posterior^t, from 0 to 1.
        evaluations: number of density evaluations, and of draws of the start and its densities.
        kept: positions `w` at the posterior that are kept as draws, some rounds of moves apart.
        least_error: standard error of the log evidence if particles were independent.
    """

    posterior: Posterior
    start: Start
    rng: np.random.Generator
    progress: Progress
    w: Points
    height: Values
    at_start: Values
    log_evidence: Float[np.ndarray, " chains"]
    begun: _Whitened
    transform: _Whitened
    temperature: float = 0.0
    evaluations: int = 0
    kept: list[Points] = field(default_factory=list)
    least_error: float = 0.0

    @classmethod
    def spread(cls, task: Task, start: Start) -> _Populations:
        """Populations drawn from a start.

        Args:
            task: posterior, numbers of chains and draws, seed and callback.
            start: distribution that the particles are drawn from.
        """
        count, n = min(_PARTICLES, task.draws), task.posterior.size
        rng = np.random.default_rng([task.seed, task.chains, count])
        w, at_start = start.sampled(task.chains * count, rng)
        each, begun = (task.chains, count), _Whitened.by(w, np.full(len(w), 1 / len(w)))
        self = cls(
            task.posterior, start, rng, task.progress, w.reshape(*each, n), np.zeros(each),
            at_start.reshape(each), np.zeros(task.chains), begun, begun, evaluations=len(w)
        )  # fmt: skip
        self.height = self._density(self.w)
        return self

    def temper(self) -> None:
        """Bring the particles to the posterior, or as near to it as they can come."""
        for _ in range(_STAGES):
            self._step()
            if self.temperature >= 1:
                return
            self._move()
            self._tell(0.8 * self.temperature**0.25)

    @property
    def astray(self) -> float:
        """Distance of the particles' mean from that of the start, in standard deviations there."""
        return float(np.linalg.norm(self.begun.seen(self.w).mean(axis=(0, 1))))

    def keep(self, count: int) -> None:
        """Move the particles until `count` draws of each chain are kept in all."""
        rounds = ceil(count / self.w.shape[1])
        while len(self.kept) < rounds:
            for _ in range(_LAST if self.kept else _SETTLING):
                self._move()
            self.kept.append(self.w)
            self._tell(0.8 + 0.2 * len(self.kept) / rounds)

    def draws(self, count: int) -> Points:
        """The last `count` draws of each chain; those of one particle follow each other."""
        chains, particles, n = self.w.shape
        last = np.stack(self.kept[-ceil(count / particles) :], axis=2)
        return last.reshape(chains, -1, n)[:, :count]

    def _density(self, w: Points) -> Values:
        self.evaluations += w.shape[0] * w.shape[1]
        found = self.posterior.log_density(w.reshape(-1, w.shape[2])).reshape(w.shape[:2])
        return np.where(np.isfinite(found), found, _NOWHERE)

    def _of_start(self, w: Points) -> Values:
        self.evaluations += w.shape[0] * w.shape[1]
        return self.start.log_density(w.reshape(-1, w.shape[2])).reshape(w.shape[:2])

    def _step(self) -> None:
        """Raise the temperature as far as each population stays effective, and resample them."""
        gain = self.height - self.at_start
        wanted = _EFFECTIVE * gain.shape[1]

        def effective_at(temperature: float) -> bool:
            weights = softmax((temperature - self.temperature) * gain, axis=1)
            return min(map(effective, weights)) >= wanted

        low, high = self.temperature, 1.0
        if not effective_at(high):
            for _ in range(50):
                middle = (low + high) / 2
                low, high = (middle, high) if effective_at(middle) else (low, middle)
            high = low
        log_weight = (high - self.temperature) * gain
        self.log_evidence += logsumexp(log_weight, axis=1) - np.log(gain.shape[1])
        self.temperature = high
        weights = softmax(log_weight, axis=1)
        unevenness = sum(1 / effective(own) - 1 / own.size for own in weights) / len(weights) ** 2
        self.least_error = float(np.hypot(self.least_error, np.sqrt(unevenness)))
        self.transform = self._whitened(self.w, weights)
        for i, own in enumerate(weights):
            index = resampled(own, len(own), self.rng)
            for values in (self.w, self.height, self.at_start):
                values[i] = values[i][index]

    def _whitened(self, w: Points, weights: Values) -> _Whitened:
        n = w.shape[-1]
        return _Whitened.by(w.reshape(-1, n), weights.ravel() / weights.sum())

    def _move(self) -> None:
        """Move the particles by some sweeps, then whiten the coordinates by them anew."""
        z = self.transform.seen(self.w)
        for _ in range(_SWEEPS if self.temperature < 1 else _LAST_SWEEPS):
            z = self._sweep(z)
        self._begin_anew()
        lately = np.concatenate([self.w, *self.kept[-3:]], axis=1)
        self.transform = self._whitened(lately, np.ones(lately.shape[:2]))

    def _sweep(self, z: Points) -> Points:
        """Make one step of each particle, given its whitened coordinates; returns these after it."""
        each, n = z.shape[:2], z.shape[2]
        moved = self.rng.random(z.shape) < self.rng.choice(_MOVED, (*each, 1))
        moved |= np.arange(n) == self.rng.integers(n, size=(*each, 1))
        keep = self.rng.choice(_KEEP, (*each, 1))
        fresh = keep * z + np.sqrt(1 - keep**2) * self.rng.standard_normal(z.shape)
        there = np.where(moved, fresh, z)
        w = self.transform.at(there)
        height = self._density(w)
        at_start = self._of_start(w) if self.temperature < 1 else self.at_start
        rise = self.temperature * (height - self.height)
        rise += (1 - self.temperature) * (at_start - self.at_start)
        rise += (np.sum(there**2, axis=2) - np.sum(z**2, axis=2)) / 2  # over the normal of the step
        taken = np.log(self.rng.random(each)) < rise
        self._take(taken, w, height, at_start)
        return np.where(taken[..., None], there, z)

    def _begin_anew(self) -> None:
        """Offer each particle a draw of the start; it goes there as the two densities bid."""
        each, n = self.w.shape[:2], self.w.shape[2]
        if self.temperature >= 1:
            self.at_start = self._of_start(self.w)
        w, at_start = self.start.sampled(each[0] * each[1], self.rng)
        self.evaluations += len(w)
        w, at_start = w.reshape(*each, n), at_start.reshape(each)
        height = self._density(w)
        rise = self.temperature * ((height - at_start) - (self.height - self.at_start))
        self._take(np.log(self.rng.random(each)) < rise, w, height, at_start)

    def _take(self, taken: np.ndarray, w: Points, height: Values, at_start: Values) -> None:
        self.w = np.where(taken[..., None], w, self.w)
        self.height = np.where(taken, height, self.height)
        self.at_start = np.where(taken, at_start, self.at_start)

    def _tell(self, share: float) -> None:
        self.progress(int(1000 * share), 1000)


@dataclass(frozen=True)
class _Whitened:
    """Coordinates about a mean, in units of a triangular root of a covariance.

    Args:
        mean: mean, shape (w,).
        root: lower triangular root of the covariance, shape (w, w), the last coordinate first: so that
            a step of an input moves the motion correlated with it, and one of the motion no input.
    """

    mean: Float[np.ndarray, " w"]
    root: Float[np.ndarray, "w w"]

    @classmethod
    def by(
        cls,
        w: Float[np.ndarray, "points w"],
        weights: Float[np.ndarray, " points"],
    ) -> _Whitened:
        """Coordinates whitened by weighted points; correlations are shrunk where few are effective."""
        mean = weights @ w
        covariance = (w - mean).T @ ((w - mean) * weights[:, None])
        worth = effective(weights)
        share = worth / (worth + w.shape[1])
        own = np.diag(covariance) + _LEAST
        covariance = share * covariance + (1 - share) * np.diag(own) + _LEAST * np.eye(w.shape[1])
        return cls(mean, _WIDER * np.linalg.cholesky(covariance[::-1, ::-1]))

    def at(self, z: Points) -> Points:
        """Points w of whitened coordinates z."""
        return self.mean + (z @ self.root.T)[..., ::-1]

    def seen(self, w: Points) -> Points:
        """Whitened coordinates z of points w."""
        from scipy.linalg import solve_triangular

        off = (w - self.mean)[..., ::-1].reshape(-1, w.shape[-1])
        return solve_triangular(self.root, off.T, lower=True).T.reshape(w.shape)
