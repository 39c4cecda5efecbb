"""A scene built or changed in Python is the one that a file of the same tables and keys gives."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pint
import pytest

from retrodict.scene import Scene, SceneError, build_scene, load_scene, parse_scene
from retrodict.scene.asked import read_proposition
from retrodict.scene.records import Measured
from retrodict.scene.write import document_toml, scene_text
from tests.shared.scene_file import OIL, SCENE
from tests.shared.scenes import collision

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/scene.toml"))
PAPER = EXAMPLES[0].parents[1] / "brach-1977" / "scene.toml"
UNITS = pint.UnitRegistry()


def untold(scene: Scene) -> Scene:
    """A scene without the text that it has."""
    return replace(scene, text="")


def refusal(scene: Scene, key: str, value: object) -> str:
    with pytest.raises(SceneError) as refused:
        scene.change({key: value})
    return str(refused.value)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_keywords_say_what_a_file_says(path: Path) -> None:
    read = load_scene(path)
    tables = tomllib.loads(path.read_text("utf-8"))
    del tables["schema"]
    built = build_scene(read.name, **tables)
    assert untold(built) == untold(read)
    assert parse_scene(built.to_toml(), built.name) == built


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_what_a_scene_writes_reads_as_that_scene_changed_or_not(path: Path) -> None:
    scene = load_scene(path)
    assert scene.to_toml() == path.read_text("utf-8")
    changes = {"vehicles.A.mass": "1800 ± 20 kg", "title": 'of "A" \\ #', "notes": ["é", "x" * 999]}
    changed = scene.change(changes)
    assert changed.title == 'of "A" \\ #'
    for each in (scene, changed, changed.change({"vehicles.A.mass": "1801 kg"})):
        assert parse_scene(each.to_toml(), each.name) == each
    assert scene_text(scene).as_written
    assert not scene_text(changed).as_written
    assert scene == load_scene(path)  # a change makes another


def test_tables_written_as_toml_read_as_those_tables() -> None:
    for text in (SCENE, SCENE + OIL, *(path.read_text("utf-8") for path in EXAMPLES)):
        document = tomllib.loads(text)
        written = document_toml(document)
        assert tomllib.loads(written) == document
        assert parse_scene(written, "x") == replace(parse_scene(text, "x"), text=written)


@pytest.mark.parametrize(
    ("key", "written", "instead"),
    [
        ("vehicles.A.approach.speed", 'value = 45, sd = 2, unit = "mph"', "value = 50"),
        ("vehicles.A.impact.heading", "value = 180, sd = 2", "value = 175, sd = 2"),
        ("surfaces.road.friction", "value = 0.50, sd = 0.03", "value = 0.47, sd = 0.05"),
        ('surfaces."berm".edge.uncertainty', '"0.1 m"', '"0.3 m"'),
        ("vehicles.b.rest.rotation", '"743 deg"', '"383 deg"'),
        ("impact.point[1]", '"0 ± 0.1 m"]', '"0.5 ± 0.2 m"]'),
    ],
)
def test_a_change_is_that_of_the_file(key: str, written: str, instead: str) -> None:
    text = PAPER.read_text("utf-8")
    table = key.startswith("vehicles.A") or "friction" in key
    if "speed" in key:
        instead += ', sd = 2, unit = "mph"'
    edited = text.replace(written, instead)
    assert edited != text
    value: object = instead.strip('"]')
    if table:  # the sources of the file are in its tables
        whole = next(line for line in edited.split("\n") if instead in line)
        value = tomllib.loads("it = " + whole.partition(" = ")[2])["it"]
    expected = parse_scene(edited, "paper")
    changed = parse_scene(text, "paper").change({key: value})
    assert untold(changed) == untold(expected)


def test_none_removes_a_key_and_a_table_takes_the_place_of_another() -> None:
    scene = parse_scene(SCENE, "bend")
    without = scene.change({"vehicles.A.approach.speed": None, "vehicles.A.rest.rotation": None})
    assert without.approach["a"].speed is None
    assert not without.rest["a"].turns_known
    assert scene.change({"vehicles.A.rest": None}).rest.keys() == {"b"}
    rest = {"position": ["1 ± 0.2 m", "2 ± 0.2 m"]}
    alone = scene.change({"vehicles.A.rest": rest}).rest["a"]
    assert (alone.x.value, alone.y.sd, alone.heading) == (1, 0.2, None)
    assert "not written in the scene" in refusal(scene, "vehicles.B.approach.skid", None)


def test_a_corner_of_an_outline_has_a_key() -> None:
    scene = parse_scene(SCENE + OIL, "bend")
    key = "surfaces.oil.outline.corners[1]"
    for changes in ({key: ["9 m", "-6 m"]}, {f"{key}[0]": "9 m"}):
        outline = scene.change(changes).surfaces[2].outline
        assert outline is not None
        assert outline.corners == ((3, -5), (9, -6), (8, -3))
    said = "surfaces.oil.outline.corners = [[…], […], […]]: corner 2 is corner 1 again"
    assert said in refusal(scene, key, ["3 m", "-5 m"])
    beyond = scene.change(
        {
            "surfaces.oil.outline": None,
            "surfaces.oil.edge": {"point": ["0 m", "-5 m"], "direction": "0 deg", "side": "right"},
        }
    )
    assert [(s.edge is None, s.outline) for s in beyond.surfaces[1:]] == [(False, None)] * 2


def test_a_source_goes_with_the_value_that_it_is_of() -> None:
    scene = load_scene(PAPER)
    speed = "vehicles.A.approach.speed"
    assert scene.approach["a"].speed.source.startswith("reported")
    assert scene.change({speed: "50 ± 2 mph"}).approach["a"].speed.source == ""
    assert scene.change({f"{speed}.value": 50}).approach["a"].speed.source == ""
    both = scene.change({f"{speed}.source": "a film", f"{speed}.value": 50})
    assert both.approach["a"].speed == replace(
        scene.approach["a"].speed, value=50 * 0.44704, source="a film"
    )
    assert both.approach["a"].direction == scene.approach["a"].direction
    # of a prior it is required, so that another number asks for another
    prior = {"priors.speed_b": {"scale": "30 m/s", "source": "a survey"}}
    said = refusal(scene.change(prior), "priors.speed_b.scale", "20 m/s")
    assert said.startswith("brach-1977: priors.speed_b.source: missing; write source = ")


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("vehicles.A.mass", "1800", 'vehicles.A.mass = "1800": no unit; write "1800 kg" (or in lb)'),
        ("vehicles.a.mass", "1 kg", 'vehicles.a.mass = "1 kg": not plausible; write a mass between '),
        ("vehicles.A.approach.speed", "50 mph", "needs an uncertainty (one standard deviation)"),
        ("vehicles.A.motion.speed", "50 ± 2 mph", 'vehicles.A.motion = {speed = "50 ± 2 mph"}: unkn'),
        ("impact.point[0]", "1 kg", 'impact.point[0] = "1 kg": "kg" does not measure a length'),
        ("impact.point[2]", "1 m", "impact.point[2]: not in the scene, which has 2 there; write all"),
        ("vehicles.A.rest.rotation", "200 deg", "the two headings differ by"),
        ("vehicles.A.track.value.of", 1, "vehicles.A.track.value.of: vehicles.A.track.value is not a"),
        ("title.x", 1, "title.x: title is not a table; write all of it"),
        ('surfaces."my berm".friction', "0.4 ± 0.1", "surfaces.my berm = "),
        ("vehicles A", 1, '"vehicles A": not a key; write it like "vehicles.A.approach.speed"'),
        ("\x1b[2J", 1, '"\\x1b[2J": not a key'),
        ("", 1, '"": not a key'),
        ("[0]", 1, '"[0]": not a key'),
        ("title", "two\nlines", 'title = "two\\nlines": write one line'),
        ("vehicles.A.mass", object, "not a quantity; write it like"),
        ("vehicles.A.mass", UNITS.Quantity(3, "m"), '"m" does not measure a mass; write it in kg or lb'),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_as_of_a_file(key: str, value: object, said: str) -> None:
    message = refusal(load_scene(PAPER), key, value)
    assert message.startswith("brach-1977: ")
    assert said in message
    assert "\n" not in message
    assert message.isprintable()


def test_keywords_are_refused_as_keys_of_a_file_are() -> None:
    with pytest.raises(SceneError) as refused:
        build_scene("mine", title="x", vehicles={}, surface={})
    lines = str(refused.value).split("\n")
    assert 'mine: surface = {}: unknown key; did you mean "surfaces"?' in lines
    assert 'mine: vehicles.A: missing; write A = { mass = "1857 ± 37 kg", … }' in lines


def test_what_could_not_be_read_again_is_refused() -> None:
    scene = load_scene(PAPER)
    marks = [{"point": ["1 m", "1 m"], "speed": {"value": 3, "sd": 1, "unit": "m/s"}}] * 50
    for mark in marks:
        mark["speed"] = mark["speed"] | {"source": '"' * 200}
    long = {"notes": ["é" * 1000] * 50, "vehicles.A.marks": marks, "vehicles.B.marks": marks}
    with pytest.raises(SceneError, match="longer than 100000 bytes"):
        scene.change(long)


def test_quantities_of_pint_are_those_of_the_text() -> None:
    scene, quantity = load_scene(PAPER), UNITS.Quantity
    speed = {"value": quantity(50, "mph"), "sd": quantity(2.9333333333333333, "ft/s")}
    changed = scene.change(
        {
            "vehicles.A.approach.speed": speed,
            "vehicles.A.track": quantity(5, "ft"),
            "vehicles.A.yaw_inertia": {"value": quantity(2500, "slug ft^2"), "sd": 200},
            "vehicles.A.impact.heading": quantity(179, "degree"),
            "impact.point": (quantity(1, "inch"), quantity(0, "m")),
            "surfaces.road.friction": {"value": quantity(0.4, ""), "sd": 0.05},
        }
    )
    written = scene.change(
        {
            "vehicles.A.approach.speed": "50 ± 2 mph",
            "vehicles.A.track": "5 ft",
            "vehicles.A.yaw_inertia": "2500 ± 200 slug ft^2",
            "vehicles.A.impact.heading": "179 deg",
            "impact.point": ["1 in", "0 m"],
            "surfaces.road.friction": "0.4 ± 0.05",
        }
    )
    for name, measured in changed.inputs().items():
        other = written.inputs()[name]
        assert measured.value == pytest.approx(other.value, rel=1e-12, abs=1e-15)
        assert measured.sd == pytest.approx(other.sd, rel=1e-12)
    # what does not fit is not dropped
    speed["sd"] = quantity(2, "kg")
    assert "write a number" in refusal(scene, "vehicles.A.approach.speed", speed)


def test_a_measurement_of_pint_has_its_uncertainty() -> None:
    """Of the package uncertainties, which is not installed here, only what is asked of it."""
    number = SimpleNamespace(nominal_value=50.0, std_dev=2.0)
    measurement = SimpleNamespace(magnitude=number, units=UNITS.mph)
    scene = load_scene(PAPER)
    changed = scene.change({"vehicles.A.approach.speed": measurement})
    written = scene.change({"vehicles.A.approach.speed": "50 ± 2 mph"})
    assert untold(changed) == untold(written)


def test_a_record_that_was_replaced_is_what_is_changed() -> None:
    scene = load_scene(PAPER)
    a = replace(scene.approach["a"], speed=Measured(22.0, 0.9))
    changed = replace(scene, approach=scene.approach | {"a": a}).change(
        {"vehicles.A.mass": "1800 ± 20 kg"}
    )
    assert changed.approach["a"].speed == Measured(22.0, 0.9)
    assert changed.vehicles["a"].mass.value == 1800
    assert changed.contact.Gamma.value == pytest.approx(scene.contact.Gamma.value)
    assert parse_scene(changed.to_toml(), changed.name) == changed


def test_what_a_scene_file_cannot_say_is_not_lost_in_silence() -> None:
    message = refusal(collision(share=0), "title", "x")
    assert "a scene file cannot say mass_a as it is" in message


def test_a_question_that_an_option_added_stays() -> None:
    scene = load_scene(PAPER)
    asked = replace(scene.questions, probabilities=(read_proposition("speed_b > 45 mph"),))
    scene = replace(scene, questions=asked)
    assert scene.change({"vehicles.A.mass": "1800 kg"}).questions == asked
    none = scene.change({"questions": {"checks": False}}).questions
    assert none.probabilities == ()
    assert math.isinf(asked.probabilities[0].high)
