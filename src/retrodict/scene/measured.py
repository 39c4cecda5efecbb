"""One measured quantity: value, standard deviation, error law and source."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

Law = Literal["normal", "lognormal", "logitnormal"]
UNKNOWN = "unknown"  # word of a scene file for a motion before impact that is not known


@dataclass(frozen=True, slots=True)
class Measured:
    """One measured quantity.

    Args:
        value: the best estimate, SI units or radians.
        sd: standard deviation, same unit; 0 for a quantity taken as exact.
        law: error law; "lognormal" (with this mean and sd) for quantities that cannot be negative;
            "logitnormal" for shares between 0 and 1: logit normal about logit(value) with scale
            sd / (value (1 - value)), by the delta method, so value is the median, and sd the
            standard deviation to first order. A share without an uncertainty may be exactly 0 or 1.
        source: author and method of the measurement, or source of an assumed uncertainty.
        assumed: "sd" where the uncertainty is a default, "value" where the value is one too, "stand-in"
            where nothing is known of the quantity and no model that applies uses it.
        model_sd: part of `sd` that is the error of the model which predicts the quantity, not of the
            measurement; same unit.
    """

    value: float
    sd: float = 0.0
    law: Law = "normal"
    source: str = ""
    assumed: Literal["", "sd", "value", "stand-in"] = ""
    model_sd: float = 0.0

    @property
    def measured_sd(self) -> float:
        """Standard deviation of the measurement alone, without `model_sd`."""
        return math.sqrt(self.sd**2 - self.model_sd**2) if self.model_sd else self.sd

    @property
    def location_and_scale(self) -> tuple[float, float]:
        """Location and scale of the normal law, or of the one under a lognormal or logitnormal law."""
        import numpy as np  # reading a scene does without

        if self.law == "logitnormal" and self.sd > 0:  # sd to first order
            share = self.value * (1 - self.value)
            return float(np.log(self.value / (1 - self.value))), self.sd / share
        if self.law == "lognormal" and self.sd > 0:
            variance = np.log1p((self.sd / self.value) ** 2)
            return float(np.log(self.value) - variance / 2), float(np.sqrt(variance))
        return self.value, self.sd

    def with_model_sd(self, model_sd: float) -> Measured:
        """A copy with a model's error, independent of the measurement's, added to it."""
        if not model_sd:
            return self
        return replace(self, sd=math.hypot(self.sd, model_sd), model_sd=model_sd)
