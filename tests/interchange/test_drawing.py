"""Drawings as DXF, written by ezdxf itself: places by layer, whatever the version."""

from __future__ import annotations

import io
import itertools
import math
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from ezdxf.document import Drawing

from retrodict.interchange import plan_drawing
from retrodict.interchange.dxf_out import dxf
from retrodict.interchange.importing import Import
from retrodict.scene import parse_scene
from retrodict.scene.records import Outline
from tests.interchange.test_survey import imported, refusal

MAP = """
[drawing]
unit = "m"
precision = "0.03 m"
axes = ["east", "north"]
angles = "counter-clockwise from east"
[impact_point]
point = "GOUGE"
uncertainty = "0.04 m"
[rest.A]
points = { centre = "CAR_A" }
uncertainty = "0.1 m"
[[marks.B]]
points = ["SKID"]
of = "rear_left"
uncertainty = "0.1 m"
[edges.berm]
points = ["KERB"]
side = "left"
uncertainty = "0.1 m"
"""


def drawing(version: str = "R2010", scale: float = 1.0) -> Drawing:
    """A scene on layers, in metres times a scale."""
    document = ezdxf.new(version)
    space = document.modelspace()

    def at(*places: tuple[float, float]) -> list[tuple[float, float]]:
        return [(scale * x, scale * y) for x, y in places]

    space.add_point(at((0.4, 0.3))[0], dxfattribs={"layer": "GOUGE"})
    car = document.blocks.new("CAR")
    car.add_line((-2, 0), (2, 0))
    turned = {"layer": "CAR_A", "rotation": 215}
    space.add_blockref("CAR", at((-4, 2))[0], dxfattribs=turned)
    space.add_polyline2d(at((3, -1), (5, -4), (6, -8)), dxfattribs={"layer": "SKID"})
    space.add_line(*at((-9, 4), (9, 4)), dxfattribs={"layer": "KERB"})
    space.add_text("north", dxfattribs={"layer": "TEXT"})
    return document


def written(document: Drawing) -> bytes:
    text = io.StringIO()
    document.write(text)
    return text.getvalue().encode(document.output_encoding)


@pytest.mark.parametrize("version", ["R12", "R2000", "R2010", "R2018"])
def test_layers_become_keys_in_every_version(tmp_path: Path, version: str) -> None:
    found = imported(tmp_path, written(drawing(version)), MAP, "scene.dxf")
    scene = found.scene
    assert (scene.contact.x.value, scene.contact.y.value) == (0.4, 0.3)
    assert scene.contact.x.source.startswith("scene.dxf, point GOUGE#1, POINT; SHA-256 ")
    rest = scene.rest["a"]
    assert (rest.x.value, rest.y.value) == (-4, 2)
    assert rest.heading is not None
    assert math.remainder(rest.heading.value - math.radians(215), math.tau) == pytest.approx(
        0, abs=1e-5
    )
    assert rest.heading.assumed == "sd"
    assert [(m.x, m.y, m.of) for m in scene.marks["b"]] == [
        (3, -1, "rear_left"),
        (5, -4, "rear_left"),
        (6, -8, "rear_left"),
    ]
    edge = scene.surfaces[1].edge
    assert edge is not None
    assert (edge.x, edge.y, edge.direction) == (0, 4, 0)
    assert found.left == (
        '1 TEXT on layer "TEXT": places are taken of POINT, LINE, LWPOLYLINE, POLYLINE, CIRCLE, INSERT',
    )


OUTLINE = (
    MAP.partition("[edges")[0]
    + """
[outlines.berm]
points = ["OIL"]
uncertainty = "0.1 m"
"""
)
PATCH = [(3.0, -5.0), (7.0, -6.0), (8.0, -3.0), (4.0, -2.5)]


def outlined(tmp_path: Path, document: Drawing) -> tuple[Outline, Import]:
    found = imported(tmp_path, written(document), OUTLINE, "scene.dxf")
    berm = found.scene.surfaces[1]
    assert berm.edge is None  # which the scene file had
    assert berm.outline is not None
    return berm.outline, found


