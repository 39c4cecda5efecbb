"""Measured inputs and items of evidence, each with what the reconstruction made of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from retrodict.findings.rounding import format_value, format_with_sd
from retrodict.findings.statistics import finite_draws, scaled
from retrodict.inference.digits import decimals_of
from retrodict.scene.quantities import Units, label_and_unit

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Measured

ASSUMED = {"": "", "sd": "uncertainty assumed", "value": "value and uncertainty assumed"}
QUANTILES = (0.025, 0.25, 0.5, 0.75, 0.975)


@dataclass(frozen=True, slots=True)
class InputRow:
    """A measured quantity and what the reconstruction made of it (SI units, radians).

    Args:
        name: flat name of the quantity.
        kind: "input" or "evidence".
        measured: measured value and its sd, as in the scene.
        mean: posterior mean of an input, posterior-predictive mean of an item of evidence.
        sd: posterior sd of an input, posterior-predictive sd of an item of evidence.
        shift: mean less measured value, in standard deviations of the measurement with the model's
            error included; None for an exact input.
        quantiles: `QUANTILES` of the same draws less the measured value, in units as of `shift`.
    """

    name: str
    kind: Literal["input", "evidence"]
    measured: Measured
    mean: float | None = None
    sd: float | None = None
    shift: float | None = None
    quantiles: tuple[float, ...] | None = None

    @property
    def label(self) -> str:
        """Label of the quantity, in words."""
        return label_and_unit(self.name, "si")[0]

    @property
    def source(self) -> str:
        """Who measured it and how."""
        return self.measured.source

    @property
    def assumed(self) -> str:
        """What of it is a default: "" (nothing), "sd" or "value"."""
        return self.measured.assumed

    def unit(self, units: Units) -> str:
        """Symbol of the unit that the quantity is printed in."""
        return label_and_unit(self.name, units)[1].symbol

    def format_measured(self, units: Units) -> str:
        """Measured value ± sd of the measurement, rounded."""
        worth = label_and_unit(self.name, units)[1].worth
        return format_with_sd(self.measured.value / worth, self.measured.measured_sd / worth)

    def format_model(self, units: Units) -> str:
        """Assumed error of the model in the quantity, one sd, rounded; empty where there is none."""
        sd = self.measured.model_sd / label_and_unit(self.name, units)[1].worth
        return f"± {format_value(sd, decimals_of(sd))}" if sd else ""

    def format_found(self, units: Units) -> str:
        """Posterior or predictive mean ± sd, rounded."""
        worth = label_and_unit(self.name, units)[1].worth
        return format_with_sd(scaled(self.mean, worth), scaled(self.sd, worth))

    def format_shift(self) -> str:
        """The shift with its sign, to a tenth of a standard deviation."""
        text = format_value(self.shift, 1)
        return f"+{text}" if self.shift is not None and round(self.shift, 1) > 0 else text


def input_rows(outcome: Outcome) -> tuple[InputRow, ...]:
    """Every measured input and item of evidence with what became of it.

    Args:
        outcome: the reconstruction.

    Returns:
        Rows: the inputs in the scene's order, then the evidence.
    """
    rows = []
    kinds: tuple[tuple[Literal["input", "evidence"], str, dict[str, Measured]], ...] = (
        ("input", "posterior", outcome.scene.stated()),
        ("evidence", "posterior_predictive", outcome.scene.evidence()),
    )
    for kind, group, items in kinds:
        for name, measured in items.items():
            values = finite_draws(outcome, group, name) if measured.sd > 0 else None
            if values is None:
                rows.append(InputRow(name, kind, measured))
                continue
            mean, sd = float(values.mean()), float(values.std(ddof=min(1, values.size - 1)))
            shift = (mean - measured.value) / measured.sd
            apart = np.quantile((values - measured.value) / measured.sd, QUANTILES)
            rows.append(InputRow(name, kind, measured, mean, sd, shift, tuple(map(float, apart))))
    return tuple(rows)
