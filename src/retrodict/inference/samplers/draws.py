"""Arguments and results that all sampling methods share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from retrodict.inference.fitting.posterior import Posterior

Progress = Callable[[int, int], None]  # done, of all


@dataclass(frozen=True)
class Task:
    """Request to a sampling method.

    Args:
        posterior: posterior to draw from, in coordinates in which it is near a standard normal.
        chains: number of chains; of independent replicates where a method has no chains.
        draws: number of draws kept of each chain.
        warmup: number of iterations before the kept draws, where a method has any.
        seed: integer seed of all random numbers; same seed, same machine, same draws.
        progress: callback that is called with (done, of all) as the work goes on.
        resume: file of interrupted chains to be continued; None to begin anew.
        slight: whether the posterior is a solution of so little weight beside others that few points
            suffice.
    """

    posterior: Posterior
    chains: int
    draws: int
    warmup: int
    seed: int
    progress: Progress
    resume: Path | None = None
    slight: bool = False


@dataclass(frozen=True)
class Draws:
    """Draws of a sampling method, with its diagnostics.

    Args:
        w: draws in the sampled coordinates, shape (chains, draws, q); of a method that solves back,
            the (z, xi) of `transforms.rest_pose`.
        stats: statistics of the draws, each of shape (chains, draws): diverging, log_weight, …
        complete: False when interrupted; then all chains are cut to the shortest.
        notes: remedies that the method applied by itself, in words.
        faults: reasons not to rely on the draws, in words.
        attributes: the method's own diagnostics: pareto_k, log_evidence.
        quantities: the model's unknowns at w and what follows from them, a row for each draw; None
            where the method has not computed them.
        unfinished: content of a file of interrupted chains; None where there are none to continue.
        enough: whether enough of the points that the draws were chosen from are effective, so that no
            other method need draw again; True for draws not chosen from points.
        conditioned: whether the draws follow the posterior, at least nearly; False for measurements
            carried back, with which neither a prior nor a likelihood goes.
        more: function that continues to twice as many draws, or points that they are chosen from;
            None where that is not possible or of no use.
    """

    w: np.ndarray
    stats: dict[str, np.ndarray]
    complete: bool = True
    notes: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    attributes: dict[str, float] = field(default_factory=dict)
    quantities: dict[str, np.ndarray] | None = field(default=None, repr=False)
    unfinished: bytes | None = field(default=None, repr=False)
    enough: bool = True
    conditioned: bool = True
    more: Callable[[], Draws] | None = field(default=None, repr=False)

    def known(self, posterior: Posterior) -> dict[str, np.ndarray]:
        """The model's unknowns and what follows from them, a row for each draw of `posterior`."""
        if self.quantities is not None:
            return self.quantities
        return posterior.evaluate(self.w.reshape(-1, posterior.size))[1]
