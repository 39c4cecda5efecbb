"""The evidence as one variable of many items, as ArviZ's loo and predictive checks take it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

NAME, ITEM = "evidence", "item"


def pointwise(idata: xr.DataTree) -> xr.DataTree:
    """Draws with the whole evidence in one variable, `evidence`, of dimension `item`.

    Measurements and predictions are in standard deviations of the measurement, less the mean of the
    posterior predictions, so that metres and degrees lie on one axis.

    Args:
        idata: draws, with the groups of `Outcome.idata`.

    Returns:
        Groups posterior and sample_stats as they are; log_likelihood, posterior_predictive and
        observed_data with that one variable.

    Raises:
        ValueError: there are no draws.
    """
    import xarray as xr

    if not {"posterior", "log_likelihood", "posterior_predictive"} <= set(idata.children):
        raise ValueError("a result without draws has no pointwise evidence")
    observed = idata["observed_data"].to_dataset()
    items = list(observed.data_vars)
    sd = idata["constant_data"].to_dataset()
    sd = sd[[f"{name}_sd" for name in items]].rename({f"{name}_sd": name for name in items})
    predicted = idata["posterior_predictive"].to_dataset()[items]
    about = predicted.mean(("chain", "draw"))

    def one(values: xr.Dataset, *dims: str) -> xr.Dataset:
        stacked = values[items].to_array(ITEM, NAME).transpose(*dims, ITEM)
        return xr.Dataset({NAME: stacked.drop_attrs()})

    groups = {
        "posterior": idata["posterior"].to_dataset(),
        "sample_stats": idata["sample_stats"].to_dataset(),
        "log_likelihood": one(idata["log_likelihood"].to_dataset(), "chain", "draw"),
        "posterior_predictive": one((predicted - about) / sd, "chain", "draw"),
        "observed_data": one((observed - about) / sd),
    }
    tree = xr.DataTree.from_dict({f"/{name}": group for name, group in groups.items()})
    tree.attrs = dict(idata.attrs)
    return tree
