"""Misfit of all measurements together with what a model predicts of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from retrodict.scene.records import FREEDOM, Measured, Scene

UNEXPLAINED = "the model does not explain the measurements together"
UNSUPPORTED = "is beyond what tests at this closing speed support"
MIN_PROBABILITY = 0.01  # of so large a misfit; below it a model does not explain the measurements


class Misfit(NamedTuple):
    """A chi-square of evidence and inputs.

    At the posterior mean every measurement, of evidence and of inputs, has a residual in its
    standard deviations; for a linear model with normal errors their squares add up to a chi-square.
    Each measurement brings one degree of freedom, less the share of its variance that the
    posterior still has (its leverage; Spiegelhalter et al. 2002 count parameters likewise). Inputs
    count because a wrong model fits its evidence by pushing them away from what was measured.

    Args:
        chi_square: sum of the squared residuals.
        freedom: degrees of freedom of the chi-square, at least one.
        probability: probability of a chi-square at least as large, were the model true.
    """

    chi_square: float
    freedom: float
    probability: float


def misfit(
    posterior: Mapping[Any, Any], predicted: Mapping[Any, Any], scene: Scene, *, noise: bool
) -> Misfit:
    """Misfit of the measurements with the model, as defined in `Misfit`.

    Args:
        posterior: draws of the inputs, by name.
        predicted: draws of the evidence that the likelihood holds, by name.
        scene: scene with the measurements.
        noise: whether the predictions include the measurement's own error.
    """
    from scipy.special import chdtrc, logit, ndtri, stdtr

    squares, freedom = 0.0, 0.0
    of_noise = (FREEDOM / (FREEDOM - 2) if scene.robust else 1.0) if noise else 0.0
    for name, measured in scene.evidence().items():
        if name not in predicted:
            continue
        z = _standardised(predicted[name], measured)
        residual = abs(float(z.mean()))
        if scene.robust:  # the normal residual that is as improbable
            residual = float(-ndtri(stdtr(FREEDOM, -residual)))
        squares += residual**2
        freedom += 1 - (float(z.var()) - of_noise)
    for name, measured in scene.inputs().items():
        if measured.sd > 0 and name in posterior:
            if measured.law == "logitnormal":  # of a wide share only the logit is normal
                m, scale = measured.value, measured.sd / (measured.value * (1 - measured.value))
                z = (logit(np.asarray(posterior[name]).ravel()) - logit(m)) / scale
            else:
                z = _standardised(posterior[name], measured)
            squares += float(z.mean()) ** 2
            freedom += 1 - float(z.var())
    freedom = max(1.0, freedom)  # fewer would reject a model that fits everything
    return Misfit(squares, freedom, float(chdtrc(freedom, squares)))


def _standardised(draws: Any, measured: Measured) -> np.ndarray:
    return (np.asarray(draws).ravel() - measured.value) / measured.sd
