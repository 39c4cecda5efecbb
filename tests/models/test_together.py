"""Vehicles that go on together: the posterior is that of the closed form, and keeps its promise."""

import numpy as np
import pytest

import retrodict as rd
from retrodict.constants import GRAVITY

# a taxi into the side of a car: both slide on 9 m in a direction that nobody wrote down
TAXI = """
schema = 1
title = "Taxi"
[vehicles.A]
mass = "1800 ± 50 kg"
impact = { heading = "0 ± 2 deg" }
[vehicles.B]
mass = "1250 ± 30 kg"
impact = { heading = "90 ± 2 deg" }
approach = { speed = "3 ± 0.5 m/s" }
rest = { distance = "9 ± 0.5 m" }
[impact]
together = true
[surfaces.road]
friction = "0.72 ± 0.04"
"""


@pytest.fixture(scope="module")
def taxi():
    return rd.reconstruct(rd.parse_scene(TAXI, "taxi"), method="importance")


def closed_form(count=400_000):
    """A's speed by momentum of the two together: V² = 2 mu g d, and B's part at right angles."""
    rng = np.random.default_rng(1)
    mass_a, mass_b, friction = (
        mean * np.exp(sd / mean * rng.standard_normal(count) - (sd / mean) ** 2 / 2)
        for mean, sd in ((1800, 50), (1250, 30), (0.72, 0.04))
    )
    speed_b, distance = rng.normal(3, 0.5, count), rng.normal(9, 0.5, count)
    # each vehicle's course is its heading, whose error it shares, and 3 deg besides
    off_a, off_b = (np.radians(np.hypot(2, 3)) * rng.standard_normal(count) for _ in "ab")
    course = np.radians(90) + off_b - off_a
    total = (mass_a + mass_b) * np.sqrt(2 * friction * GRAVITY * distance)
    p_b = mass_b * speed_b
    along, across = p_b * np.cos(course), p_b * np.sin(course)
    return (np.sqrt(total**2 - across**2) - along) / mass_a


@pytest.mark.slow
def test_the_speed_is_that_of_the_closed_form(taxi):
    speed, exact = np.ravel(taxi.idata["posterior"]["speed_a"]), closed_form()
    assert taxi.checks.passed
    assert speed.mean() == pytest.approx(exact.mean(), abs=0.15 * exact.std())
    assert speed.std() == pytest.approx(exact.std(), rel=0.1)


@pytest.mark.slow
def test_the_model_is_the_simplest_that_there_is(taxi):
    assert "joined+slide" in repr(taxi)


def test_a_yaw_rate_that_it_does_not_use_is_not_reported(taxi):
    assert "omega_b" not in taxi.idata["posterior"]
