"""Posterior draws of quantities, as the studies of an answer take them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome


class NotAnswered(ValueError):
    """A question that these draws do not answer; the message says why."""


def draws_of(outcome: Outcome, name: str) -> np.ndarray:
    """Posterior draws of a quantity, or the value of an exact input in their place.

    Args:
        outcome: the reconstruction.
        name: flat name of the quantity.

    Returns:
        SI units, shape (chain, draw).

    Raises:
        NotAnswered: the model has no such quantity.
    """
    if "posterior" not in outcome.idata.children:
        raise NotAnswered("there are no draws")
    posterior = outcome.idata["posterior"]
    if name in posterior.data_vars:
        return np.asarray(posterior[name].values, dtype=float)
    inputs = outcome.scene.inputs()
    if name in inputs:
        return np.full(tuple(posterior.sizes.values()), inputs[name].value)
    raise NotAnswered(f"the model {outcome.description.name} has no {name}")


def error_of_mean(values: np.ndarray) -> float:
    """Monte Carlo standard error of the mean of draws, shape (chain, draw); NaN where all are equal."""
    from arviz_stats import mcse  # slow to import

    return float(mcse(xr.DataArray(values, dims=("chain", "draw")), method="mean"))


def effective_draws(values: np.ndarray) -> float:
    """Effective sample size of the tails of draws, shape (chain, draw)."""
    from arviz_stats import ess  # slow to import

    return float(ess(xr.DataArray(values, dims=("chain", "draw")), method="tail"))
