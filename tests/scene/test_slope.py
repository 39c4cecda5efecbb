"""The slope of a scene's ground: how it is written, and where it is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from retrodict.explore.controls import controls
from retrodict.scene import SceneError, parse_scene
from retrodict.scene.records import Scene
from retrodict.scene.write import scene_toml
from tests.shared.scene_file import SCENE, changed


def on_slope(grade: str, uphill: str = "90 ± 5 deg", text: str = SCENE) -> Scene:
    slope = f'[slope]\ngrade = "{grade}"\nuphill = "{uphill}"\n\n[priors.speed_a]'
    return parse_scene(text.replace("[priors.speed_a]", slope), "scene")


def refusal(grade: str, text: str = SCENE) -> str:
    with pytest.raises(SceneError) as found:
        on_slope(grade, text=text)
    (problem,) = found.value.problems
    return str(problem)


def test_none_is_level() -> None:
    scene = parse_scene(SCENE, "scene")
    assert scene.slope is None
    assert not {"grade", "uphill"} & scene.inputs().keys()


@pytest.mark.parametrize("grade", ["4 ± 0.5 %", "4 % ± 0.5 %", "4 ± 0.5%"])
def test_it_is_two_inputs(grade: str) -> None:
    """Its error is in per cent of a grade, and not of its value."""
    scene = on_slope(grade, "90 deg")
    grade_, uphill = scene.inputs()["grade"], scene.inputs()["uphill"]
    assert (grade_.value, grade_.sd) == pytest.approx((0.04, 0.005))
    assert (uphill.value, uphill.sd) == pytest.approx((math.pi / 2, math.radians(5)))
    assert uphill.assumed == "sd"


def test_a_scene_made_from_its_values_says_the_same() -> None:
    scene = on_slope("3.3 ± 0.7 %")
    again = parse_scene(scene_toml(replace(scene, text="")), "scene")
    for name in ("grade", "uphill"):
        one, other = again.inputs()[name], scene.inputs()[name]
        assert (one.value, one.sd) == pytest.approx((other.value, other.sd), rel=1e-12)


@pytest.mark.parametrize(
    ("grade", "said"),
    [
        ("4 %", "needs an uncertainty"),
        ("40 ± 1 %", "between 0 and 30 %"),
        ("4 ± 1 deg", "write it in %"),
    ],
)
def test_what_it_is_not_says_what_to_write(grade: str, said: str) -> None:
    assert said in refusal(grade)


def test_a_slope_that_drives_a_rolling_car_is_refused() -> None:
    """All wheels free: 1.4 % of the load on the road, and less by what is not known."""
    text = changed(
        ('"locked"\nfront_right', '"rolling"\nfront_right'), ('"0.3 ± 0.1"', '"rolling"')
    )
    text = text.replace('{ value = 0.2, sd = 0.05, source = "rubbed" }', '"rolling"')
    said = refusal("2 ± 0.2 %", text)
    assert 'slope.grade = "2 ± 0.2 %": it may drive vehicle A on' in said
    assert "write the drag of wheels" in said
    assert on_slope("0.1 ± 0.1 %", text=text).slope


def test_a_slope_that_drives_a_locked_car_is_refused() -> None:
    icy = SCENE.replace('friction = "0.40 ± 0.03"', 'kind = "ice"')
    icy = icy.replace("[vehicles.A.wheels]", "[vehicles.A.unused]")
    start, end = icy.index("[vehicles.A.unused]"), icy.index("[vehicles.A.impact]")
    icy = (icy[:start] + icy[end:]).replace('steer = "3 ± 2 deg"\n', "")
    with pytest.raises(SceneError) as found:
        on_slope("9 ± 1 %", text=icy)
    assert ["on the berm" in str(problem) for problem in found.value.problems] == [True, True]
    assert on_slope("2 ± 0.2 %", text=icy).slope


def test_it_has_sliders() -> None:
    found = {each.key: each for each in controls(on_slope("4 ± 0.5 %"))}
    grade = found["slope.grade"]
    assert (grade.group, grade.label, grade.text()) == ("Surfaces", "slope grade", "4 ± 0.5 %")
    assert "slope.uphill" in found
