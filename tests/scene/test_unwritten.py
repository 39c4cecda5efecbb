"""What only some models need may be left out: what stands in for it, what is asked, what is said."""

import math

import pytest
from retrodict.models import RUNGS

from retrodict.scene import parse_scene
from retrodict.scene.errors import SceneError
from retrodict.scene.plausibility import plausibility_warnings
from retrodict.scene.write import scene_toml
from retrodict.studies.ladder import allowed, refusals

CROSSING = """
schema = 1
title = "Crossing"
[vehicles.A]
mass = "1900 ± 20 kg"
impact = { heading = "180 ± 2 deg" }
rest = { distance = "8 ± 0.3 m", direction = "139 ± 3 deg" }
[vehicles.B]
mass = "1750 ± 20 kg"
impact = { heading = "90 ± 2 deg" }
rest = { distance = "4.5 ± 0.3 m" }
[surfaces.road]
friction = "0.83 ± 0.03"
"""


def test_momentum_and_straight_slides_are_left():
    scene = parse_scene(CROSSING, "crossing")
    assert allowed(scene) == ["momentum+slide"]
    assert set(scene.question) == {"speed_a", "speed_b"}
    assert "needs vehicles.A.impact_centre" in RUNGS["planar+wheels"].refusal(scene)
    assert "vehicles.A.wheelbase" in RUNGS["momentum+wheels"].refusal(scene)
    assert set(scene.evidence()) == {
        "run_out_distance_a",
        "run_out_direction_a",
        "run_out_distance_b",
    }


def test_what_only_stands_in_is_no_input_that_is_stated():
    scene = parse_scene(CROSSING, "crossing")
    for name in ("Gamma", "track_a", "front_axle_b", "yaw_inertia_a", "impact_x"):
        assert scene.inputs()[name].sd == 0
        assert name not in scene.stated()


def test_the_vehicles_meet_on_the_sides_that_they_came_from():
    """A goes west and B north, so that A has B on its left, and B has A on its right."""
    scene = parse_scene(CROSSING, "crossing")
    a, b = (scene.vehicles[v].impact_angle.value for v in "ab")
    assert a == pytest.approx(math.pi / 4)
    assert b == pytest.approx(-math.pi / 4)


def test_one_warning_says_what_the_other_models_need():
    (line,) = plausibility_warnings(parse_scene(CROSSING, "crossing"))
    for key in ("vehicles.A.impact_centre", "vehicles.B.impact_centre", "impact.contact_line"):
        assert key in line


def test_a_text_made_of_it_reads_as_the_same_scene():
    scene = parse_scene(CROSSING, "crossing")
    again = parse_scene(scene_toml(scene), "crossing")
    assert again.unwritten == scene.unwritten
    assert again.from_impact["a"]["distance"].value == scene.from_impact["a"]["distance"].value
    assert again.inputs().keys() == scene.inputs().keys()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('heading = "90', 'heading = "178', "impact_centre: missing"),  # who was in front
        ('title = "Crossing"', 'title = "x"\nquestion = ["e"]', "without which e has no meaning"),
        ('distance = "4.5 ± 0.3 m"', 'position = ["1 m", "2 m"]', "impact.point: missing"),
        ('mass = "1750 ± 20 kg"', 'mass = "1750 kg"\ncg_height = "0.5 m"', "wheelbase: missing"),
        ('mass = "1750 ± 20 kg"', 'mass = "1750 kg"\ncg_to_front_axle = "1.3 m"', "rear_axle: missing"),
        ('distance = "4.5 ± 0.3 m"', 'direction = "4 deg"', "rest.position: missing"),
        (
            'distance = "4.5 ± 0.3 m"',
            'distance = "4 m", position = ["1 m", "2 m"]',
            "the same twice",
        ),
        ('distance = "4.5 ± 0.3 m"', 'distance = "4 m", heading = "3 deg"', "needs a position"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_without_is_asked_for(old, new, said):
    assert old in CROSSING
    with pytest.raises(SceneError, match="crossing: ") as caught:
        parse_scene(CROSSING.replace(old, new), "crossing")
    assert said in str(caught.value)


def test_vehicles_that_go_on_together_leave_no_coefficient():
    text = CROSSING + "[impact]\ntogether = true\n"
    scene = parse_scene(text, "taxi")
    assert scene.contact.together
    assert allowed(scene) == ["joined+slide"]
    assert "momentum+slide" not in refusals(scene, scene.question)
    assert parse_scene(scene_toml(scene), "taxi").contact.together
    with pytest.raises(SceneError, match="no mu to ask for"):
        parse_scene(text.replace('title = "Crossing"', 'title = "x"\nquestion = ["mu"]'), "taxi")
