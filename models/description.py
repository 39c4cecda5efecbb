"""What a model is, in words and data that a report can print."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Description:
    """What a model is, in words that a report can print.

    Args:
        name: identifier.
        title: one line.
        equations: what is solved, one line each, with the source.
        assumptions: what is taken for granted, one line each.
        left_out: what the model does not hold, one line each.
        priors: (quantity, prior, reason) for each unknown that the scene does not measure.
    """

    name: str
    title: str
    equations: tuple[str, ...]
    assumptions: tuple[str, ...]
    left_out: tuple[str, ...]
    priors: tuple[tuple[str, str, str], ...] = ()
