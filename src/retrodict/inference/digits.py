"""How many decimals of a number its uncertainty, and the error of drawing it, bear out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

_QUANTILES = (0.025, 0.5, 0.975)  # lower limit of the 95 % interval, median, upper limit


def decimals_of(sd: float | None, digits: int = 2, error: float | None = None) -> int | None:
    """Decimals that leave an uncertainty with so many significant digits (JCGM 100:2008, 7.2.6).

    Fewer where a number's own error is not below half a unit of the last (JCGM 101:2008, 7.9.2).

    Args:
        sd: the standard uncertainty, in the unit to be printed.
        digits: significant digits kept of it.
        error: of the numbers to be printed, in the same unit; None where there is none.

    Returns:
        Decimals, negative for tens and up; None where there is no uncertainty to round to.
    """
    if sd is None or not math.isfinite(sd) or sd <= 0:
        return None
    places = digits - 1 - math.floor(math.log10(sd))
    # 0.0996 rounds up to 0.100, which is a digit more than was asked for
    if math.floor(math.log10(round(sd, places))) > math.floor(math.log10(sd)):
        places -= 1
    if error is None or not math.isfinite(error) or error <= 0:
        return places
    return min(places, math.ceil(-math.log10(2 * error)) - 1)


def monte_carlo_errors(draws: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """Standard errors of each variable's middle and of its 95 % limits, the larger of two each.

    Args:
        draws: with dimensions chain and draw.

    Returns:
        Of mean and median, and of the quantiles that leave 2.5 % at either end, in the variables'
        units (Vehtari et al. 2021).
    """
    import numpy as np
    from arviz_stats import mcse  # slow to import

    mean = mcse(draws, method="mean")
    low, median, high = (mcse(draws, method="quantile", prob=p) for p in _QUANTILES)
    return np.maximum(mean, median), np.maximum(low, high)
