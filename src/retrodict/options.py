"""What is asked of a reconstruction beside its scene."""

from __future__ import annotations

from dataclasses import dataclass

DEFAULT_RUNG = "planar-moment+wheels"


@dataclass(frozen=True, slots=True)
class RunOptions:
    """Options of a reconstruction, by which it can be repeated.

    Args:
        model: a name in `retrodict.models.RUNGS`; as a user asks, "auto" too.
        method: a name in `retrodict.inference.samplers.METHODS`; as a user asks, "auto" too.
        chains: of draws; independent replicates where a method has no chains.
        draws: kept of each; None for as many as the method takes by default.
        warmup: iterations before them, where a method has any.
        seed: integer seed of every random number.
    """

    model: str = DEFAULT_RUNG
    method: str = "nuts"
    chains: int = 4
    draws: int | None = None
    warmup: int = 150
    seed: int = 0
