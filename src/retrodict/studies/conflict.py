"""Which measurements disagree with all others, and how far an undetected error would move the answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.pareto import MAX_PARETO_K, smoothed
from retrodict.inference.pointwise import by_item

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome

MIN_PROBABILITY = 0.01  # below it a measurement is said to disagree


@dataclass(frozen=True, slots=True)
class LeftOut:
    """One item of evidence, its prediction from all others, and the answer without it (SI units).

    Args:
        name: flat name of the item.
        value, sd: measured value and its sd, the run-out's own error included in the sd.
        expected, expected_sd: mean and sd of the measurement as predicted from all else, its own error
            included.
        probability: two-sided probability of a measurement as far out as this one.
        speed, speed_sd: mean and sd of the sought speed (`Scene.sought`) without the item.
        pareto_k: Pareto k of the weights that leave the item out; above 0.7 the numbers from them
            cannot be relied on, because the answer without the item is far from that with it.
        believed: share of an error in the item that the posterior would follow, to first order; near 1
            nothing else contradicts the item. NaN where the likelihood is not normal.
        moved: shift of the sought speed by an error of one sd in the item, m/s, to first order; NaN
            where the likelihood is not normal.
        believed_error, moved_error: Monte Carlo standard errors of `believed` and `moved`.
    """

    name: str
    value: float
    sd: float
    expected: float
    expected_sd: float
    probability: float
    speed: float
    speed_sd: float
    pareto_k: float
    believed: float
    moved: float
    believed_error: float
    moved_error: float

    @property
    def reliable(self) -> bool:
        """Whether the weights that leave the item out can be relied on."""
        return self.pareto_k <= MAX_PARETO_K

    @property
    def disagrees(self) -> bool:
        """Whether its probability is below `MIN_PROBABILITY`, by weights that can be relied on."""
        return self.reliable and self.probability < MIN_PROBABILITY


def conflicts(outcome: Outcome) -> tuple[LeftOut, ...]:
    """The prediction of each item of evidence, and the answer, without that item.

    The draws are reweighted, by Pareto-smoothed importance sampling (Vehtari, Gelman and Gabry
    2017); nothing is sampled again.

    Args:
        outcome: the reconstruction.

    Returns:
        One record an item that the model explains; none of draws without predictions.
    """
    from arviz_stats import mcse  # slow to import

    tree = outcome.idata
    likelihood = by_item(tree, "log_likelihood")
    predictive = by_item(tree, "posterior_predictive")
    if "posterior" not in tree.children or not predictive.data_vars:
        return ()
    measured = outcome.scene.evidence()
    speeds = tree["posterior"][outcome.scene.sought]
    speed = np.asarray(speeds).ravel()
    found = []
    for name in map(str, likelihood.data_vars):
        if name not in measured:  # a term of the user's own, which predicts nothing
            continue
        weights, k = smoothed(-np.asarray(likelihood[name]).ravel())
        predictions = predictive[name]
        predicted = np.asarray(predictions).ravel()
        value, sd = measured[name].value, measured[name].sd
        beyond = weights @ (predicted > value)
        # the derivative of a posterior mean by a measured value is its covariance with the prediction
        off = (predictions - predictions.mean()) / sd
        shares = [off * off, off * (speeds - speeds.mean())]
        believed, moved = (float(share.mean()) for share in shares)
        errors = [float(mcse(share, method="mean")) for share in shares]
        if outcome.scene.robust:
            believed = moved = np.nan
        found.append(
            LeftOut(
                name,
                value,
                sd,
                *_moments(predicted, weights),
                float(2 * min(beyond, 1 - beyond)),
                *_moments(speed, weights),
                k,
                float(np.clip(believed - 1, 0, 1)),  # predictions hold the measurement's own error
                moved,
                *errors,
            )
        )
    return tuple(found)


def _moments(draws: np.ndarray, weights: np.ndarray) -> tuple[float, float]:
    mean = float(weights @ draws)
    return mean, float(np.sqrt(weights @ (draws - mean) ** 2))
