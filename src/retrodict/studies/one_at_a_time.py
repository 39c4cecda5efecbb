"""How far an answer would move, were one measurement one standard deviation higher."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.pointwise import by_item
from retrodict.studies.draws import draws_of, error_of_mean

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.measured import Measured


@dataclass(frozen=True, slots=True)
class Effect:
    """The effect of one measurement on an answer (SI units).

    Args:
        name: flat name of the measured input or item of evidence.
        measured: measured value and its sd, as in the scene.
        moved: shift of the answer, were the measurement one standard deviation higher.
        error: Monte Carlo standard error of `moved`.
    """

    name: str
    measured: Measured
    moved: float
    error: float


def one_at_a_time(outcome: Outcome, sought: str) -> tuple[Effect, ...]:
    """How far the posterior mean of an answer would move with each measurement, all else as it is.

    To first order: the derivative of a posterior mean by the location of a normal prior, or by a
    measured value with normal errors, is the covariance of the answer with the quantity over the
    square of the standard deviation. Lognormal and logit-normal inputs count by their deviates.

    Args:
        outcome: the reconstruction.
        sought: the answer's flat name.

    Returns:
        One record an uncertain measurement, the one that moves the answer the most first; without the
        evidence where its errors have heavy tails, because the derivative is another there.

    Raises:
        NotAnswered: the answer has no draws.

    Source:
        Exponential families: Diaconis and Ylvisaker (1979); as a local sensitivity of posterior means,
        Gustafson (2000), "Local robustness in Bayesian analysis".
    """
    tree, scene = outcome.idata, outcome.scene
    answer = draws_of(outcome, sought)
    answer = answer - answer.mean()
    found = []

    def add(name: str, measured: Measured, deviates: np.ndarray) -> None:
        share = (deviates - deviates.mean()) * answer
        found.append(Effect(name, measured, float(share.mean()), error_of_mean(share)))

    for name, m in scene.inputs().items():
        if m.sd > 0 and name in tree["posterior"]:
            location, scale = m.location_and_scale
            add(name, m, (_of_law(draws_of(outcome, name), m) - location) / scale)
    predicted = {} if scene.robust else by_item(tree, "posterior_predictive").data_vars
    for name, m in scene.evidence().items():
        if name in predicted:
            add(name, m, np.asarray(predicted[name]) / m.sd)
    return tuple(sorted(found, key=lambda each: -abs(each.moved)))


def _of_law(x: np.ndarray, m: Measured) -> np.ndarray:
    """A quantity in the scale in which its law is normal."""
    if m.law == "lognormal":
        return np.log(x)
    return np.log(x / (1 - x)) if m.law == "logitnormal" else x
