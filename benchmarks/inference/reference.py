"""A posterior as well as it can be known, and how draws are compared with it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from arviz_stats.base import array_stats

from benchmarks.competitors import Array, Sites
from benchmarks.tables import Remark
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.plan import ways
from retrodict.inference.samplers import METHODS, Draws, Task
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.records import Scene

ASKED = ("speed_b", "e", "e_m", "mu")
STATISTICS = ("mean", "sd", "lower", "upper")  # the last two limit 95 %
CHAINS, WARMUP = 4, 150  # of our methods, as `reconstruct` has them


class Effort(NamedTuple):
    """How much is done.

    Args:
        share: of the iterations of the competitors.
        limit: seconds of sampling for each of them.
        nuts: draws of each of four chains for the reference.
        importance: likewise, before weights are applied.
        repeats: seeds over which our errors are averaged.
        scenes: at random, in the comparison of many scenes.
        long: draws of each chain of nuts in their reference; of importance four times as many.
    """

    share: float = 1.0
    limit: float = 20.0
    nuts: int = 22_500
    importance: int = 60_000
    repeats: int = 4
    scenes: int = 12
    long: int = 5_000

    def scaled(self, share: float) -> Effort:
        """A part of it."""
        counts = [max(least, int(n * share)) for n, least in zip(self[2:], _LEAST, strict=True)]
        return Effort(share, self.limit * share, *counts)


_LEAST = (500, 500, 1, 1, 500)


class Reference(NamedTuple):
    """A posterior as well as it is known: statistics (statistic, quantity), their errors, the draws."""

    values: Array
    errors: Array
    draws: Sites


Posteriors = dict[str, Posterior]
"""The posterior of a scene, by method in the coordinates that it is first tried in."""


def posteriors_of(scene: Scene) -> Posteriors:
    """The posterior of a scene for each of our methods."""
    first = {method: ways(method, scene)[0].coordinates for method in METHODS}
    found = {each: prepare(scene, DEFAULT_RUNG, each) for each in {*first.values()}}
    return {method: found[each] for method, each in first.items()}


def refer(posteriors: Posteriors, effort: Effort, scene: str) -> tuple[Reference, Remark]:
    """The posterior from long runs of nuts and importance, and how they agree."""
    long = long_runs(posteriors, effort.nuts, effort.importance)
    runs = {name: x for name, (x, _) in long.items()}
    values = [statistics_of(x) for x in runs.values()]
    errors = [errors_of(x) for x in runs.values()]
    z = (values[0] - values[1]) / np.hypot(*errors)
    row, column = np.unravel_index(np.argmax(np.abs(z)), z.shape)
    both, error = pooled(values, errors)
    largest = np.abs((values[0] - values[1]) / both[1]).max()
    ess = {name: least_ess(x) for name, x in runs.items()}
    text = (
        f"{scene}: {ess['nuts']:,.0f} effective draws of nuts and {ess['importance']:,.0f} of importance"
        f" agree: the worst of {z.size} differences is {abs(z[row, column]):.1f} Monte Carlo errors"
        f" ({STATISTICS[row]} of {ASKED[column]}), {np.mean(np.abs(z) > 2):.0%} are beyond two; none"
        f" exceeds {largest:.4f} posterior sd. Reference: the mean of both."
    )
    pick = np.random.default_rng(0).permutation(runs["nuts"]["e"].size)[:500]
    spread = {k: v.reshape(-1, *v.shape[2:])[pick] for k, v in runs["nuts"].items()}
    return Reference(both, error, spread), ("reference", text)


def long_runs(posteriors: Posteriors, nuts: int, importance: int) -> dict[str, tuple[Sites, str]]:
    """Long runs of both methods that a reference is made of, and what is at fault with each."""
    drawn = {
        "nuts": drawn_by(posteriors["nuts"], "nuts", nuts, 1000),
        "importance": drawn_by(posteriors["importance"], "importance", importance, 2000),
    }
    return {
        name: (sites_of(posteriors[name], each), fault_of(each)) for name, each in drawn.items()
    }


def fault_of(drawn: Draws) -> str:
    """What is at fault with draws; empty if nothing."""
    if "diverging" in drawn.stats and drawn.stats["diverging"].any():
        return f"{int(drawn.stats['diverging'].sum())} divergences"
    return "; ".join(drawn.faults)


def pooled(values: Sequence[Array], errors: Sequence[Array]) -> tuple[Array, Array]:
    """The mean of several runs' statistics, and its error."""
    return np.mean(values, axis=0), np.sqrt(np.sum(np.square(errors), axis=0)) / len(errors)


def drawn_by(posterior: Posterior, method: str, draws: int, seed: int) -> Draws:
    """Draws by a method of ours, so many a chain."""
    return METHODS[method].draw(Task(posterior, CHAINS, draws, WARMUP, seed, lambda *_: None))


def sites_of(posterior: Posterior, drawn: Draws) -> Sites:
    """The unknowns at a method's draws, and what follows from them, shape (chains, draws)."""
    quantities = drawn.known(posterior)
    return {k: v.reshape(*drawn.w.shape[:2], *v.shape[1:]) for k, v in quantities.items()}


def statistics_of(x: Sites) -> Array:
    """Mean, sd and both limits (rows) of each quantity (columns)."""
    draws = np.array([x[name].ravel() for name in ASKED])
    limits = np.quantile(draws, [0.025, 0.975], axis=1)
    return np.array([draws.mean(1), draws.std(1, ddof=1), *limits])


def errors_of(x: Sites) -> Array:
    """Monte Carlo errors of `statistics_of`."""

    def of(draws: Array) -> list[float]:
        limits = [array_stats.mcse(draws, method="quantile", prob=p) for p in (0.025, 0.975)]
        moments = [array_stats.mcse(draws, method=method) for method in ("mean", "sd")]
        return [float(value) for value in moments + limits]

    return np.array([of(x[name]) for name in ASKED]).T


def least_ess(x: Sites) -> float:
    """Bulk effective sample size, the least of the quantities."""
    return min(float(array_stats.ess(x[name], method="bulk")) for name in ASKED)


def worst(off: Array) -> tuple[float, float, float]:
    """Of mean, sd and limits, from errors in sd of shape (repeats, statistic, quantity)."""
    size = np.sqrt(np.mean(off**2, axis=0)).max(axis=1)
    return float(size[0]), float(size[1]), float(size[2:].max())
