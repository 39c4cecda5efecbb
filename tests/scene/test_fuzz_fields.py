"""Scenes of every newer kind, with any values under any keys: a scene or lines that name the file."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.scene.test_marks_before import PIECES, YAW
from tests.shared.fuzz import mistyped, rewritten, toml, verdict
from tests.shared.scene_file import SCENE

USERS = Path(__file__).parents[2] / "benchmarks" / "users" / "scenes"
ASKED = """
[questions]
exceeds = [
  "closing_speed > 40 mph",
  "speed_a > 35 mph and (speed_b < 20 mph or speed_a - speed_b > 10 mph)",
]
between = "40 mph < speed_b < 50 mph"
"""
KINDS = {
    "yaw mark": YAW,
    "skids": PIECES,
    "together": (USERS / "together-perhaps.toml").read_text("utf-8"),
    "slides": (USERS / "pedestrian.toml").read_text("utf-8"),
    "directions": (USERS / "classroom-directions.toml").read_text("utf-8"),
    "questions": SCENE + ASKED,
}


def _never_a_traceback(data: st.DataObject, kind: str, folder: Path) -> None:
    text = KINDS[kind]
    hostile = data.draw(rewritten(tomllib.loads(text)) | mistyped(text))
    assert verdict(hostile, folder) in ("a scene", "refused")


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_a_scene_when_nothing_is_changed(tmp_path: Path, kind: str) -> None:
    document = tomllib.loads(KINDS[kind])
    text = "\n".join(f"{toml(key)} = {toml(value)}" for key, value in document.items())
    assert verdict(text, tmp_path) == "a scene"


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=40, suppress_health_check=list(HealthCheck), deadline=None)
@given(data=st.data())
def test_forty_hostile_files(tmp_path: Path, kind: str, data: st.DataObject) -> None:
    _never_a_traceback(data, kind, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=5000, suppress_health_check=list(HealthCheck), deadline=None)
@given(data=st.data())
def test_five_thousand_hostile_files(tmp_path: Path, kind: str, data: st.DataObject) -> None:
    _never_a_traceback(data, kind, tmp_path)
