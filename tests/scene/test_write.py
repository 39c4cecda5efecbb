"""A scene file made from a scene reads as that scene; its own text stays while it holds."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from retrodict.scene import load_scene, parse_scene
from retrodict.scene.records import Measured
from retrodict.scene.write import scene_text, scene_toml
from tests.shared.scene_file import OIL, SCENE
from tests.shared.scenes import collision

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/scene.toml"))


def numbers(scene):
    return {
        name: (m.law, *(pytest.approx(x, rel=1e-9, abs=1e-9) for x in (m.value, m.sd)))
        for name, m in (scene.inputs() | scene.evidence()).items()
    }


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_a_scene_file_made_from_a_scene_reads_the_same(path):
    scene = load_scene(path)
    again = parse_scene(scene_toml(scene), scene.name)
    read = {n: (m.law, m.value, m.sd) for n, m in (again.inputs() | again.evidence()).items()}
    assert read == numbers(scene)
    for name in ("title", "notes", "question", "robust"):
        assert getattr(again, name) == getattr(scene, name)
    assert [p.numbers for p in again.priors.values()] == [p.numbers for p in scene.priors.values()]
    assert again.contact.interlocked == scene.contact.interlocked
    assert {v: r.turns_known for v, r in again.rest.items()} == {
        v: r.turns_known for v, r in scene.rest.items()
    }


def test_edges_and_outlines_are_written_as_they_are():
    corners = OIL[OIL.index("[[") : OIL.index("]]") + 2]
    many = [[f"{40 * math.cos(i / 16)} m", f"{40 * math.sin(i / 16)} m"] for i in range(100)]
    scene = parse_scene(
        SCENE + OIL.replace(corners, json.dumps(many).replace("], [", "],\n [")), "x"
    )
    assert len(scene.surfaces[2].outline.corners) == 100
    again = parse_scene(scene_toml(scene), "x")
    assert [(s.edge, s.outline) for s in again.surfaces] == [
        (s.edge, s.outline) for s in scene.surfaces
    ]
    changed = scene.change({"title": "Another"})
    assert parse_scene(changed.to_toml(), "x").surfaces == scene.surfaces


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_a_scene_keeps_the_text_that_says_it(path):
    scene = load_scene(path)
    found = scene_text(scene)
    assert found.as_written
    assert found.text == path.read_text("utf-8")


def test_a_changed_scene_does_not_keep_its_text():
    scene = load_scene(EXAMPLES[0].parents[1] / "brach-1977" / "scene.toml")
    a = replace(scene.approach["a"], speed=Measured(22.352, 0.9, source="changed"))
    changed = replace(scene, approach=scene.approach | {"a": a})
    found = scene_text(changed)
    assert not found.as_written
    again = parse_scene(found.text, "again")
    assert again.approach["a"].speed.value == 22.352
    assert "45" not in found.text.split("approach.speed")[1].split("\n")[0]
    for other in (replace(scene, title="Another"), replace(scene, robust=True)):
        assert not scene_text(other).as_written


def test_whole_turns_that_a_reconstruction_found_are_no_change():
    text = EXAMPLES[0].parents[1].joinpath("brach-1977", "scene.toml").read_text("utf-8")
    scene = parse_scene(text.replace('rotation = "743 deg"\n', ""), "free")
    b = scene.rest["b"]
    turned = replace(b, heading=replace(b.heading, value=b.heading.value + 4 * 3.141592653589793))
    assert scene_text(replace(scene, rest=scene.rest | {"b": turned})).as_written
    off = replace(b, heading=replace(b.heading, value=b.heading.value + 0.1))
    assert not scene_text(replace(scene, rest=scene.rest | {"b": off})).as_written


def test_what_a_scene_file_cannot_say_is_named_at_its_head():
    """An exact mass would be read with the default uncertainty."""
    head = scene_toml(collision(share=0)).split("\n")[0]
    assert head.startswith("# A scene file cannot say: ")
    assert "mass_a as it is" in head
    assert not scene_toml(load_scene(EXAMPLES[0])).startswith("# A scene file cannot")


def test_hostile_texts_are_written_as_text():
    evil = 'a"\n[vehicles.A]\nmass = "1 kg" \\ \x7f \x1b[2J'
    scene = load_scene(EXAMPLES[0])
    a = replace(scene.vehicles["a"], name=evil)
    text = scene_toml(
        replace(scene, title=evil, notes=(evil,), vehicles={**scene.vehicles, "a": a})
    )
    assert "\x1b" not in text
    assert text.count("\n[vehicles.A]\n") == 1
    assert all(line.startswith("#") for line in text.split("schema = 1")[0].strip().split("\n"))
