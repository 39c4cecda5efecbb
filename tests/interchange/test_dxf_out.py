"""DXF, read back by ezdxf: layers, units and coordinates are those of the drawing, texts are data."""

import io

import ezdxf
import pytest

from retrodict.interchange.dxf_out import dxf
from retrodict.interchange.plan_drawing import Drawing, Ellipse, Layer
from tests.interchange.plans import PLAN


def read(drawing):
    document = ezdxf.read(io.StringIO(dxf(drawing).decode()))
    audit = document.audit()
    assert not audit.errors
    assert not audit.fixes
    return document


def test_units_are_metres_and_the_extent_is_that_of_the_shapes():
    header = read(PLAN).header
    assert header["$INSUNITS"] == ezdxf.units.M
    assert header["$MEASUREMENT"] == 1
    x0, x1, y0, y1 = PLAN.bounds
    assert header["$EXTMIN"] == pytest.approx((x0, y0, 0))
    assert header["$EXTMAX"] == pytest.approx((x1, y1, 0))


def test_layers_have_their_names_colours_and_lines():
    layers = read(PLAN).layers
    path = layers.get("A-PATH")
    assert path.rgb == (0x00, 0x72, 0xB2)
    assert path.dxf.linetype == "DASHED"
    assert layers.get("ERROR").dxf.linetype == "Continuous"


def test_coordinates_are_kept_to_a_nanometre():
    space = read(PLAN).modelspace()
    open_line, closed = space.query("LWPOLYLINE[layer=='A-PATH']")
    for found, line in zip((open_line, closed), PLAN.layers[0].shapes, strict=True):
        assert [tuple(p) for p in found.get_points("xy")] == [
            pytest.approx(tuple(p), abs=1e-9) for p in line.points
        ]
        assert found.closed == line.closed
    (ellipse,), (point,) = space.query("ELLIPSE"), space.query("POINT")
    assert tuple(ellipse.dxf.center) == pytest.approx((1, -2, 0))
    # the longer half-axis first: along y
    assert tuple(ellipse.dxf.major_axis) == pytest.approx((0, 1.5, 0))
    assert ellipse.dxf.ratio == pytest.approx(1 / 3)
    assert tuple(point.dxf.location) == pytest.approx((3.25, -4.5, 0))


def test_a_narrow_ellipse_is_drawn_as_narrow_as_dxf_knows():
    narrow = Drawing("", (Layer("E", "#222222", (Ellipse((0.0, 0.0), (1.0, 1e-9)),)),))
    (ellipse,) = read(narrow).modelspace()
    assert ellipse.dxf.ratio == pytest.approx(1e-6)


def test_no_character_of_a_text_ends_a_record():
    space = read(PLAN).modelspace()
    (text,) = space.query("TEXT")
    assert len(space) == 5
    assert "\n" not in text.dxf.text
    assert text.plain_text().endswith(" μ")
    assert "EOF" in text.plain_text()
    assert "%%" not in text.dxf.text


def test_the_same_drawing_gives_the_same_bytes():
    assert dxf(PLAN) == dxf(PLAN)
    assert ezdxf.options.write_fixed_meta_data_for_testing is False  # as it was
