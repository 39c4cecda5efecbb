"""What every method takes and returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from retrodict.inference.fitting.posterior import Posterior

Progress = Callable[[int, int], None]  # done, of all


@dataclass(frozen=True)
class Task:
    """What a method is asked for.

    Args:
        posterior: in coordinates where it is near a standard normal.
        chains: how many; independent replicates where a method has no chains.
        draws: kept of each.
        warmup: iterations before them, where a method has any.
        seed: of the random numbers; same seed, same machine, same draws.
        progress: called as the work goes on.
        resume: a file of interrupted chains to go on with; None of a method without chains.
        slight: whether so few of its draws will count, beside those of other posteriors, that points
            for them need not be many.
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
    """What a method brought.

    Args:
        w: draws in the sampled coordinates, shape (chains, draws, q); of a method that solves back
            without coordinates, the (z, xi) of `coordinates`.
        stats: per draw, each of shape (chains, draws): diverging, log_weight, …
        complete: False when interrupted; then all chains are cut to the shortest.
        notes: how the method helped itself.
        faults: for which the draws must not be relied on.
        attributes: the method's own diagnostics: pareto_k, log_evidence.
        quantities: the model's unknowns at w and what follows from them, a row for each draw; None of a
            method that has not come by them.
        unfinished: interrupted chains as a file holds them; None where there is nothing to go on with.
        enough: whether so many of the points that they are chosen from count that no other method need
            draw them again; of draws that are not chosen from points, always.
        more: goes on to twice as many, of draws or of the points that they are chosen from; None where
            nothing is to be had that way.
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
    more: Callable[[], Draws] | None = field(default=None, repr=False)

    def known(self, posterior: Posterior) -> dict[str, np.ndarray]:
        """The model's unknowns and what follows from them, a row for each draw of `posterior`."""
        if self.quantities is not None:
            return self.quantities
        return posterior.evaluate(self.w.reshape(-1, posterior.size))[1]
