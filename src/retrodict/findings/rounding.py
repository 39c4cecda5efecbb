"""Rounding to the uncertainty, in one place for the terminal, the figures and the report."""

from __future__ import annotations

import math

from retrodict.inference.digits import decimals_of

NOTHING = "–"
_MINUS = "\N{MINUS SIGN}"


def format_value(value: float | None, decimals: int | None) -> str:
    """A number as it is printed.

    Args:
        value: number in the unit to be printed; None or not finite where there is none.
        decimals: number of decimals, from `decimals_of`; None prints six significant digits.

    Returns:
        The text, with a true minus sign; a dash where there is no value.
    """
    if value is None or not math.isfinite(value):
        return NOTHING
    if decimals is None:
        text = f"{value:.6g}"
    else:
        rounded = round(value, decimals) + 0.0  # + 0.0 takes the sign off a zero
        text = f"{rounded:.{max(decimals, 0)}f}"
    return text.replace("-", _MINUS)


def format_with_sd(value: float | None, sd: float | None, decimals: int | None = None) -> str:
    """A value ± its standard uncertainty, both to the same decimals.

    Args:
        value: number in the unit to be printed.
        sd: standard uncertainty of the value; 0 for an exact value, which is printed alone.
        decimals: number of decimals, from `decimals_of`; None leaves the uncertainty two significant
            digits.

    Returns:
        The text, such as "18.9 ± 1.2".
    """
    decimals = decimals_of(sd) if decimals is None else decimals
    if value is None or not math.isfinite(value):
        return NOTHING
    if decimals is None:
        return format_value(value, None)
    return f"{format_value(value, decimals)} ± {format_value(sd, decimals)}"


def format_range(bounds: tuple[float | None, float | None], decimals: int | None) -> str:
    """An interval as it is printed, such as "17.2 to 20.6".

    Args:
        bounds: lower and upper limit, in the unit to be printed.
        decimals: number of decimals, from `decimals_of` of the standard uncertainty.

    Returns:
        The text; a dash where there is no interval.
    """
    low, high = (format_value(bound, decimals) for bound in bounds)
    return NOTHING if NOTHING in (low, high) else f"{low} to {high}"
