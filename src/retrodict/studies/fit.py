"""Fit of a reconstruction to the evidence, and a short summary of its answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.misfit import misfit
from retrodict.inference.pointwise import by_item

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome

LEVELS = (50, 90, 95)  # per cent


@dataclass(frozen=True, slots=True)
class Item:
    """How a rung explains one item of evidence.

    Args:
        name: flat name of the item.
        used: whether the rung's likelihood contains the item.
        residual: measured less predicted mean, in measured standard deviations; None where the rung
            does not predict it.
        probability: two-sided probability that a prediction lies as far out as the measurement; None
            where the rung does not predict the item.
    """

    name: str
    used: bool
    residual: float | None = None
    probability: float | None = None


@dataclass(frozen=True, slots=True)
class Fit:
    """How a rung explains the evidence it uses and the measured inputs, together.

    Args:
        items: items of evidence, used or not.
        chi_square, freedom, probability: fields of `Misfit`.
    """

    items: tuple[Item, ...]
    chi_square: float
    freedom: float
    probability: float


def fit(outcome: Outcome) -> Fit:
    """How a reconstruction explains what was measured: see `Fit`."""
    tree, items = outcome.idata, []
    predicted = by_item(tree, "posterior_predictive").data_vars
    for name, measured in outcome.scene.evidence().items():
        if name not in predicted:
            items.append(Item(name, used=False))
            continue
        z = (np.asarray(predicted[name]).ravel() - measured.value) / measured.sd
        below = float(np.mean(z < 0))
        items.append(Item(name, True, -float(z.mean()), 2 * min(below, 1 - below)))
    off = misfit(tree["posterior"].data_vars, predicted, outcome.scene, noise=True)
    return Fit(tuple(items), *off)


@dataclass(frozen=True, slots=True)
class Summary:
    """A quantity's posterior (SI units).

    Args:
        median, sd: median and standard deviation of the draws.
        intervals: central intervals, by level in per cent of the draws.
    """

    median: float
    sd: float
    intervals: dict[int, tuple[float, float]]


def summary(draws: np.ndarray) -> Summary:
    """Median, sd and central intervals of draws, shape (any,)."""
    from arviz_stats import eti  # slow to import

    bounds = {level: eti(draws, prob=level / 100) for level in LEVELS}
    return Summary(
        float(np.median(draws)),
        float(np.std(draws, ddof=1)),
        {level: (float(low), float(high)) for level, (low, high) in bounds.items()},
    )
