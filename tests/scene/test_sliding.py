"""Bodies without wheels: what is read, what is refused, and which models are left."""

import math

import pytest

from retrodict.scene import parse_scene
from retrodict.scene.defaults import SLIDING
from retrodict.scene.errors import SceneError
from retrodict.scene.write import scene_toml
from retrodict.studies.ladder import allowed

MOTORCYCLE = """
schema = 1
title = "Motorcycle into the side of a car"
[vehicles.A]
mass = "330 ± 15 kg"
slides = "0.45 ± 0.1"
approach = { direction = "10 ± 2 deg" }
rest = { distance = "4 ± 0.5 m", direction = "60 ± 5 deg" }
[vehicles.B]
mass = "1500 ± 40 kg"
impact = { heading = "90 ± 2 deg" }
rest = { distance = "6 ± 0.5 m", direction = "70 ± 3 deg" }
[surfaces.road]
friction = "0.7 ± 0.05"
"""


def test_it_needs_no_heading_and_momentum_answers():
    scene = parse_scene(MOTORCYCLE, "motorcycle")
    assert scene.vehicles["a"].heading.value == pytest.approx(math.radians(10))
    assert allowed(scene) == ["momentum+slide"]
    assert scene.inputs()["slides_a"].value == pytest.approx(0.45)


def test_a_kind_of_body_stands_for_its_drag_factor():
    scene = parse_scene(MOTORCYCLE.replace("0.45 ± 0.1", "motorcycle on its side"), "motorcycle")
    of_kind = SLIDING["motorcycle on its side"]
    drag = scene.vehicles["a"].slides
    assert (drag.value, drag.sd, drag.assumed) == (of_kind.value, of_kind.sd, "value")
    assert of_kind.source in drag.source


def test_a_text_made_of_it_reads_as_the_same_body():
    again = parse_scene(scene_toml(parse_scene(MOTORCYCLE, "motorcycle")), "motorcycle")
    assert again.vehicles["a"].slides.value == pytest.approx(0.45)
    assert "vehicles.A.wheelbase" in again.unwritten


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('slides = "0.45 ± 0.1"', 'slides = "0.45 ± 0.1"\ntrack = "0.5 m"', "A.track"),
        ('slides = "0.45 ± 0.1"', 'slides = "0.45 ± 0.1"\nwheelbase = "1.4 m"', "A.wheelbase"),
        ('slides = "0.45 ± 0.1"', 'slides = "a sofa"', '"motorcycle on its side"'),
        ('slides = "0.45 ± 0.1"', 'slides = "0.45"', "needs an uncertainty"),
        ('slides = "0.45 ± 0.1"\n', "", "A.impact: missing"),
        ('{ direction = "10 ± 2 deg" }', '{ direction = "unknown" }', "A.impact: missing"),
    ],
)
def test_what_it_cannot_have_is_refused(old, new, said):
    assert old in MOTORCYCLE
    with pytest.raises(SceneError) as caught:
        parse_scene(MOTORCYCLE.replace(old, new), "motorcycle")
    assert said in str(caught.value)
