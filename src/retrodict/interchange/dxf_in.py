"""Points from a drawing as DXF, by layer: places of points, lines, polylines, circles and blocks.

Blocks are taken by where they are inserted, and never expanded.
"""

from __future__ import annotations

import io
import logging
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

from retrodict.interchange.column_map import DrawingEntry
from retrodict.interchange.points import Point
from retrodict.interchange.source_file import SourceFile
from retrodict.scene.errors import shown

if TYPE_CHECKING:
    from ezdxf.entities import DXFEntity

ENTITIES = 100_000
_TYPES = ("POINT", "LINE", "LWPOLYLINE", "POLYLINE", "CIRCLE", "INSERT")
_FARTHEST = 1e9  # of a coordinate: beyond, nothing of a scene is left of its digits
_METRES = {  # by $INSUNITS
    1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 10: 0.9144, 14: 0.1, 21: 1200 / 3937,
}  # fmt: skip

_BINARY = {b"AutoCAD Binary DXF": "binary DXF file", b"AC10": "DWG file"}

Place = tuple[float, float, float | None]  # x, y, and heading of a block


def drawing_points(file: SourceFile, drawing: DrawingEntry) -> tuple[list[Point], list[str]]:
    """The places on each layer of a drawing's model space.

    Args:
        file: DXF file in text form.
        drawing: the map's [drawing] table.

    Returns:
        Points, named LAYER#1, LAYER#2 … in the order of the drawing, LAYER being their group, with
        headings of blocks from the drawing's x axis towards its y axis; and lines on what is left out.

    Raises:
        SceneError: the file is not DXF, or too large.
    """
    entities, unit = _read(file)
    points: list[Point] = []
    numbers: Counter[str] = Counter()
    left: Counter[tuple[str, str]] = Counter()
    arcs: Counter[tuple[str, str]] = Counter()
    left_lines = _units(unit, drawing)
    for entity in entities:
        kind = entity.dxftype()
        layer = str(entity.dxf.layer) if entity.dxf.is_supported("layer") else "0"
        if kind not in _TYPES:
            left[layer, kind] += 1
            continue
        try:
            places = list(_places(entity))
            arcs[layer, kind] += bool(getattr(entity, "has_arc", False))
        except Exception:  # what a damaged entity lacks is raised in as many ways
            left[layer, f"damaged {kind}"] += 1
            continue
        for x, y, heading in places:
            numbers[layer] += 1
            far = not max(abs(x), abs(y)) < _FARTHEST or (
                heading is not None and math.isnan(heading)
            )
            fault = "its coordinates are too large, or no numbers" if far else ""
            name = f"{layer}#{numbers[layer]}"
            points.append(Point(name, layer, x, y, kind, heading, fault))
    types = ", ".join(_TYPES)
    for (layer, kind), count in left.items():
        left_lines.append(f"{count} {kind} on layer {shown(layer)}: places are taken of {types}")
    for (layer, kind), count in (+arcs).items():
        left_lines.append(f"arcs of {count} {kind} on layer {shown(layer)}: their ends are taken")
    if not points:
        others = ", ".join(sorted({shown(kind)[1:-1] for _, kind in left})[:4]) or "nothing"
        raise file.refuse(f"its model space has {others}, but none of {types}; export these")
    return points, left_lines


def _read(file: SourceFile) -> tuple[Sequence[DXFEntity], Any]:
    """The entities of the model space, and the unit of the header as it is written there."""
    from ezdxf import recover

    for beginning, what in _BINARY.items():
        if file.content.startswith(beginning):
            raise file.refuse(f"is a {what}; save it as DXF in text (ASCII)")
    # it says on standard error what it repairs
    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
    try:
        document, _ = recover.read(io.BytesIO(file.content))
        entities = list(islice(document.modelspace(), ENTITIES + 1))
        unit = document.header.get("$INSUNITS", 0)
    except Exception:  # a damaged file: its own errors, and ValueError, IndexError, KeyError …
        raise file.refuse("not a DXF file that can be read; save it as DXF anew") from None
    if len(entities) > ENTITIES:
        raise file.refuse(f"more than {ENTITIES} entities; export only what belongs to the scene")
    return entities, unit


def _units(code: Any, drawing: DrawingEntry) -> list[str]:
    """A line where the drawing's header says another unit than the map."""
    worth = _METRES.get(code) if isinstance(code, int) else None
    if worth is None or math.isclose(worth, drawing.metre, rel_tol=1e-5):
        return []
    return [
        f"unit of the header ($INSUNITS = {code}, {worth:g} m): "
        f"the map's is used, {drawing.metre:g} m"
    ]


def _places(entity: DXFEntity) -> Iterator[Place]:
    dxf = entity.dxf
    match entity.dxftype():
        case "POINT":
            found = [dxf.location]
        case "LINE":
            found = [dxf.start, dxf.end]
        case "LWPOLYLINE":
            found = list(entity.vertices_in_wcs())  # type: ignore[attr-defined]
        case "POLYLINE":
            found = list(entity.points_in_wcs())  # type: ignore[attr-defined]
        case "CIRCLE":
            found = [entity.ocs().to_wcs(dxf.center)]  # type: ignore[attr-defined]
        case _:
            ocs = entity.ocs()  # type: ignore[attr-defined]
            x, y, _ = ocs.to_wcs(dxf.insert)
            angle = math.radians(dxf.get("rotation", 0.0))
            ahead = ocs.to_wcs((math.cos(angle), math.sin(angle), 0.0))
            yield x, y, math.atan2(ahead[1], ahead[0])
            return
    for each in found:
        yield each[0], each[1], None
