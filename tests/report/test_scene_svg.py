"""The scene as a small SVG: all that was measured is in view, and names are text."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import pytest

from retrodict.report.scene_svg import scene_svg, view_of
from retrodict.scene.records import Measured, Outline, Scene, Surface
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


def test_an_outline_is_drawn_over_the_edges_to_scale() -> None:
    scene = make_scene()
    corners = ((3.0, -5.0), (7.0, -6.0), (8.0, -3.0), (-900.0, 0.0))
    oil = Surface("oil", Measured(0.2), Measured(0.0), None, Outline(corners, Measured(0.0, 0.2)))
    drawing = parsed(scene_svg(replace(scene, surfaces=(*scene.surfaces, oil))))
    berm, found = (e for e in drawing.iter(f"{SVG}polygon") if e.get("class") == "surface")
    assert (berm[0].text, found[0].text) == ("berm", "oil")
    x0, x1, _, y1 = view_of(scene)
    scale = float(drawing.attrib["viewBox"].split()[2]) / (x1 - x0)
    drawn = [tuple(map(float, pair.split(","))) for pair in found.attrib["points"].split()]
    expected = [(scale * (x - x0), scale * (y1 - y)) for x, y in corners]
    assert drawn == [pytest.approx(each, rel=1e-3, abs=0.2) for each in expected]
    away = Outline(tuple((x, y + 900) for x, y in corners), Measured(0.0))
    beyond = (*scene.surfaces, replace(oil, outline=away))
    assert "oil" not in scene_svg(replace(scene, surfaces=beyond))


def test_names_are_text() -> None:
    scene = make_scene()
    hostile = replace(scene.vehicles["a"], name="</title><script>run()</script>")
    text = scene_svg(replace(scene, vehicles=scene.vehicles | {"a": hostile}))
    assert "<script" not in text
    assert parsed(text).tag == f"{SVG}svg"
