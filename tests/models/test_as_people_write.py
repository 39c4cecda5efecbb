"""Crashes that people published, with no more written than they wrote: the answers by hand are found.

Numbers of textbook and forum questions, as in benchmarks/users; places, contact lines and sizes that
nobody gave are left out.
"""

import cmath
import math

import numpy as np
import pytest

import retrodict as rd
from retrodict.constants import GRAVITY

CLASSROOM = """
schema = 1
title = "Crossing: both speeds from the skids and the four directions"
[vehicles.A]
mass = "4220 ± 40 lb"
impact = { heading = "due west ± 2 deg" }
rest = { distance = "25.9 ft", direction = "N 49.3° W" }
[vehicles.B]
mass = "3875 ± 40 lb"
impact = { heading = "N 3 W ± 2 deg" }
rest = { distance = "14.7 ft", direction = "N 88.2° W" }
[surfaces.road]
friction = "0.83 ± 0.03"
"""
TAXI = """
schema = 1
title = "Taxi into the side of a standing car that it pushes straight on"
[vehicles.A]
mass = "1800 ± 50 kg"
impact = { heading = "0 deg" }
rest = { distance = "2.5 m", direction = "0 deg" }
[vehicles.B]
mass = "1250 ± 30 kg"
impact = { heading = "90 deg" }
approach = { speed = "0 mph" }
rest = { distance = "10.5 m", direction = "0 deg" }
[surfaces.road]
friction = "0.72 ± 0.05"
"""
MOTORCYCLE = """
schema = 1
title = "Car at 70 km/h and a motorcycle head-on, 45 km/h together afterwards"
[vehicles.A]
mass = "1200 ± 20 kg"
impact = { heading = "0 deg" }
approach = { speed = "70 ± 1 km/h" }
departure = { speed = "45 ± 1 km/h" }
[vehicles.B]
mass = "250 ± 5 kg"
slides = "0.5 ± 0.1"
approach = { direction = "180 ± 1 deg" }
[impact]
together = true
"""


def answers(text: str) -> dict[str, np.ndarray]:
    found = rd.reconstruct(rd.parse_scene(text, "written"), method="importance")
    assert found.checks.passed
    return {k: np.ravel(found.idata["posterior"][k]) for k in ("speed_a", "speed_b")}


def slid(distance: float, degrees: float, friction: float) -> complex:
    return cmath.rect(math.sqrt(2 * friction * GRAVITY * distance), math.radians(degrees))


def near(draws: np.ndarray, exact: float) -> None:
    assert np.median(draws) == pytest.approx(exact, abs=0.35 * draws.std())


def test_the_classroom_crossing_is_answered_by_momentum() -> None:
    lb, ft = 0.45359237, 0.3048
    P = 4220 * lb * slid(25.9 * ft, 139.3, 0.83) + 3875 * lb * slid(14.7 * ft, 178.2, 0.83)
    courses = [cmath.rect(1, math.radians(d)) for d in (180, 93)]
    of = [[4220 * lb * courses[0].real, 3875 * lb * courses[1].real],
          [4220 * lb * courses[0].imag, 3875 * lb * courses[1].imag]]  # fmt: skip
    exact = np.linalg.solve(of, [P.real, P.imag])
    found = answers(CLASSROOM)
    near(found["speed_a"], exact[0])
    near(found["speed_b"], exact[1])


def test_a_taxi_that_pushed_a_standing_car_straight_on() -> None:
    exact = (1800 * slid(2.5, 0, 0.72) + 1250 * slid(10.5, 0, 0.72)).real / 1800
    assert exact == pytest.approx(14.4, abs=0.1)
    near(answers(TAXI)["speed_a"], exact)


def test_a_motorcycle_that_a_car_carried_on() -> None:
    exact = (1200 * 70 - 1450 * 45) / 250
    assert exact == pytest.approx(75)
    near(answers(MOTORCYCLE)["speed_b"], exact / 3.6)
