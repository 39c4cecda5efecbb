"""SVG, read back as XML: to scale, a group a layer, every text escaped."""

from xml.etree import ElementTree as ET

import pytest

from retrodict.interchange.svg_out import svg
from tests.interchange.plans import PLAN

SVG, INKSCAPE = "{http://www.w3.org/2000/svg}", "{http://www.inkscape.org/namespaces/inkscape}"


def test_a_metre_is_ten_millimetres_on_paper():
    root = ET.fromstring(svg(PLAN))
    _, _, width, height = map(float, root.get("viewBox").split())
    for given, name in ((width, "width"), (height, "height")):
        assert root.get(name).endswith("mm")
        assert float(root.get(name).removesuffix("mm")) == pytest.approx(10 * given, abs=0.06)


def test_every_layer_is_a_group_that_drawing_programs_know_as_a_layer():
    groups = ET.fromstring(svg(PLAN)).findall(f"{SVG}g")
    names = [layer.name for layer in PLAN.layers]
    assert [g.get(f"{INKSCAPE}label") for g in groups] == names
    assert {g.get(f"{INKSCAPE}groupmode") for g in groups} == {"layer"}


def test_coordinates_are_kept_to_a_tenth_of_a_millimetre_with_y_upwards():
    root = ET.fromstring(svg(PLAN))
    line = PLAN.layers[0].shapes[0].points
    found = [
        tuple(map(float, each.split(",")))
        for each in root.find(f".//{SVG}polyline").get("points").split()
    ]
    assert found == [pytest.approx((x, -y), abs=5.1e-5) for x, y in line]
    ellipse = root.find(f".//{SVG}ellipse")
    assert [float(ellipse.get(k)) for k in ("cx", "cy", "rx", "ry")] == [1.0, 2.0, 0.5, 1.5]


def test_texts_make_no_elements():
    root = ET.fromstring(svg(PLAN))
    tags = {element.tag.removeprefix(SVG) for element in root.iter()}
    assert tags == {"svg", "title", "g", "polyline", "polygon", "ellipse", "path", "text"}
    assert "<script>" in root.find(f".//{SVG}text").text  # as text
