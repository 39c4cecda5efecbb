"""The public names, as a notebook uses them."""

from dataclasses import replace
from pathlib import Path

import pytest

import retrodict as rd
from retrodict import api
from retrodict.inference import Interrupted
from tests.studies.made_up import ladder_of, step

SCENE = Path(__file__).parents[1] / "examples" / "brach-1977" / "scene.toml"


def test_public_names_are_there() -> None:
    for name in rd.__all__:
        assert getattr(rd, name) is not None


def test_a_scene_shows_itself_and_is_named_after_its_folder() -> None:
    scene = rd.load_scene(SCENE)
    assert scene.name == "brach-1977"
    page = scene._repr_html_()
    assert "SAE 770014" in page
    assert "<script" not in page


def test_the_default_model_is_the_one_that_the_ladder_chooses(monkeypatch) -> None:
    told = ladder_of(step("low", 19.0), step("full", 19.1))
    ran = []
    monkeypatch.setattr(api, "_reconstruct", lambda scene, **given: ran.append(given["model"]))
    monkeypatch.setattr(api, "ladder", lambda scene, **_: told)
    monkeypatch.setattr(api, "allowed", lambda scene: ["low", "full"])
    assert api.reconstruct(told.scene).ladder is told
    none = replace(told, choice=None)
    monkeypatch.setattr(api, "ladder", lambda scene, **_: none)
    api.reconstruct(told.scene)
    assert api.reconstruct(told.scene, model="middle").ladder is None
    monkeypatch.setattr(api, "allowed", lambda scene: ["full"])  # nothing to climb
    assert api.reconstruct(told.scene).ladder is None
    assert ran == ["low", "full", "middle", "full"]
    monkeypatch.setattr(api, "allowed", lambda scene: ["low", "full"])
    monkeypatch.setattr(api, "ladder", lambda scene, **_: replace(none, complete=False))
    with pytest.raises(Interrupted):
        api.reconstruct(told.scene)
