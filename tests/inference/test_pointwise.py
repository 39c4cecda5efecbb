"""The evidence as one variable, and the attributes of the draws."""

import hashlib
import json

import numpy as np
import pytest
import xarray as xr

from retrodict.findings.stored import draws_of
from retrodict.inference.outcome import attributes_of
from retrodict.inference.pointwise import by_item, pointwise
from retrodict.scene.write import scene_text
from tests.report.conftest import make_outcome


def by_name(idata: xr.DataTree) -> xr.DataTree:
    """The tree as earlier versions kept it: a variable for each item of evidence, in SI units."""
    groups = {f"/{name}": by_item(idata, name) for name in idata.children}
    sd = idata["constant_data"]["sd"].reset_coords(drop=True).to_dataset("item")
    groups["/constant_data"] = sd.rename({name: f"{name}_sd" for name in sd})
    return xr.DataTree.from_dict(groups)


def test_items_keep_their_draws_and_share_one_scale():
    outcome = make_outcome()
    old, evidence = by_name(outcome.idata), outcome.scene.evidence()
    found = pointwise(old)
    assert list(found["observed_data"]["item"].values) == list(evidence)
    predicted = found["posterior_predictive"]["evidence"]
    np.testing.assert_allclose(predicted.mean(("chain", "draw")), 0, atol=1e-12)
    for name, measured in evidence.items():
        at = {"item": name}
        np.testing.assert_array_equal(
            found["log_likelihood"]["evidence"].sel(at), old["log_likelihood"][name]
        )
        # measured less predicted, in standard deviations
        off = measured.value - old["posterior_predictive"][name]
        np.testing.assert_allclose(
            found["observed_data"]["evidence"].sel(at) - predicted.sel(at), off / measured.sd
        )
        assert by_item(found, "observed_data")[name] == pytest.approx(measured.value)


@pytest.mark.parametrize("group", ["posterior_predictive", "prior_predictive", "observed_data"])
def test_by_item_gives_back_what_was_stacked(group):
    old = by_name(make_outcome().idata)
    xr.testing.assert_allclose(by_item(pointwise(old), group), by_item(old, group))


def test_what_is_stacked_or_has_no_predictions_stays():
    tree = make_outcome().idata
    assert pointwise(tree) is tree
    bare = by_name(tree)
    del bare["posterior_predictive"]
    assert pointwise(bare) is bare
    assert not by_item(bare, "posterior_predictive").data_vars


def test_units_of_items_are_said():
    constant = make_outcome().idata["constant_data"].to_dataset()
    assert constant["unit"].sel(item=["rest_x_b", "rest_heading_b"]).values.tolist() == ["m", "rad"]


def test_draws_that_an_earlier_version_stored_are_read():
    tree = make_outcome().idata
    again = draws_of(bytes(by_name(tree).to_netcdf()))
    assert list(again["log_likelihood"].data_vars) == ["evidence"]
    xr.testing.assert_allclose(
        by_item(again, "posterior_predictive"), by_item(tree, "posterior_predictive")
    )


def test_attributes_say_what_the_draws_are_of_and_survive_netcdf():
    outcome = make_outcome()
    outcome.idata.attrs.update(attributes_of(outcome))
    again = draws_of(bytes(outcome.idata.to_netcdf())).attrs
    assert again == attributes_of(outcome)
    assert (again["creation_library"], again["creation_library_version"]) == ("retrodict", "0.1.0")
    assert (again["model"], again["seed"], again["complete"]) == ("planar-moment+wheels", 20, 1)
    assert json.loads(again["versions"]) == outcome.versions
    text = scene_text(outcome.scene).text
    assert again["scene_sha256"] == hashlib.sha256(text.encode()).hexdigest()
