"""Crashes that people published, with no more written than they wrote: the answers by hand are found.

Numbers of textbook and forum questions, as in benchmarks/users, whose files say where each is from;
places, contact lines and sizes that nobody gave are left out. Other things that such questions have are
tested elsewhere: numbers that gain energy (tests/scene/test_plausibility.py), bearings, feet, inches
and ranges (tests/scene/test_units.py), a free articulation (tests/scene/test_vehicle_library.py),
degrees of latitude (tests/interchange/test_places.py).
"""

import cmath
import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import retrodict as rd
from retrodict.constants import GRAVITY

USERS = Path(__file__).parents[2] / "benchmarks" / "users"
TRUTHS = tomllib.loads((USERS / "scenes.toml").read_text("utf-8"))

# scenes of benchmarks/users by the right answer, m/s, that is computed by hand here
PUBLISHED = {
    # common speed 12.6 m/s, of which 6 are A's along x
    "together-unknown-way": ("speed_b", 2 * math.sqrt(12.6**2 - 6**2)),
    "together-perhaps": ("speed_b", 2 * math.sqrt(12.6**2 - 6**2)),
    "skid-alone": ("travelling_speed_a", math.sqrt(2 * GRAVITY * 0.72 * 30)),
    # 103 ft/s
    "skid-two-surfaces": (
        "travelling_speed_a", math.sqrt(2 * GRAVITY * (0.55 * 88 + 0.80 * 146) * 0.3048)
    ),
    # S = 3.86 sqrt(r f) in mph and ft, as practice writes it
    "yaw-alone": ("travelling_speed_a", 3.86 * math.sqrt(200.5 * 0.72) * 0.44704),
    "pedestrian": (
        "speed_a",
        math.sqrt(2 * GRAVITY * 0.7 * 20) + 75 / 1300 * math.sqrt(2 * GRAVITY * 0.6 * 22),
    ),
}  # fmt: skip
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


def answers(scene: str | rd.Scene) -> dict[str, np.ndarray]:
    read = rd.parse_scene(scene, "written") if isinstance(scene, str) else scene
    found = rd.reconstruct(read, method="importance")
    assert found.checks.passed
    posterior = found.idata["posterior"]
    wanted = ("speed_a", "speed_b", "travelling_speed_a", "e")
    return {k: np.ravel(posterior[k]) for k in wanted if k in posterior}


def slid(distance: float, degrees: float, friction: float) -> complex:
    return cmath.rect(math.sqrt(2 * friction * GRAVITY * distance), math.radians(degrees))


def near(draws: np.ndarray, exact: float) -> None:
    assert np.median(draws) == pytest.approx(exact, abs=0.35 * draws.std())


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_taxi_that_pushed_a_standing_car_straight_on() -> None:
    exact = (1800 * slid(2.5, 0, 0.72) + 1250 * slid(10.5, 0, 0.72)).real / 1800
    assert exact == pytest.approx(14.4, abs=0.1)
    near(answers(TAXI)["speed_a"], exact)


def test_a_motorcycle_that_a_car_carried_on() -> None:
    exact = (1200 * 70 - 1450 * 45) / 250
    assert exact == pytest.approx(75)
    near(answers(MOTORCYCLE)["speed_b"], exact / 3.6)


def written(name: str) -> Path:
    """Path of a scene of benchmarks/users."""
    return USERS / "scenes" / f"{name}.toml"


QUICK = ("skid-alone",)  # the others: -m slow


@pytest.mark.parametrize(
    "name",
    [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in PUBLISHED],
)
def test_questions_are_answered_as_by_hand(name: str) -> None:
    quantity, exact = PUBLISHED[name]
    assert TRUTHS[name]["truth"][quantity]["mean"] == pytest.approx(exact, rel=0.005)
    near(answers(rd.load_scene(written(name)))[quantity], exact)


STOPPED = 'departure = { speed = "0 mph" }'


@pytest.mark.slow
@pytest.mark.parametrize("after", ["{rest}", STOPPED, "{rest}\n" + STOPPED])
def test_a_head_on_in_which_both_stop_where_they_met(after: str) -> None:
    """Written as rest poses at the impact, as speeds of 0 after it, or as both."""
    exact = 2 * 20 * 0.3048
    assert exact == pytest.approx(12.19, abs=0.01)
    text = written("dead-stop").read_text("utf-8")
    text = re.sub(r"^rest = .*$", lambda rest: after.replace("{rest}", rest[0]), text, flags=re.M)
    near(answers(text)["speed_b"], exact)


@pytest.mark.slow
def test_a_restitution_that_the_problem_gives() -> None:
    """e = 0.6: 62.6 and 10.9 km/h before the impact, by momentum and e along the line of centres."""
    text = written("restitution-given").read_text("utf-8")
    text = text.replace("[impact]\n", "[impact]\ne = 0.6\n")
    central = text.replace('line = "0 ± 2 deg', 'line = "0 ± 0.1 deg')
    central = central.replace('heading = "0 deg', 'heading = "0 ± 0.1 deg')
    central = re.sub(r'angle = "(\d+) deg', r'angle = "\1 ± 0.1 deg', central)
    exact = {"speed_a": 62.58 / 3.6, "speed_b": 10.91 / 3.6}
    # Where the line of the impact may miss the centres of gravity, turning takes a part of the parting
    # speed. Medians of 200 000 draws of a t distribution weighted by `rd.log_density`, each ± 0.001 m/s.
    eccentric = {"speed_a": 17.483, "speed_b": 2.908}
    for scene, right in ((central, exact), (text, eccentric)):
        found = answers(scene)
        for name, value in right.items():
            # four Monte Carlo errors of the median of 3000 draws
            error = 1.25 * found[name].std() / math.sqrt(3000)
            assert np.median(found[name]) == pytest.approx(value, abs=4 * error)


@pytest.mark.slow
def test_a_lorry_struck_at_its_trailer_is_answered_with_the_articulation_locked() -> None:
    scene = rd.load_scene(written("lorry-locked"))
    found = rd.reconstruct(scene, method="importance")
    assert found.checks.passed
    assert "one rigid body" in " ".join(found.findings.assumptions)
