"""The causes of an answer's uncertainty are the measured quantities that explain its variance."""

from dataclasses import replace

import numpy as np
import pytest

from retrodict import findings


def test_causes_are_measured_and_their_share_is_that_of_the_variance(outcome):
    """B's speed = 19.2 + 0.8 z(mass of A) + 0.6 noise: the mass has a share of 0.64."""
    rng = np.random.default_rng(0)
    tree = outcome.idata.copy()
    z, noise = rng.normal(size=(2, *tree["posterior"]["speed_b"].shape))
    posterior = tree["posterior"].to_dataset()
    posterior["mass_a"] = posterior["mass_a"] * 0 + 1857 + 40 * z
    posterior["Omega_a"] = posterior["Omega_a"] * 0 + 0.8 * z + 0.6 * noise  # was not measured
    posterior["speed_b"] = posterior["speed_b"] * 0 + 19.2 + 0.8 * z + 0.6 * noise
    tree["posterior"] = posterior
    found = findings.compute(replace(outcome, idata=tree))
    assert found.narrowing["speed_b"][0].name == "Omega_a"
    first, *others = found.causes["speed_b"]
    assert first.name == "mass_a"
    assert first.share == pytest.approx(0.64, abs=4 * first.error)
    assert first.error == pytest.approx(2 * 0.8 * 0.36 / np.sqrt(2000), rel=0.1)
    assert len(others) == 2
    assert all(other.share < 0.02 for other in others)


def test_a_failed_run_names_no_causes(failing):
    assert findings.compute(failing).causes == {}
