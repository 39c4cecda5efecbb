"""Places by stations along a baseline and offsets from it, as in `10+25.50, 12.3 R`."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence

from retrodict.interchange.cells import NoNumber, number, station_in
from retrodict.interchange.column_map import SurveyEntry
from retrodict.scene import units
from retrodict.scene.units import QuantityError, read_quantity

_SIDES = {"l": 1.0, "lt": 1.0, "left": 1.0, "r": -1.0, "rt": -1.0, "right": -1.0}
_SIDE = re.compile(
    r"^(l|lt|left|r|rt|right)(?![a-z])\.?\s*|\s*(?<![a-z])(l|lt|left|r|rt|right)\.?$", re.I
)
_FEET = re.compile(r"([^'′’]+)['′’]")
_EXAMPLE = "12.3 ft"


def offset_in(cell: str, decimal: str, unit: float, positive: str | None) -> float:
    """The offset in a cell, positive to the left of the baseline, in the file's unit.

    Args:
        cell: offset with its side like "12.3 R", or with a sign where `positive` says its side.
        decimal: decimal sign, "." or ",".
        unit: length of the file's unit, m, for an offset with a unit of its own, like 8' 9" L.
        positive: "left" or "right": side of a positive number; None where each has a letter.

    Raises:
        NoNumber: the cell is no offset, or does not say its side.
    """
    text, side = cell.strip(), 0.0
    if found := _SIDE.search(text):
        side = _SIDES[(found[1] or found[2]).lower()]
        text = (text[: found.start()] + text[found.end() :]).strip()
    size = _length(text, decimal, unit)
    if side:
        if size < 0:
            raise NoNumber("has a side and a sign; write one of them")
        return side * size
    if size and positive is None:
        raise NoNumber('has no side, like "12.3 R"; or write baseline.positive in the map')
    return size if positive == "left" else -size


def place(cells: tuple[str, str], survey: SurveyEntry) -> tuple[float, float]:
    """The place of a point by its station and offset, in the file's axes and unit.

    Args:
        cells: cells of station and offset; without an offset the first has both, "10+25.50, 12.3 R".
        survey: the map's [survey] table, with its baseline.

    Raises:
        NoNumber: a cell cannot be read, or the station is beyond the ends of a baseline with bends.
    """
    baseline = survey.baseline
    assert baseline is not None
    unit, decimal = survey.metre, survey.decimal
    station, offset = cells
    if not offset:
        between = r"(?<=[0-9.])(?:,\s+|\s+)" if decimal == "," else r"(?<=[0-9.])(?:,\s*|\s+)"
        station, offset = [*re.split(between, station, maxsplit=1), ""][:2]
    along = station_in(station, decimal) - baseline.start
    left = offset_in(offset, decimal, unit, baseline.positive)
    line = [(x.value, y.value) for x, y in baseline.line]
    clockwise = survey.axes in _LEFT_HANDED
    x, y = point_along(line, along * unit, -left * unit if clockwise else left * unit)
    return x / unit, y / unit


def point_along(
    line: Sequence[tuple[float, float]], along: float, left: float
) -> tuple[float, float]:
    """The point so far along a line of straight pieces and to its left, m.

    Args:
        line: two corners or more. A line of two goes on beyond both.
        along: distance along the line from its first corner, m.
        left: distance to the left of it, seen along the line with y to the left of x, m.

    Raises:
        NoNumber: the line has bends, and ends before.
    """
    lengths = [math.dist(*pair) for pair in itertools.pairwise(line)]
    if len(line) > 2 and not -1e-6 <= along <= sum(lengths) + 1e-6:
        raise NoNumber("is beyond the baseline; add a corner to baseline.line in the map")
    piece = 0
    while piece < len(lengths) - 1 and along > lengths[piece]:
        along -= lengths[piece]
        piece += 1
    (x, y), (x_next, y_next) = line[piece : piece + 2]
    c, s = (x_next - x) / lengths[piece], (y_next - y) / lengths[piece]
    return x + c * along - s * left, y + s * along + c * left


# axes that are counted clockwise, as with x to the north and y to the east
_LEFT_HANDED = {("north", "east"), ("east", "south"), ("south", "west"), ("west", "north")}


def _length(text: str, decimal: str, unit: float) -> float:
    """A length in the file's unit; one with a unit of its own is converted."""
    try:
        return number(text, decimal)
    except NoNumber:
        if not text[:1].isdigit():
            raise
    if whole := _FEET.fullmatch(text):
        text = f"{whole[1]} ft"
    try:
        return read_quantity(text, units.LENGTH, _EXAMPLE).value / unit
    except QuantityError as wrong:
        raise NoNumber(f"is no length: {wrong.fix}") from None
