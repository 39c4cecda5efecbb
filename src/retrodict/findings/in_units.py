"""Values of an answer in words: in each unit that a reader may know, side by side."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from retrodict.findings.rounding import format_value, format_with_sd
from retrodict.inference.digits import decimals_of
from retrodict.scene.quantities import Unit, Units, describe, unit_of

if TYPE_CHECKING:
    from retrodict.scene.asked import Proposition
    from retrodict.scene.measured import Measured
    from retrodict.studies.avoidability import Share
    from retrodict.studies.probability import Probability


def clause(statement: Proposition, units: Units) -> str:
    """A proposition as a clause with its article, or several joined; limits in SI and US units."""
    if statement.joined:
        parts = [
            f"({clause(each, units)})" if each.joined else clause(each, units)
            for each in statement.parts
        ]
        return f" {statement.joined} ".join(parts)
    return f"the {proposition_in_words(statement, units)}"


def proposition_in_words(proposition: Proposition, units: Units) -> str:
    """A proposition as a clause without its article, limits in SI and US units."""
    label = describe(proposition.name)[0]
    if proposition.other:
        sign = "plus" if proposition.sign == 1 else "less"
        label += f", {sign} the {describe(proposition.other)[0]},"
    return f"{label} is {range_in_words(proposition, units)}"


def range_in_words(proposition: Proposition, units: Units) -> str:
    """The limits of a proposition, in all units."""
    dimension, low, high = describe(proposition.name)[1], proposition.low, proposition.high
    if math.isinf(high):
        return f"above {exact(low, dimension, units)}"
    if math.isinf(low):
        return f"below {exact(high, dimension, units)}"
    return f"between {exact(low, dimension, units)} and {exact(high, dimension, units)}"


def units_of(dimension: str, first: Units) -> list[Unit]:
    """All units that a dimension is given in; of speeds km/h, which a court outside the US reads."""
    si, us = unit_of(dimension, "si"), unit_of(dimension, "us")
    if si == us:
        return [si]
    metric = [si, Unit("km/h", 1 / 3.6)] if dimension == "speed" else [si]
    return [us, *metric] if first == "us" else [*metric, us]


def _text(
    value: float, dimension: str, units: Units, decimals: Callable[[float], int | None]
) -> str:
    """A value in each unit; `decimals` takes what the unit is worth."""
    values = (
        format_value(value / unit.worth, decimals(unit.worth))
        for unit in units_of(dimension, units)
    )
    return side_by_side(values, dimension, units)


def side_by_side(values: Iterable[str], dimension: str, units: Units) -> str:
    """A value as printed in each of `_units`, with their symbols."""
    pairs = zip(values, units_of(dimension, units), strict=True)
    first, *others = (f"{value} {unit.symbol}".rstrip() for value, unit in pairs)
    return f"{first} ({'; '.join(others)})" if others else first


def exact(value: float, dimension: str, units: Units) -> str:
    """A limit that somebody wrote in one of the units, to four digits in each."""
    return _text(value, dimension, units, lambda worth: _trimmed(value / worth))


def to_tenths(value: float, dimension: str, units: Units) -> str:
    """A value in all units, to one decimal."""
    return _text(value, dimension, units, lambda _: 1)


def _trimmed(value: float) -> int | None:
    """Decimals of at most four significant digits, without zeros at the end."""
    most = decimals_of(abs(value), digits=4)
    if most is None:
        return 0
    return next(d for d in range(min(most, 0), most + 1) if round(value, d) == round(value, most))


def with_sd(value: float, sd: float, dimension: str, units: Units) -> str:
    """A value ± sd in each unit, to two digits of the sd."""
    values = (
        format_with_sd(value / unit.worth, sd / unit.worth) if sd else f"{value:g}"
        for unit in units_of(dimension, units)
    )
    return side_by_side(values, dimension, units)


def as_measured(m: Measured, unit: Unit) -> str:
    """A measurement with its standard deviation, in a unit."""
    return (
        f"{format_with_sd(m.value / unit.worth, m.measured_sd / unit.worth)} {unit.symbol}".rstrip()
    )


def quantile_row(
    what: str, quantiles: tuple[float, ...], dimension: str, units: Units
) -> tuple[str, str, str]:
    """What, its median, and between what 95 % of the draws lie."""
    low, middle, high = quantiles
    ends = (
        f"{format_value(low / unit.worth, 1)} to {format_value(high / unit.worth, 1)}"
        for unit in units_of(dimension, units)
    )
    return what, to_tenths(middle, dimension, units), side_by_side(ends, dimension, units)


def _per_cent(value: float, error: float) -> str:
    decimals = decimals_of(100 * error, digits=1)
    return f"{format_value(100 * value, decimals)} % ± {format_value(100 * error, decimals)} %"


def of_draws(share: Share | Probability) -> str:
    """A share of the draws with its Monte Carlo standard error."""
    if share.value == 0:
        return "none of the draws"
    if share.value == 1 or share.error is None:
        return "all draws"
    return f"{_per_cent(share.value, share.error)} of the draws"
