"""Options of a reconstruction besides its scene."""

from __future__ import annotations

from dataclasses import dataclass

DEFAULT_RUNG = "planar-moment+wheels"


@dataclass(frozen=True, slots=True)
class RunOptions:
    """Options of a reconstruction, by which it can be repeated.

    Args:
        model: name of a rung in `retrodict.models.RUNGS`; a user may also ask for "auto".
        method: name in `retrodict.inference.samplers.METHODS`; a user may also ask for "auto".
        chains: number of chains, or of independent replicates where a method has no chains.
        draws: number of draws kept of each chain; None for the method's default.
        warmup: number of warm-up iterations before the draws, where a method has any.
        seed: integer seed of all random numbers.
    """

    model: str = DEFAULT_RUNG
    method: str = "nuts"
    chains: int = 4
    draws: int | None = None
    warmup: int = 150
    seed: int = 0
