"""Statistics and diagnostics of the posterior draws of each quantity, and the digits to print."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import xarray as xr

from retrodict.findings.severity import pdof
from retrodict.inference.digits import decimals_of, monte_carlo_error
from retrodict.inference.pointwise import by_item
from retrodict.scene.quantities import (
    DERIVED,
    UNKNOWNS,
    Unit,
    Units,
    describe,
    si_symbol,
    unit_of,
)

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome

LEVELS = (50, 90, 95)  # per cent; not those of studies.fit, which brings JAX
Interval = tuple[float | None, float | None]


@dataclass(frozen=True, slots=True)
class Precision:
    """How a quantity's numbers are printed in a system of units.

    Args:
        unit: unit that the numbers are printed in.
        decimals: decimals of median, mean and sd; None where there is no uncertainty to round to.
        of_level: decimals of the limits of each interval, by level in per cent; None as in `decimals`.
    """

    unit: Unit
    decimals: int | None
    of_level: dict[int, int | None]


@dataclass(frozen=True, slots=True)
class Quantity:
    """What the posterior draws say of a quantity (SI units, radians); None where not finite.

    Args:
        name: flat name of the quantity.
        label: name in words.
        unit: symbol of the SI unit that its numbers are in.
        mean, sd, median: mean, standard deviation and median of the draws.
        intervals: central intervals, by level in per cent of the draws: as many draws lie below as
            above.
        ess_bulk, ess_tail, rhat: bulk and tail effective sample size, and R-hat.
        mcse_mean: Monte Carlo standard error of the mean.
        error: Monte Carlo standard error of mean and median, the larger.
        errors: Monte Carlo standard error of the limits of each interval, the larger, by level.
        passed: whether the quantity has numbers, and no check of its own failed.
        withheld: whether the numbers are withheld, because a check of the quantity or of what it
            follows from failed.
        precision: unit and decimals that the numbers are printed with, by system of units.
    """

    name: str
    label: str
    unit: str
    mean: float | None
    sd: float | None
    median: float | None
    intervals: dict[int, Interval]
    ess_bulk: float | None
    ess_tail: float | None
    rhat: float | None
    mcse_mean: float | None
    error: float | None
    errors: dict[int, float | None]
    passed: bool
    withheld: bool
    precision: dict[Units, Precision]

    def __repr__(self) -> str:
        if self.withheld:
            numbers = "withheld"
        elif self.mean is None or self.sd is None:
            numbers = "no numbers"
        else:
            numbers = f"mean {self.mean:.4g}, sd {self.sd:.2g} {self.unit}".rstrip()
        return f"<Quantity {self.name}: {numbers}>"


def reported(outcome: Outcome, names: Iterable[str] | None = None) -> tuple[str, ...]:
    """The quantities that a model has draws of: a simpler one has fewer.

    Args:
        outcome: the reconstruction.
        names: names to choose from; None for the quantities that the scene reports.

    Returns:
        The names that the model has draws of, in their order; all where there are no draws.
    """
    names = outcome.scene.reported() if names is None else names
    if "posterior" not in outcome.idata.children:
        return tuple(names)
    known = posterior_of(outcome).data_vars
    return tuple(name for name in names if name in known)


def posterior_of(outcome: Outcome) -> xr.Dataset:
    """The draws, with what is derived of them here; empty where there are none."""
    if "posterior" not in outcome.idata.children:
        return xr.Dataset()
    draws = outcome.idata["posterior"].to_dataset()
    return draws.assign(pdof(draws, outcome.scene))


def statistics(outcome: Outcome, names: Iterable[str]) -> dict[str, Quantity]:
    """Mean, sd, median, central intervals, diagnostics and digits of quantities.

    Args:
        outcome: the reconstruction.
        names: names of variables in the posterior group, each once.

    Returns:
        One record a name, whether there are draws of it or not.
    """
    # arviz_stats takes a while to import, and findings are not always asked for
    from arviz_stats import eti

    names, posterior, checks = tuple(names), posterior_of(outcome), outcome.checks
    data = posterior[[name for name in names if name in posterior.data_vars]]
    measures, intervals = {}, {}
    if data.data_vars:
        with np.errstate(all="ignore"):
            measures = _measures(data)
            intervals = {level: eti(data, prob=level / 100) for level in LEVELS}

    def number(measure: str, name: str) -> float | None:
        return finite(measures[measure][name]) if name in data else None

    def interval(level: int, name: str) -> Interval:
        if name not in data:
            return None, None
        low, high = intervals[level][name].values
        return finite(low), finite(high)

    found = {}
    for name in names:
        label, dimension = describe(name)
        mean, sd, error = (number(each, name) for each in ("mean", "sd", "error"))
        errors = {level: number(f"error_{level}", name) for level in LEVELS}
        found[name] = Quantity(
            name=name,
            label=label,
            unit=si_symbol(dimension),
            mean=mean,
            sd=sd,
            median=number("median", name),
            intervals={level: interval(level, name) for level in LEVELS},
            ess_bulk=number("ess_bulk", name),
            ess_tail=number("ess_tail", name),
            rhat=number("rhat", name),
            mcse_mean=number("mcse_mean", name),
            error=error,
            errors=errors,
            passed=mean is not None and name not in checks.failed,
            withheld=name in checks.failed or (name in DERIVED and bool(checks.failed)),
            precision={
                units: _precision(unit_of(dimension, units), sd, error, errors)
                for units in get_args(Units)
            },
        )
    return found


def _measures(data: xr.Dataset) -> dict[str, xr.Dataset]:
    """Moments, diagnostics and Monte Carlo errors of draws, by name of the measure."""
    from arviz_stats import ess, mcse, rhat

    of_mean = mcse(data, method="mean")
    return {
        "mean": data.mean(),
        "sd": data.std(ddof=1),
        "median": data.median(),
        "ess_bulk": ess(data, method="bulk"),
        "ess_tail": ess(data, method="tail"),
        "rhat": rhat(data, method="rank"),
        "mcse_mean": of_mean,
        "error": monte_carlo_error(data, 0, of_mean),
        **{f"error_{level}": monte_carlo_error(data, level / 100) for level in LEVELS},
    }


def _precision(
    unit: Unit, sd: float | None, error: float | None, errors: dict[int, float | None]
) -> Precision:
    """Two digits of the standard deviation, or fewer where a Monte Carlo error reaches them."""
    sd = scaled(sd, unit.worth)
    of_level = {
        level: decimals_of(sd, error=scaled(each, unit.worth)) for level, each in errors.items()
    }
    return Precision(unit, decimals_of(sd, error=scaled(error, unit.worth)), of_level)


def correlations(outcome: Outcome) -> dict[tuple[str, str], float]:
    """Coefficients of correlation of the unknowns, pair by pair, over all draws.

    Args:
        outcome: the reconstruction.

    Returns:
        By names in the order of `UNKNOWNS`; no pair of which one has no draws, or does not vary.
    """
    asked = [name for name in UNKNOWNS if name in outcome.scene.reported()]
    values = {name: finite_draws(outcome, "posterior", name) for name in asked}
    vary = {name: x for name, x in values.items() if x is not None and np.ptp(x) > 0}
    return {
        (one, other): float(np.corrcoef(x, y)[0, 1])
        for (one, x), (other, y) in combinations(vary.items(), 2)
        if x.size == y.size
    }


def finite_draws(outcome: Outcome, group: str, name: str) -> np.ndarray | None:
    """The finite draws of a variable in one row, or None where the group or variable is missing."""
    known = by_item(outcome.idata, group)
    if name not in known.data_vars:
        return None
    values = np.asarray(known[name], dtype=float).ravel()
    values = values[np.isfinite(values)]
    return values if values.size else None


def scaled(value: float | None, worth: float) -> float | None:
    """A number in a unit of that worth; None stays None."""
    return None if value is None else value / worth


def scaled_interval(bounds: Interval, worth: float) -> Interval:
    """Both bounds in a unit of that worth; None stays None."""
    low, high = bounds
    return scaled(low, worth), scaled(high, worth)


def finite(value: Any) -> float | None:
    """A number, or None where it is not finite."""
    number = float(value)
    return number if math.isfinite(number) else None
