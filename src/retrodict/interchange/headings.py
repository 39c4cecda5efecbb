"""The units in a column's heading, such as `Speed (MPH [km/h])`, and the number of a cell in one."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from retrodict.interchange.cells import NoNumber, number
from retrodict.scene.units import Dimension, QuantityError, factor

_BRACKET = re.compile(r"[(\[]([^()\[\]]+)[)\]]?\s*[)\]]?\s*$")
_BEFORE = re.compile(r"([^\s(\[,;:]+)\s*$")
_BETWEEN = re.compile(r"\s+/\s+|\s+or\s+|[,;]\s*")
_TWO = re.compile(r"([^\s()\[\]/]+)\s*(?:[(\[]\s*([^\s()\[\]]+)\s*[)\]]|/\s*([^\s()\[\]]+))")
# what recorders' reports print where there is no value
_NO_VALUE = {
    "sna", "invalid", "not valid", "data invalid", "data not valid", "n/a", "na", "n.a.", "-", "--",
    "---", "–", "—", "*", "**", "***", "null", "none", "no data", "unknown", "not available",
    "data not available", "signal not available", "not recorded", "not supported", "error", "fault",
}  # fmt: skip


def units_in(heading: str, dimension: Dimension) -> list[tuple[str, float]]:
    """The units at the end of a heading, with their worth in SI units.

    Args:
        heading: text of the heading, such as "Speed (km/h)" or "Speed (MPH [km/h])".
        dimension: dimension of the column.

    Returns:
        None, one or two units, in the order of the heading.
    """
    if (last := _BRACKET.search(heading)) is None:
        return []
    within = [_known(part, dimension) for part in _BETWEEN.split(last[1].strip())]
    if len(within) == 2 and all(within):
        return [unit for unit in within if unit]
    if (second := _known(last[1], dimension)) is None:
        return []
    before = heading[: last.start()].rstrip().rstrip(")]")  # MPH [km/h], and (MPH) [km/h]
    first = _known(found[1], dimension) if (found := _BEFORE.search(before)) else None
    return [first, second] if first else [second]


def number_in(cell: str, decimal: str, units: Sequence[float], unit: float) -> float:
    """The number of a cell in one of the units of its heading.

    Args:
        cell: text of the cell: a number, or a number for each unit, like "22 [35]".
        decimal: decimal sign, "." or ",".
        units: worth of the units of the heading in SI units, none to two.
        unit: worth of the wanted unit in SI units.

    Raises:
        NoNumber: the cell has no number, or two that are not one value in both units.
    """
    if (two := _TWO.fullmatch(cell)) is None:
        return number(cell, decimal)
    numbers = [number(text, decimal) for text in (two[1], two[2] or two[3])]
    if len(units) != 2:
        raise NoNumber("has two numbers, and its heading not two units")
    worth = [value * each for value, each in zip(numbers, units, strict=True)]
    # each was rounded
    steps = [
        each * 10.0 ** -_decimals(text, decimal)
        for text, each in zip((two[1], two[2] or two[3]), units, strict=True)
    ]
    if abs(worth[0] - worth[1]) > sum(steps):
        raise NoNumber("has two numbers that are not one value in the two units of its heading")
    same = [math.isclose(each, unit, rel_tol=1e-6) for each in units]
    return numbers[same.index(True)]


def is_no_value(cell: str) -> bool:
    """Whether a cell says that nothing was recorded, like "SNA" or "Invalid"."""
    two = _TWO.fullmatch(cell)
    texts = [two[1], two[2] or two[3]] if two and cell.casefold() not in _NO_VALUE else [cell]
    return all(" ".join(text.split()).casefold().strip(".()[]") in _NO_VALUE for text in texts)


def _known(unit: str, dimension: Dimension) -> tuple[str, float] | None:
    try:
        return unit.strip(), factor(unit, dimension)
    except QuantityError:
        return None


def _decimals(text: str, decimal: str) -> int:
    return len(text.partition(decimal)[2])
