"""Whatever is written, a scene or a SceneError comes out."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings

from retrodict.scene import SceneError, parse_scene
from retrodict.scene.records import Scene
from tests.shared.fuzz import DOCUMENT, mistyped, rewritten, texts, toml, verdict


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
            if measured.assumed:  # of a damaged wheel, a wider law
                continue
            assert measured.sd <= measured.value * (1 - measured.value), name
    assert scene.question
    for prior in scene.priors.values():
        assert all(math.isfinite(number) for number in prior.numbers), prior.text


@given(rewritten())
def test_any_values_under_any_keys(text: str) -> None:
    scene = outcome(text)
    if scene:
        sound(scene)


@given(mistyped())
def test_any_change_of_the_text(text: str) -> None:
    scene = outcome(text)
    if scene:
        sound(scene)


@settings(suppress_health_check=list(HealthCheck))
@given(texts)
def test_the_command_never_ends_in_a_traceback(tmp_path: Path, text: str) -> None:
    assert verdict(text, tmp_path) in ("a scene", "refused")


@pytest.mark.slow
@settings(max_examples=10_000, suppress_health_check=list(HealthCheck))
@given(texts)
def test_ten_thousand_files(tmp_path: Path, text: str) -> None:
    assert verdict(text, tmp_path) in ("a scene", "refused")


def test_the_fuzzed_scene_is_right_when_nothing_is_changed():
    text = "\n".join(f"{toml(key)} = {toml(value)}" for key, value in DOCUMENT.items())
    scene = outcome(text)
    assert scene is not None
    sound(scene)
