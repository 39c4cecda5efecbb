"""What a reconstruction comes to: how it explains the evidence, and its answers in short."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.scene.records import FREEDOM

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Measured

LEVELS = (50, 90, 95)  # per cent


@dataclass(frozen=True, slots=True)
class Item:
    """How a rung explains one item of evidence.

    Args:
        name: its flat name.
        used: whether the rung's likelihood holds it.
        residual: measured less predicted mean, in measured standard deviations; None where the rung
            does not predict it.
        probability: two-sided, that a prediction lies as far out as what was measured.
    """

    name: str
    used: bool
    residual: float | None = None
    probability: float | None = None


@dataclass(frozen=True, slots=True)
class Fit:
    """How a rung explains the evidence it uses and the measured inputs, together.

    At the posterior mean every measurement, of evidence and of inputs, has a residual in its
    standard deviations; of a linear model with normal errors their squares add up to a chi-square.
    Each measurement brings one degree of freedom, less the share of its variance that the
    posterior still has (its leverage; Spiegelhalter et al. 2002 count parameters likewise). Inputs
    count because a wrong rung fits its evidence by pushing them away from what was measured.

    Args:
        items: of the evidence, used or not.
        chi_square: sum of the squared residuals.
        freedom: its degrees of freedom, at least one.
        probability: of so large a chi-square or a larger one, were the rung true.
    """

    items: tuple[Item, ...]
    chi_square: float
    freedom: float
    probability: float


def fit(outcome: Outcome) -> Fit:
    """How a reconstruction explains what was measured: see `Fit`."""
    from scipy.special import chdtrc, logit, ndtri, stdtr

    tree, robust = outcome.idata, outcome.scene.robust
    noise = FREEDOM / (FREEDOM - 2) if robust else 1.0  # variance, of a prediction's own error
    used = set(tree["log_likelihood"].data_vars)
    items, squares, freedom = [], 0.0, 0.0

    def standardised(group: str, name: str, measured: Measured) -> np.ndarray:
        return (np.asarray(tree[group][name]).ravel() - measured.value) / measured.sd

    for name, measured in outcome.scene.evidence().items():
        if name not in tree["posterior_predictive"].data_vars:
            items.append(Item(name, used=False))
            continue
        z = standardised("posterior_predictive", name, measured)
        below = float(np.mean(z < 0))
        items.append(Item(name, name in used, -float(z.mean()), 2 * min(below, 1 - below)))
        if name in used:
            residual = abs(z.mean())
            if robust:  # the normal residual that is as improbable
                residual = -ndtri(stdtr(FREEDOM, -residual))
            squares += residual**2
            freedom += 1 - (z.var() - noise)  # predictions have the measurement's error on them
    for name, measured in outcome.scene.inputs().items():
        if measured.sd > 0 and name in tree["posterior"].data_vars:
            if measured.law == "logitnormal":  # of a wide share only the logit is normal
                m, scale = measured.value, measured.sd / (measured.value * (1 - measured.value))
                z = (logit(np.asarray(tree["posterior"][name]).ravel()) - logit(m)) / scale
            else:
                z = standardised("posterior", name, measured)
            squares += z.mean() ** 2
            freedom += 1 - z.var()
    freedom = max(1.0, float(freedom))  # fewer would reject a rung that fits everything
    return Fit(tuple(items), float(squares), freedom, float(chdtrc(freedom, squares)))


@dataclass(frozen=True, slots=True)
class Summary:
    """A quantity's posterior (SI units).

    Args:
        median, sd: of the draws.
        intervals: the shortest that hold so many per cent of the draws.
    """

    median: float
    sd: float
    intervals: dict[int, tuple[float, float]]


def summary(draws: np.ndarray) -> Summary:
    """Median, sd and shortest intervals of draws, shape (any,)."""
    from arviz_stats import hdi  # slow to import

    bounds = {level: hdi(draws, prob=level / 100, method="nearest") for level in LEVELS}
    return Summary(
        float(np.median(draws)),
        float(np.std(draws, ddof=1)),
        {level: (float(low), float(high)) for level, (low, high) in bounds.items()},
    )
