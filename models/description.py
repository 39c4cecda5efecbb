"""The description of a model that a report prints."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Description:
    """A model in words.

    Args:
        name: identifier of the model.
        title: the model's title, one line.
        equations: equations of the model, one line each, with the source.
        assumptions: assumptions of the model, one line each.
        left_out: effects that the model neglects, one line each.
        priors: (quantity, prior, reason) for each unknown that the scene does not measure.
        ignores: features of the scene that the model does not use, one sentence each.
    """

    name: str
    title: str
    equations: tuple[str, ...]
    assumptions: tuple[str, ...]
    left_out: tuple[str, ...]
    priors: tuple[tuple[str, str, str], ...] = ()
    ignores: tuple[str, ...] = ()
