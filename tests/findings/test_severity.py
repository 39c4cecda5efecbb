"""PDOF: the direction that the force came from, clockwise from straight ahead."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr

from retrodict.findings import compute
from retrodict.findings.severity import hours, pdof
from retrodict.mechanics import Bodies, Coefficients
from retrodict.mechanics.severity import clock, severity
from retrodict.scene.records import Measured
from tests.findings.test_summary import with_posterior

DEGREE = np.pi / 180


def draws(**variables):
    return xr.Dataset({k: (("chain", "draw"), np.atleast_2d(v)) for k, v in variables.items()})


def test_pdof_is_that_of_the_impact_equations(outcome):
    rng = np.random.default_rng(3)
    bodies = Bodies(1857, 1778, 3374, 3007, 1.636, 0.653, 0.205, 2.079, -0.155)
    before = jnp.array([-20.1, 0.0, 0.0, 18.9, -3.6, -0.3])
    for heading_a, heading_b in rng.uniform(-7, 7, (20, 2)):
        headings = jnp.array([heading_a, heading_b])
        found = severity(before, bodies, Coefficients(0.1, 0.35, 0.7), headings)
        _, _, _, Vbx, Vby, _ = found.after
        posterior = draws(vbx=18.9, vby=-3.6, Vbx=Vbx, Vby=Vby, heading_a=heading_a)
        vehicles = outcome.scene.vehicles
        b = replace(vehicles["b"], heading=Measured(heading_b))
        ours = pdof(posterior, replace(outcome.scene, vehicles=vehicles | {"b": b}))
        for i, v in enumerate("ab"):
            assert np.exp(1j * ours[f"pdof_{v}"].item()) == pytest.approx(
                np.exp(1j * float(found.pdof[i]))
            )
            assert list(hours(ours[f"pdof_{v}"].values)) == [int(clock(found.pdof[i]))]


@pytest.mark.parametrize(
    ("delta_v", "degrees"), [((-9, 0), 0), ((0, 9), 90), ((0, -9), -90), ((9, 0.01), 180)]
)
def test_a_force_from_the_right_counts_positive(outcome, delta_v, degrees):
    posterior = draws(vbx=1.0, vby=2.0, Vbx=1.0 + delta_v[0], Vby=2.0 + delta_v[1], heading_b=0.0)
    found = pdof(posterior, outcome.scene)["pdof_b"].item()
    assert found == pytest.approx(degrees * DEGREE, abs=0.01)


def test_directions_about_the_rear_are_not_torn_apart(outcome):
    angles = np.random.default_rng(0).normal(180, 10, (4, 500)) * DEGREE
    # struck from behind, B gains speed along its heading
    moved = {"Vbx": 9 * np.cos(np.pi - angles), "Vby": 9 * np.sin(np.pi - angles)}
    still = {name: np.zeros((4, 500)) for name in ("vbx", "vby", "heading_b")}
    found = compute(with_posterior(outcome, **moved, **still)).derived["pdof_b"]
    assert found.sd == pytest.approx(10 * DEGREE, rel=0.1)
    assert abs(found.mean) == pytest.approx(np.pi, abs=0.02)


def test_hours_share_the_draws_out():
    shares = hours(np.array([[-16, -14, 14, 0], [16, 91, np.nan, 359]]) * DEGREE)
    assert shares == {12: 4 / 7, 1: 1 / 7, 3: 1 / 7, 11: 1 / 7}
    assert next(iter(shares)) == 12


def test_a_model_without_velocities_of_b_has_no_direction(outcome):
    found = compute(with_posterior(outcome, vbx=None))
    assert not found.hours
    assert "pdof_a" not in found.derived