@pytest.mark.parametrize("version", ["R12", "R2010"])
@pytest.mark.parametrize("way", ["polyline", "closed by hand", "lines"])
def test_a_closed_polyline_is_an_outline(tmp_path: Path, version: str, way: str) -> None:
    document = drawing(version)
    space, look = document.modelspace(), {"layer": "OIL"}
    round_again = [*PATCH, PATCH[0]]
    if way == "lines":
        for a, b in itertools.pairwise(round_again):
            space.add_line(a, b, dxfattribs=look)
    elif version == "R12":
        closed = way == "polyline"
        corners = PATCH if closed else round_again
        space.add_polyline2d(corners, close=closed, dxfattribs=look)
    else:
        space.add_lwpolyline(
            PATCH if way == "polyline" else round_again, close=way == "polyline", dxfattribs=look
        )
    outline, found = outlined(tmp_path, document)
    assert outline.corners == tuple(PATCH)
    assert outline.offset.sd == pytest.approx(math.hypot(0.03, 0.1), rel=1e-2)
    assert outline.offset.source.startswith("scene.dxf, points OIL#1, OIL#2, OIL#3, OIL#4")
    taken = {each.key: each for each in found.taken}
    assert taken["surfaces.berm.edge"].value is None
    again = {"polyline": 0, "closed by hand": 1, "lines": 4}[way]
    remark = f"{again} of them at the corner before" if again else ""
    assert taken["surfaces.berm.outline"].remark == remark


def test_an_exported_outline_comes_back(tmp_path: Path) -> None:
    exported = plan_drawing.Layer("OIL", "#000000", (plan_drawing.Line(np.array(PATCH), True),))
    content = dxf(plan_drawing.Drawing("x", (exported,)))
    frame = OUTLINE.partition("[impact_point]")[0] + OUTLINE[OUTLINE.index("[outlines") :]
    found = imported(tmp_path, content, frame, "scene.dxf")
    outline = found.scene.surfaces[1].outline
    assert outline is not None
    assert outline.corners == tuple(PATCH)


def test_a_hundred_corners_fit_into_a_scene_file(tmp_path: Path) -> None:
    document = drawing()
    circle = [(30 * math.cos(i / 16), 30 * math.sin(i / 16)) for i in range(100)]
    document.modelspace().add_lwpolyline(circle, close=True, dxfattribs={"layer": "OIL"})
    outline, found = outlined(tmp_path, document)
    assert np.array(outline.corners) == pytest.approx(np.array(circle), abs=1e-4)
    assert parse_scene(found.text, "again").surfaces[1].outline == outline


def test_points_that_make_no_outline_are_named_in_the_map(tmp_path: Path) -> None:
    document = drawing()
    bow = [PATCH[0], PATCH[2], PATCH[1], PATCH[3]]
    document.modelspace().add_lwpolyline(bow, close=True, dxfattribs={"layer": "OIL"})
    said = refusal(tmp_path, written(document), OUTLINE, "scene.dxf")
    assert "map.toml: outlines.berm.points: its sides from corner" in said
    both = OUTLINE + MAP[MAP.index("[edges") :]
    said = refusal(tmp_path, written(document), both, "scene.dxf")
    assert "outlines.berm" in said
    assert "has an edge too; leave out one of them" in said


def test_arcs_of_polylines_are_mentioned(tmp_path: Path) -> None:
    document = drawing()
    corners = [(*p, bulge) for p, bulge in zip(PATCH, (0, 0.5, 0, 0), strict=True)]
    document.modelspace().add_lwpolyline(corners, "xyb", close=True, dxfattribs={"layer": "OIL"})
    outline, found = outlined(tmp_path, document)
    assert outline.corners == tuple(PATCH)
    assert 'arcs of 1 LWPOLYLINE on layer "OIL": their ends are taken' in found.left


def test_inches_and_a_drawing_seen_from_below(tmp_path: Path) -> None:
    """A block on a plane whose normal points down is mirrored, as every CAD program draws it."""
    document = drawing(scale=1 / 0.0254)
    document.modelspace().add_blockref(
        "CAR", (2, 1), dxfattribs={"layer": "CAR_B", "rotation": 170, "extrusion": (0, 0, -1)}
    )
    insert = document.modelspace().query("INSERT[layer=='CAR_B']").first
    assert insert is not None
    ahead = insert.matrix44().transform_direction((1, 0, 0))
    more = '[rest.B]\npoints = { centre = "CAR_B" }\nuncertainty = "0.1 m"\n'
    content = MAP.replace('unit = "m"', 'unit = "in"') + more
    found = imported(tmp_path, written(document), content, "scene.dxf").scene
    assert (found.contact.x.value, found.contact.y.value) == pytest.approx((0.4, 0.3), abs=1e-4)
    rest = found.rest["b"]
    assert rest.heading is not None
    expected = math.atan2(ahead.y, ahead.x)
    assert math.remainder(rest.heading.value - expected, math.tau) == pytest.approx(0, abs=1e-5)
    assert (rest.x.value, rest.y.value) == pytest.approx((-2 * 0.0254, 0.0254), abs=1e-4)


