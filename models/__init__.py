"""The NumPyro models: `RUNGS` by name; found when first asked for, because JAX is slow to import."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from retrodict.models.model import RUNGS, Rung, rungs_for

__all__ = ["RUNGS", "Rung", "rungs_for"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from retrodict.models import model

    return getattr(model, name)
