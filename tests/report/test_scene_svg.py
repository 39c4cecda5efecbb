"""The scene as a small SVG: all that was measured is in view, and names are text."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import pytest

from retrodict.report.scene_svg import scene_svg, view_of
from retrodict.scene.records import Scene
from tests.report.conftest import make_scene, make_sparse_scene

SVG = "{http://www.w3.org/2000/svg}"


def parsed(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(text.replace("<svg ", f'<svg xmlns="{SVG[1:-1]}" ', 1))


@pytest.mark.parametrize("scene", [make_scene(), make_sparse_scene()], ids=["full", "sparse"])
def test_all_that_was_measured_is_in_view(scene: Scene) -> None:
    drawing = parsed(scene_svg(scene))
    width, height = map(float, drawing.attrib["viewBox"].split()[2:])
    count = 0
    for shape in drawing.iter(f"{SVG}polygon"):
        for pair in shape.attrib["points"].split():
            x, y = map(float, pair.split(","))
            assert -1 <= x <= width + 1
            assert -1 <= y <= height + 1
            count += 1
    assert count > 10
    assert len(list(drawing.iter(f"{SVG}ellipse"))) == 1 + len(scene.rest)
    assert sum(e.get("class") == "mark" for e in drawing.iter()) == sum(
        map(len, scene.marks.values())
    )


def test_a_view_holds_the_one_before() -> None:
    scene = make_scene()
    x0, x1, y0, y1 = view_of(scene)
    wide = (x0 - 5, x1 - 1, y0 + 1, y1 + 5)
    assert view_of(scene, wide) == (x0 - 5, x1, y0, y1 + 5)


def test_names_are_text() -> None:
    scene = make_scene()
    hostile = replace(scene.vehicles["a"], name="</title><script>run()</script>")
    text = scene_svg(replace(scene, vehicles=scene.vehicles | {"a": hostile}))
    assert "<script" not in text
    assert parsed(text).tag == f"{SVG}svg"
