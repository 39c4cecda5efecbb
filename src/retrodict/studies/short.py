"""An answer in short: mean, sd, median, central 95 % and Monte Carlo error of each reported quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from retrodict.studies.draws import error_of_mean

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.inference.points import Estimate

STATISTICS = ("mean", "sd", "median", "low_95", "high_95", "mcse_mean")
Short = dict[str, dict[str, float]]  # by quantity and statistic, SI units and radians

_LIMITS = np.array([0.025, 0.5, 0.975])


def of_points(estimate: Estimate) -> Short:
    """The statistics of a posterior by weighted points.

    Args:
        estimate: the weighted points.

    Returns:
        Statistics of each reported quantity that the model has.
    """
    found, weighted = {}, estimate.weighted
    for name in estimate.scene.reported():
        if name not in estimate.quantities:
            continue
        values = estimate.quantities[name]
        mean, error = weighted.mean(values)
        low, median, high = weighted.quantiles(values, _LIMITS)[0]
        found[name] = _listed(mean, weighted.sd(values)[0], median, low, high, error)
    return found


def of_draws(outcome: Outcome) -> Short:
    """The statistics of a posterior by draws.

    Args:
        outcome: the reconstruction.
    """
    found = {}
    for name in outcome.scene.reported():
        if name not in outcome.idata["posterior"].data_vars:
            continue
        values = np.asarray(outcome.idata["posterior"][name].values, dtype=float)
        low, median, high = np.quantile(values, _LIMITS)
        found[name] = _listed(values.mean(), values.std(), median, low, high, error_of_mean(values))
    return found


def _listed(*numbers: float) -> dict[str, float]:
    return {name: float(number) for name, number in zip(STATISTICS, numbers, strict=True)}
