"""The evidence as one variable, and the attributes of the draws."""

import hashlib
import json

import numpy as np
import pytest

from retrodict.findings.stored import draws_of
from retrodict.inference.outcome import attributes_of
from retrodict.inference.pointwise import pointwise
from retrodict.scene.write import scene_text
from tests.report.conftest import make_outcome, without


def test_items_keep_their_draws_and_share_one_scale():
    outcome = make_outcome()
    found, evidence = pointwise(outcome.idata), outcome.scene.evidence()
    assert list(found["observed_data"]["item"].values) == list(evidence)
    predicted = found["posterior_predictive"]["evidence"]
    np.testing.assert_allclose(predicted.mean(("chain", "draw")), 0, atol=1e-12)
    for name, measured in evidence.items():
        at = {"item": name}
        np.testing.assert_array_equal(
            found["log_likelihood"]["evidence"].sel(at), outcome.idata["log_likelihood"][name]
        )
        # measured less predicted, in standard deviations
        off = measured.value - outcome.idata["posterior_predictive"][name]
        np.testing.assert_allclose(
            found["observed_data"]["evidence"].sel(at) - predicted.sel(at), off / measured.sd
        )


def test_without_draws_there_is_no_pointwise_evidence():
    with pytest.raises(ValueError, match="without draws"):
        pointwise(without(make_outcome(), "posterior").idata)


def test_attributes_say_what_the_draws_are_of_and_survive_netcdf():
    outcome = make_outcome()
    outcome.idata.attrs.update(attributes_of(outcome))
    again = draws_of(bytes(outcome.idata.to_netcdf())).attrs
    assert again == attributes_of(outcome)
    assert again["created_by"] == "retrodict 0.1.0"
    assert (again["model"], again["seed"], again["complete"]) == ("planar-moment+wheels", 20, 1)
    assert json.loads(again["versions"]) == outcome.versions
    text = scene_text(outcome.scene).text
    assert again["scene_sha256"] == hashlib.sha256(text.encode()).hexdigest()
