"""Number of decimals that the uncertainty of a number, and its Monte Carlo error, support."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


def decimals_of(sd: float | None, digits: int = 2, error: float | None = None) -> int | None:
    """Decimals that leave an uncertainty with so many significant digits (JCGM 100:2008, 7.2.6).

    Fewer where a number's own error is not below a unit of the last.

    Args:
        sd: the standard uncertainty, in the unit to be printed.
        digits: significant digits kept of it.
        error: standard error of the numbers to be printed, in the same unit; None where there is none.

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
    return min(places, math.ceil(-math.log10(error)) - 1)


def monte_carlo_error(
    draws: xr.Dataset, level: float, of_mean: xr.Dataset | None = None
) -> xr.Dataset:
    """The larger standard error of the limits of each variable's interval (Vehtari et al. 2021).

    Args:
        draws: draws of each variable, with dimensions chain and draw.
        level: probability of the interval, which has equal tails; 0 for mean and median.
        of_mean: standard error of the mean, where it has been computed already.

    Returns:
        The errors, in the variables' units.
    """
    import numpy as np
    from arviz_stats import mcse  # slow to import

    low = mcse(draws, method="quantile", prob=0.5 - level / 2)
    if level == 0:
        return np.maximum(mcse(draws, method="mean") if of_mean is None else of_mean, low)
    return np.maximum(low, mcse(draws, method="quantile", prob=0.5 + level / 2))


def rhat_text(rhat: float | None) -> str:
    """R-hat as it is printed: "over 100" for larger values, as chains that stand still have.

    Args:
        rhat: R-hat; None or not finite where there is none.
    """
    if rhat is None or not math.isfinite(rhat):
        return "–"
    return "over 100" if rhat > 100 else f"{rhat:.3f}"
