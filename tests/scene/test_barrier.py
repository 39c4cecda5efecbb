"""A barrier in the place of vehicle B: what a scene file may say of it, and what may be asked."""

from __future__ import annotations

from dataclasses import replace

import pytest

from retrodict.scene import SceneError, parse_scene
from retrodict.scene.plausibility import plausibility_warnings
from retrodict.scene.records import Barrier
from retrodict.scene.write import scene_toml

WALL = """\
schema = 1
title = "A car into a wall"

[barrier]
kind = "wall"
name = "concrete wall"

[vehicles.A]
mass = "1500 ± 30 kg"
wheelbase = "2.7 m"
track = "1.5 m"
impact_centre = { distance = "2.1 ± 0.1 m", angle = "20 ± 3 deg" }
impact.heading = "25 ± 2 deg"
rest = { position = ["6.6 ± 0.15 m", "-1.9 ± 0.15 m"], heading = "8 ± 3 deg" }

[impact]
point = ["0 ± 0.1 m", "0 ± 0.05 m"]
contact_line = "90 ± 1 deg"

[surfaces.road]
friction = "0.7 ± 0.05"
"""
POLE = WALL.replace('kind = "wall"', 'kind = "pole"\ndiameter = "0.3 m"')
ANOTHER = WALL[WALL.index("[vehicles.A]") : WALL.index("[impact]")].replace("s.A", "s.B")


def test_a_barrier_leaves_one_vehicle_and_asks_for_its_speed() -> None:
    scene = parse_scene(WALL, "wall")
    assert scene.barrier == Barrier("wall", "concrete wall")
    assert list(scene.vehicles) == list(scene.approach) == ["a"]
    assert scene.question == scene.reported() == ("speed_a", "e", "e_m", "mu")
    assert not [name for name in scene.inputs() | scene.evidence() if name.endswith("_b")]
    assert not plausibility_warnings(scene)


def test_a_speed_that_was_measured_is_not_asked() -> None:
    known = WALL.replace("impact.heading", 'approach.speed = "20 ± 1 m/s"\nimpact.heading')
    assert parse_scene(known, "wall").question == ("e", "e_m", "mu")


def test_a_pole_has_a_diameter() -> None:
    assert parse_scene(POLE, "pole").barrier == Barrier("pole", "concrete wall", 0.3)


@pytest.mark.parametrize("text", [WALL, POLE])
def test_a_scene_made_from_its_values_says_the_same(text: str) -> None:
    scene = parse_scene(text, "wall")
    again = parse_scene(scene_toml(scene), "wall")
    assert again.barrier == scene.barrier
    assert again.inputs().keys() == scene.inputs().keys()
    assert again.question == scene.question


ASKED = 'reaction = "1 s", deceleration = "7 m/s^2", seen_time = "2 s"'


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[impact]", f"{ANOTHER}[impact]", "vehicles.B: A struck a vehicle or a barrier; leave out"),
        ('kind = "wall"', 'kind = "pole"', 'barrier.diameter: missing; write diameter = "0.3 m"'),
        ('kind = "wall"', 'kind = "wall"\ndiameter = "1 m"', "barrier.diameter: a wall has none"),
        ('kind = "wall"', 'kind = "fence"', 'barrier.kind: not what is expected here; write kind ='),
        ("[barrier]", 'question = ["speed_b"]\n[barrier]', 'question: a scene with a barrier'),
        ("[impact]", '[priors.speed_b]\nscale = "9 m/s"\nsource = "s"\n[impact]', "priors.speed_b: a"),
        ("[impact]", '[questions]\nexceeds = "Vbx > 9 m/s"\n[impact]', "questions.exceeds: a scene"),
        (
            "[impact]",
            '[questions]\nbetween = "1 m/s < delta_v_b < 9 m/s"\n[impact]',
            "questions.between: a scene with a barrier has no vehicle B",
        ),
        ("[impact]", "[questions]\ncorners = true\n[impact]", "questions.corners: the corner range"),
        (
            "[impact]",
            f'[questions]\navoidable = [{{ vehicle = "B", limit = "9 m/s", {ASKED} }}]\n[impact]',
            'questions.avoidable: a scene with a barrier has no vehicle B',
        ),
        (
            "[impact]",
            '[questions]\navoidable = [{ vehicle = "A", limit = "9 m/s", clear = "3 m", '
            f"{ASKED} }}]\n[impact]",
            "questions.avoidable: nothing clears the way; leave clear out",
        ),
    ],
)  # fmt: skip
def test_what_a_barrier_has_not_is_refused_with_the_fix(old: str, new: str, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_scene(WALL.replace(old, new, 1), "wall")
    key, fix = said.split(": ", 1)
    (line,) = str(caught.value).splitlines()
    assert line.startswith(f"wall: {key}")
    assert f": {fix}" in line


def test_without_a_vehicle_b_a_barrier_is_offered() -> None:
    with pytest.raises(
        SceneError, match=r"vehicles\.B: missing; write B = .* A struck: \[barrier\]"
    ):
        parse_scene(WALL.replace('[barrier]\nkind = "wall"\nname = "concrete wall"\n', ""), "wall")


def test_a_rest_beyond_the_wall_is_warned_of_and_beyond_a_pole_is_not() -> None:
    beyond = ('"-1.9 ± 0.15 m"', '"1.9 ± 0.15 m"')
    (said,) = plausibility_warnings(parse_scene(WALL.replace(*beyond), "wall"))
    assert said.startswith("vehicles.A.rest.position: 1.9 m beyond the face of the wall")
    assert not plausibility_warnings(parse_scene(POLE.replace(*beyond), "pole"))


def test_a_contact_line_along_the_lever_is_warned_of() -> None:
    scene = parse_scene(WALL, "wall")
    along = replace(scene.contact.Gamma, value=scene.contact.Gamma.value + 0.8)
    (said,) = plausibility_warnings(replace(scene, contact=replace(scene.contact, Gamma=along)))
    assert said.startswith("impact.contact_line: it hardly parts the vehicle from the wall")
