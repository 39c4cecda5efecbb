"""The evidence as one variable of many items, as ArviZ's loo and predictive checks take it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from retrodict.scene.quantities import describe, si_symbol

if TYPE_CHECKING:
    import xarray as xr

NAME, ITEM = "evidence", "item"
_SCALED = ("posterior_predictive", "prior_predictive", "observed_data")
_LABEL = "evidence less its mean posterior prediction, in standard deviations of the measurement"


def pointwise(idata: xr.DataTree) -> xr.DataTree:
    """Draws with the whole evidence in one variable, `evidence`, of dimension `item`.

    Measurements and predictions are in standard deviations of the measurement, less the mean of the
    posterior predictions, so that metres and degrees lie on one axis. `constant_data` has both numbers,
    `sd` and `centre`, and the unit of each item.

    Args:
        idata: draws, with a variable for each item of evidence in observed_data, posterior_predictive,
            prior_predictive and log_likelihood, and the standard deviations in constant_data.

    Returns:
        The same tree with that one variable in these groups; as it is where it has it already, or holds
        no evidence or no predictions.
    """
    import xarray as xr

    groups = {str(name): node.to_dataset() for name, node in idata.children.items()}
    observed = groups.get("observed_data", xr.Dataset())
    items = [str(name) for name in observed.data_vars]
    if not items or NAME in items or "posterior_predictive" not in groups:
        return idata
    predicted = groups["posterior_predictive"]
    sd = groups["constant_data"][[f"{name}_sd" for name in items]]
    sd = sd.rename({f"{name}_sd": name for name in items})
    centre = predicted[items].mean()

    def one(values: xr.Dataset) -> xr.DataArray:
        return values[items].to_array(ITEM, NAME).transpose(..., ITEM).drop_attrs()

    for group in groups.keys() & {*_SCALED, "log_likelihood"}:
        values = groups[group]
        stacked = one((values - centre) / sd if group in _SCALED else values)
        label = _LABEL if group in _SCALED else "log likelihood"
        others = values.drop_vars(items) if group == "log_likelihood" else xr.Dataset()  # own terms
        groups[group] = others.assign({NAME: stacked.assign_attrs(unit="", label=label)})
    labels, dimensions = zip(*map(describe, items), strict=True)
    groups["constant_data"] = xr.Dataset(
        {"sd": one(sd), "centre": one(centre)},
        coords={"unit": (ITEM, [*map(si_symbol, dimensions)]), "label": (ITEM, list(labels))},
    )
    tree = xr.DataTree.from_dict({f"/{name}": group for name, group in groups.items()})
    tree.attrs = dict(idata.attrs)
    return tree


def by_item(idata: xr.DataTree, group: str) -> xr.Dataset:
    """A group of draws with a variable for each item of evidence, in SI units and radians.

    Args:
        idata: draws, before or after `pointwise`.
        group: name of the group.

    Returns:
        The variables by name of the item; none where there is no such group.
    """
    import xarray as xr

    if group not in idata.children:
        return xr.Dataset()
    found = idata[group].to_dataset()
    if NAME not in found:
        return found
    values, others = found[NAME], found.drop_vars([NAME, ITEM])
    if group in _SCALED:
        scale = idata["constant_data"].to_dataset().reset_coords(drop=True)
        values = values * scale["sd"] + scale["centre"]
    return values.to_dataset(ITEM).merge(others)