def test_a_header_of_another_unit_is_mentioned(tmp_path: Path) -> None:
    document = drawing()
    document.units = ezdxf.units.MM
    found = imported(tmp_path, written(document), MAP, "scene.dxf")
    assert any("$INSUNITS = 4, 0.001 m" in line for line in found.left)


EVERYTHING = """
[drawing]
unit = "{}"
precision = "0.03 m"
axes = ["east", "north"]
angles = "counter-clockwise from east"
[[marks.A]]
points = ["0"]
of = "centre"
uncertainty = "0.1 m"
"""


@pytest.mark.parametrize(("code", "unit", "metres"), [
    (0, "m", 1.0), (1, "in", 0.0254), (2, "ft", 0.3048), (4, "mm", 0.001), (6, "m", 1.0),
])  # fmt: skip
@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_every_kind_of_place_is_taken_in_every_unit(
    tmp_path: Path, version: str, code: int, unit: str, metres: float
) -> None:
    document = ezdxf.new(version, units=code)
    space = document.modelspace()
    places = [(0.5 * i, 3.0 - i) for i in range(10)]
    at = [(x / metres, y / metres) for x, y in places]
    space.add_point(at[0])
    space.add_line(at[1], at[2])
    space.add_polyline2d(at[3:6])
    if version == "R12":  # which has no LWPOLYLINE
        space.add_polyline3d([(x, y, 0.2) for x, y in at[6:8]])
    else:
        space.add_lwpolyline(at[6:8])
    space.add_circle(at[8], 0.1 / metres)
    document.blocks.new("CONE").add_line((0, 0), (1, 1))
    space.add_blockref("CONE", at[9])
    found = imported(tmp_path, written(document), EVERYTHING.format(unit), "scene.dxf")
    marks = [(m.x, m.y) for m in found.scene.marks["a"]]
    np.testing.assert_allclose(marks, places, rtol=0, atol=1e-4)  # tenths of a millimetre are kept
    assert not found.left


def test_a_layer_of_thousands_of_points_is_refused_for_their_number(tmp_path: Path) -> None:
    document = ezdxf.new()
    document.modelspace().add_polyline2d([(i, 0) for i in range(2000)])
    said = refusal(tmp_path, written(document), EVERYTHING.format("m"), "scene.dxf")
    assert "2000 marks; write at most 50 for a vehicle" in said
    assert "\n" not in said


def test_a_drawing_without_places_says_what_it_has(tmp_path: Path) -> None:
    document = ezdxf.new()
    document.modelspace().add_mtext("north")
    said = refusal(tmp_path, written(document), EVERYTHING.format("m"), "scene.dxf")
    assert "its model space has MTEXT, but none of POINT, LINE" in said


def test_several_points_on_a_layer_are_named_by_number(tmp_path: Path) -> None:
    document = drawing()
    document.modelspace().add_point((7, 8), dxfattribs={"layer": "GOUGE"})
    assert "2 points have this name" in refusal(tmp_path, written(document), MAP, "scene.dxf")
    second = MAP.replace('"GOUGE"', '"GOUGE#2"')
    found = imported(tmp_path, written(document), second, "scene.dxf").scene
    assert (found.contact.x.value, found.contact.y.value) == (7, 8)


def test_blocks_that_contain_each_other_are_never_expanded(tmp_path: Path) -> None:
    document = drawing()
    document.blocks.get("CAR").add_blockref("TWIN", (0, 0))
    document.blocks.new("TWIN").add_blockref("CAR", (0, 0))
    scene = imported(tmp_path, written(document), MAP, "scene.dxf").scene
    assert scene.rest["a"].x.value == -4


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"AutoCAD Binary DXF\r\n\x1a\0", "is a binary DXF file"),
        (b"AC1032\0\0", "is a DWG file"),
        (b"\x89PNG\r\n", "not a DXF file that can be read"),
        (b"0\nSECTION\n", "none of POINT"),
    ],
)
def test_other_drawings_are_refused(tmp_path: Path, content: bytes, said: str) -> None:
    assert said in refusal(tmp_path, content, MAP, "scene.dxf")
