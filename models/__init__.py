"""The NumPyro models, one rung a file, made of shared parts; `RUNGS` registers them by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from retrodict.models import parts, planar_moment_wheels
from retrodict.models.card import Card


@dataclass(frozen=True)
class Rung:
    """A model and its card."""

    model: Callable[[parts.Structure, parts.Data], None]
    card: Card


RUNGS: dict[str, Rung] = {
    module.CARD.name: Rung(module.model, module.CARD) for module in (planar_moment_wheels,)
}
