"""Skids in several pieces and yaw marks: what is read, written again, and refused."""

import pytest

from retrodict.scene import parse_scene
from retrodict.scene.errors import SceneError
from retrodict.scene.quantities import describe
from retrodict.scene.write import scene_toml
from retrodict.studies.ladder import allowed

PIECES = """
schema = 1
title = "Gravel, then asphalt, then the rear brakes alone"
alone = true
[vehicles.A]
mass = "1500 ± 30 kg"
impact = { heading = "0 deg" }
approach = { speed = "0 mph", skids = [
  { length = "9 ± 0.5 m", surface = "gravel", braking = "0.9 ± 0.05" },
  { length = "12 ± 0.5 m" },
  { length = "6 ± 0.5 m", drag_factor = "0.35 ± 0.05" },
] }
[surfaces.gravel]
friction = "0.5 ± 0.05"
[surfaces.road]
friction = "0.72 ± 0.05"
"""
YAW = """
schema = 1
title = "Critical-speed yaw"
alone = true
[vehicles.A]
mass = "1500 ± 30 kg"
impact = { heading = "0 deg" }
approach = { yaw_mark = { chord = "12 m", middle_ordinate = "0.3 ± 0.01 m", error = "8 %" } }
[surfaces.road]
friction = "0.72 ± 0.05"
"""
SLOPE = '[slope]\ngrade = "3 ± 1 %"\nuphill = "0 deg"\n'


def test_pieces_are_inputs_with_the_friction_of_their_surfaces() -> None:
    scene = parse_scene(PIECES, "skid")
    inputs = scene.inputs()
    assert [inputs[f"skid_{n}_a"].value for n in (1, 2, 3)] == [9, 12, 6]
    assert inputs["skid_1_braking_a"].value == pytest.approx(0.9)
    assert inputs["skid_3_drag_factor_a"].value == pytest.approx(0.35)
    assert inputs["friction_gravel"].value == pytest.approx(0.5)
    assert [piece.surface for piece in scene.approach["a"].skids] == ["gravel", "road", ""]
    assert [surface.name for surface in scene.surfaces] == ["road"]
    assert scene.approach["a"].skid_length == pytest.approx(27)
    assert scene.skidded == ("a",)
    assert allowed(scene) == ["alone+slide"]


def test_a_yaw_mark_is_evidence_with_the_error_of_its_method() -> None:
    scene = parse_scene(YAW, "yaw")
    item = scene.evidence()["yaw_mark_a"]
    assert (item.value, item.sd) == (1.0, pytest.approx(0.08))
    assert scene.inputs()["yaw_ordinate_a"].value == pytest.approx(0.3)
    assert allowed(scene) == ["alone+slide"]


@pytest.mark.parametrize("text", [PIECES, YAW], ids=["pieces", "yaw mark"])
def test_a_text_made_of_it_reads_as_the_same_scene(text: str) -> None:
    scene = parse_scene(text, "skid")
    again = parse_scene(scene_toml(scene), "skid")
    for name in (*scene.inputs(), *scene.evidence()):
        label, _ = describe(name)
        assert label
        assert "{" not in label
    before, after = (each.inputs() | each.evidence() for each in (scene, again))
    assert before.keys() == after.keys()
    assert all(after[k].value == pytest.approx(m.value) for k, m in before.items())
    assert all(after[k].sd == pytest.approx(m.sd) for k, m in before.items())


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (YAW, 'error = "8 %"', 'error = "8 %", surface = "ice"', "no such surface; write one of road"),
        (PIECES, 'drag_factor = "0.35 ± 0.05"', 'drag_factor = "0.35"', "needs an uncertainty"),
        (
            PIECES,
            'drag_factor = "0.35 ± 0.05"',
            'drag_factor = "0.35 ± 0.05", surface = "road"',
            "a drag factor is the whole deceleration",
        ),
        (PIECES, 'speed = "0 mph", ', 'skid = "9 m", ', "the same twice; keep it, or skids"),
        (PIECES, 'speed = "0 mph", ', "", "nothing is known of the vehicle"),
        (PIECES, '[surfaces.gravel]\nfriction = "0.5 ± 0.05"\n', "", "no such surface"),
        (YAW, ', error = "8 %"', "", "no default is given, because published tests do not agree"),
        (YAW, ', error = "8 %"', "", "SAE 2014-01-0467"),
        (YAW, '"0.3 ± 0.01 m"', '"6 ± 0.01 m"', "half the chord"),
        (YAW, '"0.3 ± 0.01 m"', '"0.3 m"', "needs an uncertainty"),
        (YAW, "[surfaces", f"{SLOPE}[surfaces", "critical speed on a slope"),
        (YAW, "mass", 'slides = "0.5 ± 0.1"\nmass', "what slides has no tyres"),
    ],
)  # fmt: skip
def test_what_it_cannot_have_is_refused(text: str, old: str, new: str, said: str) -> None:
    assert old in text
    with pytest.raises(SceneError) as caught:
        parse_scene(text.replace(old, new), "skid")
    assert said in str(caught.value)
