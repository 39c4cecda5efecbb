"""One vehicle that struck nothing: what is read, what is refused, and which models are left."""

import pytest

from retrodict.scene import parse_scene
from retrodict.scene.errors import SceneError
from retrodict.scene.write import scene_toml
from retrodict.studies.ladder import allowed

SKID = """
schema = 1
title = "Skid to a stop"
alone = true
[vehicles.A]
mass = "1500 ± 30 kg"
impact = { heading = "0 deg" }
approach = { skid = "30 ± 0.5 m", speed = "0 mph" }
[surfaces.road]
friction = "0.72 ± 0.05"
"""


def test_a_straight_slide_answers_for_the_travelling_speed():
    scene = parse_scene(SKID, "skid")
    assert scene.alone
    assert allowed(scene) == ["alone+slide"]
    assert "travelling_speed_a" in scene.reported()
    assert "speed_a" not in scene.reported()
    assert scene.question == ("speed_a",)


def test_a_vehicle_whose_wheels_are_placed_may_yaw_on_its_way_to_rest():
    text = SKID.replace('mass = "1500 ± 30 kg"', 'class = "compact car"').replace(
        'approach = { skid = "30 ± 0.5 m", speed = "0 mph" }',
        'rest = { position = ["20 m", "3 m"], heading = "80 deg" }',
    )
    assert allowed(parse_scene(text, "spin"))[:2] == ["alone+slide", "alone+spin"]


def test_a_text_made_of_it_reads_as_the_same_scene():
    scene = parse_scene(SKID, "skid")
    again = parse_scene(scene_toml(scene), "skid")
    assert again.alone
    assert again.approach["a"].skid.value == pytest.approx(30)


def test_a_speed_of_0_needs_no_uncertainty():
    speed = parse_scene(SKID, "skid").approach["a"].speed
    assert speed.value == 0
    assert speed.sd == pytest.approx(0.2)
    assert speed.assumed == "sd"
    with pytest.raises(SceneError, match="needs an uncertainty"):
        parse_scene(SKID.replace("0 mph", "5 mph"), "skid")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[surfaces", "[barrier]\nkind = \"wall\"\n[surfaces", "a barrier, or nothing"),
        ("[surfaces", "[impact]\npoint = [\"0 m\", \"0 m\"]\n[surfaces", "impact = {"),
        ("[surfaces", "[vehicles.B]\nmass = \"1 t\"\n[surfaces", "vehicles.B or alone"),
        ("alone = true\n", "", "vehicles.B: missing"),
        ("alone = true\n", "alone = true\nquestion = [\"e\"]\n", "e has no meaning"),
        (', speed = "0 mph"', "", "nothing is known of the vehicle"),
        ("impact =", 'departure = { speed = "5 ± 1 m/s" }\nimpact =', "there was no impact"),
    ],
)  # fmt: skip
def test_what_it_cannot_have_is_refused(old, new, said):
    assert old in SKID
    with pytest.raises(SceneError) as caught:
        parse_scene(SKID.replace(old, new), "skid")
    assert said in str(caught.value)
