"""A drawing as DXF: metres, one DXF layer for each layer."""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING, Any

from retrodict.interchange.plan_drawing import (
    Drawing,
    Ellipse,
    Line,
    Point,
    Shape,
    Text,
    on_one_line,
)

if TYPE_CHECKING:
    from ezdxf.layouts import Modelspace

_VERSION = "R2010"  # the oldest whose text is UTF-8 and that every CAD program of today reads
_METRES, _METRIC, _CROSS = 6, 1, 3  # $INSUNITS, $MEASUREMENT, $PDMODE
_DASHES = [0.6, 0.4, -0.2]  # m: the pattern's length, a dash and a gap
_SCREEN = 1.5  # width over height of the view that it opens in, about
_LEAST_RATIO = 1e-6  # of an ellipse's axes: DXF knows none that is narrower


def dxf(drawing: Drawing) -> bytes:
    """The drawing as a DXF file, in its own coordinates; the same drawing gives the same bytes.

    Args:
        drawing: drawing to write.

    Returns:
        The file. Texts are data: no character of them can end a record of the file.

    Raises:
        ImportError: ezdxf is not installed.
    """
    import ezdxf
    from ezdxf import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True  # no times and no random identifiers
    try:
        document = ezdxf.new(_VERSION, units=_METRES)
        document.linetypes.add("DASHED", _DASHES)
        x0, x1, y0, y1 = drawing.bounds
        header: dict[str, Any] = {
            "$MEASUREMENT": _METRIC,
            "$PDMODE": _CROSS,
            "$PDSIZE": drawing.text_height,
        }
        for name, value in header.items():
            document.header[name] = value
        space = document.modelspace()
        for layer in drawing.layers:
            document.layers.add(
                layer.name,
                true_color=int(layer.colour.removeprefix("#"), 16),
                linetype="DASHED" if layer.dashed else "Continuous",
            )
            for shape in layer.shapes:
                _add(space, shape, {"layer": layer.name}, drawing.text_height)
        space.reset_extents((x0, y0, 0.0), (x1, y1, 0.0))
        height = 1.1 * max(y1 - y0, (x1 - x0) / _SCREEN)
        document.set_modelspace_vport(height, ((x0 + x1) / 2, (y0 + y1) / 2))
        stream = io.StringIO()
        document.write(stream)
    finally:
        options.write_fixed_meta_data_for_testing = before
    return document.encode(stream.getvalue())


def _add(space: Modelspace, shape: Shape, look: dict[str, Any], height: float) -> None:
    match shape:
        case Line(points, closed):
            space.add_lwpolyline(points.tolist(), close=closed, dxfattribs=look)
        case Ellipse(centre, (a, b)):
            major, ratio = ((a, 0.0), b / a) if a >= b else ((0.0, b), a / b)
            space.add_ellipse(centre, major, max(ratio, _LEAST_RATIO), 0, math.tau, look)
        case Point(at):
            space.add_point(at, look)
        case Text(at, text):
            # a caret and a doubled per cent sign begin codes in a DXF text
            plain = on_one_line(text).replace("^", "^ ").replace("%%", "% %")
            space.add_text(plain, height=height, dxfattribs=look | {"insert": at})
