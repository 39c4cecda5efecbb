"""Lines of a plan (DXF) that are drawn under a scene; blocks are not expanded."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np

from retrodict.explore.board.state import Place

_TYPES = {"LINE", "LWPOLYLINE", "POLYLINE", "CIRCLE", "ARC", "ELLIPSE", "SPLINE"}
_ENTITIES, _PLACES = 5_000, 40_000  # of all lines
_FARTHEST = 1000.0  # m from the origin of the scene
_PARTS = 8  # straight pieces of a curve, at least


def plan_lines(
    content: bytes, drawn: Sequence[Place], placed: Sequence[Place]
) -> tuple[tuple[Place, ...], ...]:
    """The lines of a plan in the scene's frame.

    Args:
        content: bytes of the DXF file.
        drawn: points of the file, in its own coordinates.
        placed: the same points in the scene's frame, m, as its map places them.

    Returns:
        Places along each line, m; nothing where the points do not show the frame, such as points along
        one line. What is damaged is left out.
    """
    frame = _frame(drawn, placed)
    if frame is None:
        return ()
    found: list[tuple[Place, ...]] = []
    left = _PLACES
    for line in _lines(content):
        places = np.column_stack([line, np.ones(len(line))]) @ frame
        if len(places) < 2 or not (np.abs(places) < _FARTHEST).all():
            continue
        left -= len(places)
        if left < 0:
            break
        found.append(tuple((round(float(x), 3), round(float(y), 3)) for x, y in places))
    return tuple(found)


def _frame(drawn: Sequence[Place], placed: Sequence[Place]) -> np.ndarray | None:
    """What takes coordinates of the file to the scene, shape (3, 2); None where too little shows it."""
    if len(drawn) != len(placed) or len(drawn) < 3:
        return None
    own = np.column_stack([np.asarray(drawn, float), np.ones(len(drawn))])
    middle = own[:, :2].mean(axis=0)
    own[:, :2] -= middle  # large coordinates would spoil the rank
    frame, _, rank, _ = np.linalg.lstsq(own, np.asarray(placed, float), rcond=1e-9)
    if rank < 3:
        return None
    frame[2] -= middle @ frame[:2]
    return frame


def _lines(content: bytes) -> Iterator[np.ndarray]:
    """Places along the lines of the model space, in the file's coordinates, shape (any, 2)."""
    from ezdxf import path, recover

    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
    document, _ = recover.read(io.BytesIO(content))
    entities: Any = (each for each in document.modelspace() if each.dxftype() in _TYPES)
    for entity in islice(entities, _ENTITIES):
        try:
            made = path.make_path(entity)
            size = made.control_vertices()
            reach = max(abs(v.x - w.x) + abs(v.y - w.y) for v in size[:1] for w in size) or 1.0
            vertices = list(islice(made.flattening(distance=reach / 100, segments=_PARTS), _PLACES))
        except Exception:  # what a damaged entity lacks is raised in as many ways
            continue
        if vertices:
            yield np.array([(each.x, each.y) for each in vertices])
