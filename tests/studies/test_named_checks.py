"""The named checks against the mechanics that they name."""

import math
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import Bodies, Coefficients, lever_arms, separation, severity
from retrodict.scene.measured import Measured
from retrodict.studies.conflict import LeftOut
from retrodict.studies.named_checks import named_checks
from tests.studies.gaussian import exact, outcome

HEADING, ANGLE, LEVER = {"a": math.pi, "b": -0.4}, {"a": 0.1, "b": 1.57}, {"a": 2.09, "b": 1.76}
GAMMA = -0.155
E, MU, E_M = 0.1, 0.2, 0.8


@pytest.fixture(scope="module")
def crash():
    """One impact, of which each draw is a copy, and what the mechanics say of it."""
    levers = [
        LEVER[v] * jnp.array([math.cos(HEADING[v] + ANGLE[v]), math.sin(HEADING[v] + ANGLE[v])])
        for v in "ab"
    ]
    bodies = Bodies(1857.0, 1778.0, 3374.0, 3007.0, *lever_arms(*levers), GAMMA)
    before = jnp.array([-20.0, 0.0, 0.0, 18.0, -4.0, 0.3])
    coefficients = Coefficients(E, MU, E_M)
    after = separation(before, bodies, coefficients)
    expected = severity(before, bodies, coefficients, jnp.array([HEADING["a"], HEADING["b"]]))
    names = ("Vax", "Vay", "Omega_a", "Vbx", "Vby", "Omega_b")
    draws = dict(zip(names, map(float, after), strict=True)) | {
        "speed_a": 20.0,
        "direction_a": math.pi,
        "delta_v_a": float(expected.delta_v_size[0]),
        "delta_v_b": float(expected.delta_v_size[1]),
        "energy_lost": float(expected.energy.before - expected.energy.after),
    }
    noise = 1 + 1e-6 * np.random.default_rng(0).standard_normal((4, 50))
    made = outcome(**{name: value * noise for name, value in draws.items()})
    vehicles = {
        v: replace(
            made.scene.vehicles[v],
            heading=exact(HEADING[v]),
            impact_angle=exact(ANGLE[v]),
            impact_distance=exact(LEVER[v]),
            mass=Measured(mass, 20.0, "lognormal"),
        )
        for v, mass in (("a", 1857.0), ("b", 1778.0))
    }
    contact = replace(made.scene.contact, Gamma=exact(GAMMA))
    return replace(made, scene=replace(made.scene, vehicles=vehicles, contact=contact)), expected


def checks(crash, departure=None):
    made, _ = crash
    scene = replace(made.scene, departure=departure or {})
    made.idata["posterior"]["mass_a"] = made.idata["posterior"]["speed_a"] * 0 + 1857.0
    return {(c.name, c.of): c for c in named_checks(replace(made, scene=scene), ())}


def test_contact_points_part_with_e_times_the_closing_speed(crash):
    found = checks(crash)["common velocity", "speed at which the contact points part"]
    assert found.predicted == pytest.approx(E * float(crash[1].closing_normal), rel=1e-4)


def test_pdof_is_that_of_the_mechanics(crash):
    for i, v in enumerate("ab"):
        found = checks(crash)["PDOF", f"force on {v.upper()}"]
        assert math.remainder(found.predicted - float(crash[1].pdof[i]), math.tau) == pytest.approx(
            0, abs=1e-4
        )


def test_energy_is_that_of_the_audit(crash):
    audit = crash[1].energy
    work = float(audit.normal + audit.tangential + audit.moment)
    found = checks(crash)["energy", "kinetic energy lost"]
    assert found.predicted == pytest.approx(-work, rel=1e-4)


def test_a_stated_energy_is_compared_with_what_all_else_says(crash):
    made, severe = crash
    lost = float(severe.energy.before - severe.energy.after)
    stated = LeftOut("impact_energy_lost", 0.7 * lost, 30.0, lost, 50.0, *[0.0] * 8)
    (found,) = (c for c in named_checks(made, (stated,)) if c.name == "energy")
    assert (found.predicted, found.predicted_sd) == pytest.approx((lost, 40.0))  # 50² = 30² + 40²
    assert (found.measured, found.measured_sd) == (0.7 * lost, 30.0)
    assert found.off == pytest.approx(-0.3 * lost / 50)


def test_a_recorded_delta_v_vector_has_the_pdof_of_the_force(crash):
    """Recorded exactly as it was, along the heading and to the left, it differs by nothing."""
    for i, v in enumerate("ab"):
        change, heading = np.asarray(crash[1].delta_v[i]), HEADING[v]
        along = change @ [math.cos(heading), math.sin(heading)]
        left = change @ [-math.sin(heading), math.cos(heading)]
        recorded = {
            "delta_v_forward": Measured(float(along), 0.5),
            "delta_v_left": Measured(float(left), 0.5),
        }
        found = checks(crash, {v: recorded})["PDOF", f"force on {v.upper()}"]
        assert found.off == pytest.approx(0, abs=0.01)
        # at a right angle to it an error of 0.5 m/s turns it by 0.5 over its size
        assert found.measured_sd == pytest.approx(0.5 / np.hypot(*change), rel=1e-6)


def test_measured_impulses_differ_in_standard_deviations_of_both(crash):
    """1857 kg × 12 m/s against 1778 kg × 10 m/s."""
    recorded = {
        "a": {"delta_v": Measured(12.0, 1.0)},
        "b": {"delta_v": Measured(10.0, 0.5)},
    }
    found = checks(crash, recorded)["Newton's third law", "impulse on A less that on B"]
    sd = math.sqrt((1857 * 1.0) ** 2 + (20 * 12) ** 2 + (1778 * 0.5) ** 2 + (20 * 10) ** 2)
    assert found.measured == pytest.approx(1857 * 12 - 1778 * 10)
    assert found.off == pytest.approx(found.measured / sd)
    alone = checks(crash)["Newton's third law", "impulse on either"]
    assert alone.predicted == pytest.approx(1857 * float(crash[1].delta_v_size[0]), rel=1e-4)
    assert alone.predicted == pytest.approx(1778 * float(crash[1].delta_v_size[1]), rel=1e-4)
