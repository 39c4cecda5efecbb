"""Whatever is written, a scene or a SceneError comes out."""

from __future__ import annotations

import copy
import math
import tomllib
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from retrodict.scene import SceneError, parse_scene
from retrodict.scene.records import Scene
from tests.scene.example import SCENE

DOCUMENT = tomllib.loads(SCENE)
TOKENS = [
    "±",
    "+/-",
    "%",
    "-",
    "kg",
    "m",
    "deg",
    "mph",
    "^2",
    "/",
    " ",
    "1e9",
    "0",
    "nan",
    ",",
    '"',
]
TOKENS += ["\n", "[", "]", "{", "}", "=", ".", "#", "\x1b", "°", "²", "lb", "9" * 40, "1e-300", "t"]

quantities = st.lists(st.sampled_from(TOKENS) | st.text(max_size=4), max_size=6).map("".join)
written = st.builds(
    "{} ± {} {}".format,
    st.floats(),
    st.floats(),
    st.sampled_from(["kg", "m", "deg", "mph", "", "kg m^2", "s/m", "deg/s", "% m"]),
)
scalars = st.one_of(
    quantities, written, st.integers(), st.floats(), st.booleans(), st.dates(), st.times()
)
keys = st.sampled_from(["value", "sd", "unit", "source", "a", "A", "mass", "edge"]) | st.text()
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=4),
    max_leaves=6,
)


def places(table: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items: Any = table.items() if isinstance(table, dict) else enumerate(table)
    found = []
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


def toml(value: Any) -> str:
    """A value as TOML, written apart from the code under test."""
    if isinstance(value, str):
        return '"' + "".join(c if c.isalnum() else f"\\U{ord(c):08x}" for c in value) + '"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(str(k))} = {toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return str(value)


def outcome(text: str) -> Scene | None:
    try:
        return parse_scene(text, "fuzz")
    except SceneError as error:
        lines = str(error).split("\n")
        assert lines
        assert all(line.startswith("fuzz: ") and line.isprintable() for line in lines)
        return None


def sound(scene: Scene) -> None:
    for name, measured in (scene.inputs() | scene.evidence()).items():
        assert math.isfinite(measured.value), name
        assert math.isfinite(measured.sd), name
        assert measured.sd >= 0, name
        if measured.law == "lognormal":
            assert measured.value > 0, name
            assert measured.sd <= measured.value, name
        if measured.law == "logitnormal":
            assert 0 <= measured.value <= 1, name
            assert measured.sd <= measured.value * (1 - measured.value), name
    assert scene.question
    for prior in scene.priors.values():
        assert all(math.isfinite(number) for number in prior.numbers), prior.text


@settings(max_examples=300)
@given(st.data())
def test_any_values_under_any_keys(data):
    document = copy.deepcopy(DOCUMENT)
    for _ in range(data.draw(st.integers(1, 2))):
        *path, last = data.draw(st.sampled_from(places(document)))
        table: Any = document
        for key in path:
            table = table[key]
        action = data.draw(st.sampled_from(["replace", "delete", "add"]))
        if action == "delete":
            del table[last]
        elif action == "add" and isinstance(table, dict):
            table[data.draw(keys)] = data.draw(values)
        else:
            table[last] = data.draw(values)
    scene = outcome("\n".join(f"{toml(key)} = {toml(value)}" for key, value in document.items()))
    if scene:
        sound(scene)


@settings(max_examples=200)
@given(st.integers(0, len(SCENE)), st.integers(0, 20), quantities | st.text(max_size=20))
def test_any_change_of_the_text(start, length, new):
    scene = outcome(SCENE[:start] + new + SCENE[start + length :])
    if scene:
        sound(scene)


def test_the_fuzzed_scene_is_right_when_nothing_is_changed():
    text = "\n".join(f"{toml(key)} = {toml(value)}" for key, value in DOCUMENT.items())
    scene = outcome(text)
    assert scene is not None
    sound(scene)
