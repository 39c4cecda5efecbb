"""Sequential Monte Carlo, tempered from a wide normal to the posterior; it gives the evidence too.

Particles move by preconditioned Crank-Nicolson steps (Cotter et al. 2013) on random subsets of the
coordinates, whitened by the particles' own mean and covariance at each temperature. They need values of
the density only, so that run-outs that have no good derivatives, or several valleys, are followed too.

Written out here: blackjax's tempering takes the density and its moves as one program, which would be one
more to compile for each structure of scene, and would run on one core.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import partial
from math import ceil
from threading import Event

import numpy as np
from jaxtyping import Float
from scipy.special import logsumexp, softmax

from retrodict.inference.errors import Interrupted
from retrodict.inference.methods.draws import Draws, Task
from retrodict.inference.methods.weights import effective, resampled
from retrodict.inference.posterior import Posterior
from retrodict.inference.threads import one_blas_thread

_PARTICLES = 256  # of a population: a row each of what is weighed at once
_MOST = 8  # times as many draws are gone on to, where they fall short
_ASUNDER = 0.4  # standard deviations between populations from which more moves will not do
_EFFECTIVE = 0.5  # share of the particles that a step in temperature leaves
_STAGES = 60  # at most
# Sweeps at a temperature end when no coordinate is correlated with itself before them by more, or here.
_CORRELATED, _SWEEPS = 0.4, 12
_AT_LAST, _LAST_SWEEPS = 0.25, 24  # likewise at the posterior, before each draw that is kept
_KEEP = np.array([0.0, 0.5, 0.8, 0.93])  # of a coordinate, in a step
_MOVED = np.array([0.1, 0.25, 0.5, 1.0])  # share of the coordinates that a step moves
_ASTRAY = 3.0  # widths of the start: a posterior farther off is not one that it was spread about
_NOWHERE = -1e12  # log density where there is none

Points = Float[np.ndarray, "particles w"]
Values = Float[np.ndarray, " particles"]


def draw(task: Task) -> Draws:
    """Draw by tempered SMC, each chain a population of its own.

    Args:
        task: what is asked for; populations are as large as its draws, up to `_PARTICLES`, of which
            several in a row are kept for more draws than that.

    Raises:
        Interrupted: stopped before a population was done.
    """
    count = min(_PARTICLES, task.draws)

    def run(chain: int, tell: Callable[[float], None]) -> _Population:
        rng = np.random.default_rng([task.seed, chain, count])
        population = _Population.tempered(task.posterior, count, rng, tell)
        population.keep(ceil(task.draws / count))
        return population

    return _told(task, _side_by_side(task, run), 1)


def _more(task: Task, done: list[_Population], times: int) -> Draws:
    """As many draws again, of the same populations moved on."""
    kept = ceil(times * task.draws / len(done[0].w))

    def run(chain: int, tell: Callable[[float], None]) -> _Population:
        done[chain].tell = tell
        done[chain].keep(kept)
        return done[chain]

    return _told(task, _side_by_side(task, run), 2 * times)


def _side_by_side(
    task: Task, run: Callable[[int, Callable[[float], None]], _Population]
) -> list[_Population]:
    """What is done of each chain, in threads; those that were done when interrupted."""
    shares, stop = np.zeros(task.chains), Event()

    def one(chain: int) -> _Population:
        def tell(share: float) -> None:
            shares[chain] = share
            if stop.is_set():
                raise Interrupted("stopped before any draws were kept")

        return run(chain, tell)

    with one_blas_thread(), ThreadPoolExecutor(min(task.chains, os.cpu_count() or 1)) as pool:
        runs = [pool.submit(one, chain) for chain in range(task.chains)]
        try:
            while wait(runs, timeout=0.2).not_done:
                task.progress(int(1000 * shares.mean()), 1000)
        except KeyboardInterrupt:
            stop.set()
            pool.shutdown(cancel_futures=True)
    if not stop.is_set():
        return [each.result() for each in runs]
    done = [each.result() for each in runs if not each.cancelled() and not each.exception()]
    if not done:
        raise Interrupted("stopped before any draws were kept")
    return done


def _told(task: Task, done: list[_Population], times: int) -> Draws:
    """The last draws of populations, up to twice as many as were asked for."""
    draws = min(times, 2) * task.draws
    w = np.stack([population.draws(draws) for population in done])
    evidence = np.array([population.log_evidence for population in done])
    faults = []
    reached = min(population.temperature for population in done)
    if reached < 1:
        faults.append(
            f"tempering had not reached the posterior after {_STAGES} stages, but a power of "
            f"{reached:.2g} of its density"
        )
    astray = np.max(np.abs(w.mean(axis=(0, 1))) / task.posterior.reach)
    if astray > _ASTRAY:
        faults.append(
            f"the posterior lies {astray:.1f} widths from the middle of where it was sought, more than "
            f"{_ASTRAY:g}: parts of it may be missing"
        )
    complete = len(done) == task.chains
    nearly = complete and times < _MOST and _apart(done) < _ASUNDER
    return Draws(
        w,
        {},
        complete=complete,
        faults=tuple(faults),
        attributes={
            "log_evidence": float(logsumexp(evidence) - np.log(len(evidence))),
            "log_evidence_sd": _error(evidence),
            "evaluations": float(sum(population.evaluations for population in done)),
        },
        more=partial(_more, task, done, times) if nearly else None,
    )


def _apart(done: list[_Population]) -> float:
    """How far the means of populations lie apart in any coordinate, in standard deviations."""
    w = np.stack([population.w for population in done])
    spread = w.mean(axis=1).std(axis=0) / np.maximum(w.std(axis=1).mean(axis=0), 1e-300)
    return float(spread.max())


def _error(evidence: np.ndarray) -> float:
    """Standard error of the log of the mean of so many evidences, from their logs."""
    if len(evidence) < 2:
        return float("nan")
    return float(np.std(evidence, ddof=1) / np.sqrt(len(evidence)))


@dataclass
class _Population:
    """Particles on their way from the start to the posterior.

    Args:
        density: log density of the posterior at points.
        wide: standard deviations of the normal that they start from, shape (w,).
        w: where they are.
        height: the density there.
        rng: of the moves.
        tell: called with the share of the work that is done.
        temperature: power of the density over that of the start.
        log_evidence: of the posterior, once the temperature is one.
        evaluations: of the density.
        chart: coordinates in which they have no correlation.
        kept: where they were at the posterior, after each round of moves.
    """

    density: Callable[[Points], Values]
    wide: Float[np.ndarray, " w"]
    w: Points
    height: Values
    rng: np.random.Generator
    tell: Callable[[float], None]
    temperature: float = 0.0
    log_evidence: float = 0.0
    evaluations: int = 0
    chart: _Whitened | None = None
    kept: list[Points] = field(default_factory=list)

    @classmethod
    def tempered(
        cls,
        posterior: Posterior,
        count: int,
        rng: np.random.Generator,
        tell: Callable[[float], None],
    ) -> _Population:
        """A population that has come to the posterior, or as near to it as it could.

        Args:
            posterior: in coordinates that start about zero, as wide as `Posterior.reach` says.
            count: of particles.
            rng: of all that is random.
            tell: called with the share of the work that is done.
        """

        def density(w: Points) -> Values:
            found = posterior.log_density(w)
            return np.where(np.isfinite(found), found, _NOWHERE)

        w = rng.standard_normal((count, posterior.size)) * posterior.reach
        self = cls(density, posterior.reach, w, density(w), rng, tell)
        for _ in range(_STAGES):
            self.chart = self._step()
            if self.temperature >= 1:
                break
            self._move(self.chart, _CORRELATED, _SWEEPS)
            tell(0.8 * self.temperature**0.25)
        return self

    def keep(self, rounds: int) -> None:
        """Move the particles so many times over, and keep where they come to each time."""
        assert self.chart is not None, "it was tempered"
        for i in range(rounds):
            self._move(self.chart, _AT_LAST, _LAST_SWEEPS)
            self.kept.append(self.w.copy())
            self.tell(0.8 + 0.2 * (i + 1) / rounds)

    def draws(self, count: int) -> Points:
        """The last so many of what was kept; those of one particle follow each other."""
        rounds = ceil(count / len(self.w))
        last = self.kept[-rounds:]
        return np.stack(last, axis=1).reshape(-1, self.w.shape[1])[:count]

    def _start(self, w: Points) -> Values:
        """Log density of the normal that particles start from."""
        z = w / self.wide
        return -np.sum(z**2 / 2 + np.log(self.wide) + np.log(2 * np.pi) / 2, axis=1)

    def _step(self) -> _Whitened:
        """Raise the temperature as far as the particles bear, and resample them.

        Returns:
            Coordinates in which they have no correlation.
        """
        gain = self.height - self._start(self.w)
        low, high, wanted = self.temperature, 1.0, _EFFECTIVE * len(gain)
        if effective(softmax((high - low) * gain)) < wanted:
            for _ in range(50):
                middle = (low + high) / 2
                bears = effective(softmax((middle - self.temperature) * gain)) >= wanted
                low, high = (middle, high) if bears else (low, middle)
            high = low
        log_weight = (high - self.temperature) * gain
        self.log_evidence += float(logsumexp(log_weight) - np.log(len(gain)))
        self.temperature = high
        weights = softmax(log_weight)
        chart = _Whitened.by(self.w, weights, self.wide)
        index = resampled(weights, len(weights), self.rng)
        self.w, self.height = self.w[index], self.height[index]
        return chart

    def _move(self, chart: _Whitened, correlated: float, most: int) -> None:
        """Move the particles until they have forgotten where they were."""
        z, start = chart.seen(self.w), self._start(self.w)
        first = z
        for _ in range(most):
            z, start = self._sweep(chart, z, start)
            if _correlation(first, z) < correlated:
                return

    def _sweep(self, chart: _Whitened, z: Points, start: Values) -> tuple[Points, Values]:
        """One step of each particle."""
        count, n = z.shape
        moved = self.rng.random((count, n)) < self.rng.choice(_MOVED, (count, 1))
        moved[np.arange(count), self.rng.integers(n, size=count)] = True
        keep = self.rng.choice(_KEEP, (count, 1))
        fresh = keep * z + np.sqrt(1 - keep**2) * self.rng.standard_normal((count, n))
        there = np.where(moved, fresh, z)
        w = chart.at(there)
        height, start_there = self.density(w), self._start(w)
        self.evaluations += count
        rise = (1 - self.temperature) * (start_there - start)
        rise += self.temperature * (height - self.height)
        rise += (np.sum(there**2, axis=1) - np.sum(z**2, axis=1)) / 2  # over the normal of the step
        taken = np.log(self.rng.random(count)) < rise
        self.w = np.where(taken[:, None], w, self.w)
        self.height = np.where(taken, height, self.height)
        return np.where(taken[:, None], there, z), np.where(taken, start_there, start)


@dataclass(frozen=True)
class _Whitened:
    """Coordinates about a mean, in units of a triangular root of a covariance.

    Args:
        mean: shape (w,).
        root: lower triangular, the last coordinate first: so that those of inputs move the motion that
            goes with them, and those of the motion nothing else; shape (w, w).
    """

    mean: Float[np.ndarray, " w"]
    root: Float[np.ndarray, "w w"]

    @classmethod
    def by(cls, w: Points, weights: Values, wide: Float[np.ndarray, " w"]) -> _Whitened:
        """By weighted points; without correlations as far as they are too few to tell."""
        mean = weights @ w
        covariance = (w - mean).T @ ((w - mean) * weights[:, None])
        worth = effective(weights)
        share = worth / (worth + w.shape[1])
        own = np.diag(covariance) + 1e-12 * wide**2
        covariance = share * covariance + (1 - share) * np.diag(own) + 1e-12 * np.diag(wide**2)
        return cls(mean, np.linalg.cholesky(covariance[::-1, ::-1]))

    def at(self, z: Points) -> Points:
        """Points by their coordinates."""
        return self.mean + (z @ self.root.T)[:, ::-1]

    def seen(self, w: Points) -> Points:
        """Coordinates of points."""
        from scipy.linalg import solve_triangular

        return solve_triangular(self.root, (w - self.mean)[:, ::-1].T, lower=True).T


def _correlation(before: Points, after: Points) -> float:
    """The largest, over coordinates, of a coordinate with itself."""
    a, b = before - before.mean(axis=0), after - after.mean(axis=0)
    spread = np.sqrt(np.mean(a**2, axis=0) * np.mean(b**2, axis=0))
    return float(np.max(np.mean(a * b, axis=0) / np.maximum(spread, 1e-300)))
