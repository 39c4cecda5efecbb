"""Drawings as DXF, written by ezdxf itself: places by layer, whatever the version."""

from __future__ import annotations

import io
import math
from pathlib import Path

import ezdxf
import pytest
from ezdxf.document import Drawing

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
