"""A scene file written otherwise is the same crash."""

import tomllib
from pathlib import Path

import pytest

from retrodict.scene.edit import build_scene
from retrodict.studies.rewritten import exchanged, in_other_units, same_numbers
from tests.shared.scene_file import SCENE

ROOT = Path(__file__).parents[2]
FILES = [
    *(ROOT / "examples").glob("*/scene.toml"),
    ROOT / "benchmarks" / "staged" / "cases" / "nhtsa-7292" / "scene.toml",
    ROOT / "benchmarks" / "staged" / "cases" / "iihs-cf11002" / "scene.toml",
]


@pytest.mark.parametrize("text", [SCENE, *(file.read_text() for file in FILES)])
def test_other_units_are_the_same_numbers(text):
    document = tomllib.loads(text)
    other = in_other_units(document)
    assert other != document
    assert same_numbers(build_scene(**other), build_scene(**document))


def test_another_number_is_not_the_same():
    document = tomllib.loads(SCENE)
    heavier = {**document, "vehicles": {**document["vehicles"]}}
    heavier["vehicles"]["B"] = {**document["vehicles"]["B"], "mass": "1779 kg"}
    assert not same_numbers(build_scene(**heavier), build_scene(**document))


def test_every_converted_quantity_has_its_factor():
    """A foot is 0.3048 m, by definition."""
    table = in_other_units({"value": 10, "sd": 1, "unit": "m", "source": "3 m"})
    assert table["value"] == pytest.approx(10 / 0.3048)
    assert table["sd"] == pytest.approx(1 / 0.3048)
    assert table["source"] == "3 m"
    assert in_other_units("1 ± 0.5 ft") == {"value": 0.3048, "sd": 0.1524, "unit": "m"}


def test_vehicles_and_what_is_asked_of_them_are_exchanged():
    document = tomllib.loads(SCENE) | {"priors": {"speed_b": {"scale": "40 m/s"}}}
    other = exchanged(document)
    assert other["vehicles"]["A"] == document["vehicles"]["B"]
    assert other["question"] == ["mu", "speed_a"]
    assert list(other["priors"]) == ["speed_a"]
    again = exchanged(other)
    assert again["vehicles"] == document["vehicles"]
    assert again["question"] == document["question"]


def test_one_vehicle_alone_is_not_exchanged():
    assert exchanged({"vehicles": {"A": {}}, "barrier": {}}) is None
