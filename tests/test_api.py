"""The public names, as a notebook uses them."""

from pathlib import Path

import retrodict as rd

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
