"""Rounding to the uncertainty, in one place for the terminal, the figures and the report."""

from __future__ import annotations

import math

NOTHING = "–"
_MINUS = "\N{MINUS SIGN}"


def decimals_of(sd: float | None, digits: int = 2) -> int | None:
    """Decimals that leave an uncertainty with so many significant digits (JCGM 100:2008, 7.2.6).

    Args:
        sd: the standard uncertainty, in the unit to be printed.
        digits: significant digits kept of it.

    Returns:
        Decimals, negative for tens and up; None where there is no uncertainty to round to.
    """
    if sd is None or not math.isfinite(sd) or sd <= 0:
        return None
    places = digits - 1 - math.floor(math.log10(sd))
    # 0.0996 rounds up to 0.100, which is a digit more than was asked for
    if math.floor(math.log10(round(sd, places))) > math.floor(math.log10(sd)):
        places -= 1
    return places


def told(value: float | None, decimals: int | None) -> str:
    """A number as it is printed.

    Args:
        value: in the unit to be printed; None or not finite where there is none.
        decimals: from `decimals_of`; None prints six significant digits.

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


def told_with_sd(value: float | None, sd: float | None) -> str:
    """A value ± its standard uncertainty, both to the latter's two significant digits.

    Args:
        value: in the unit to be printed.
        sd: its standard uncertainty; 0 for an exact value, which is told alone.

    Returns:
        The text, such as "18.9 ± 1.2".
    """
    decimals = decimals_of(sd)
    if value is None or not math.isfinite(value):
        return NOTHING
    if decimals is None:
        return told(value, None)
    return f"{told(value, decimals)} ± {told(sd, decimals)}"


def told_range(bounds: tuple[float | None, float | None], decimals: int | None) -> str:
    """An interval as it is printed, such as "17.2 to 20.6".

    Args:
        bounds: lower and upper, in the unit to be printed.
        decimals: from `decimals_of` of the standard uncertainty.

    Returns:
        The text; a dash where there is no interval.
    """
    low, high = (told(bound, decimals) for bound in bounds)
    return NOTHING if NOTHING in (low, high) else f"{low} to {high}"
