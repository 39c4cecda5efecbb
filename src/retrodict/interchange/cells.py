"""Numbers and stations in the cells of a table."""

from __future__ import annotations

import math
import re

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:[.][0-9]*)?|[.][0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_STATION = re.compile(r"(?:sta(?:tion)?\.?\s*)?([+-]?)([0-9]{1,6})\+([0-9]+)([.,][0-9]*)?", re.I)
_STEPS = {2: 100.0, 3: 1000.0}  # a full station, by the digits that follow its plus


class NoNumber(ValueError):
    """A cell that is no number; says why."""


def number(cell: str, decimal: str) -> float:
    """The number in a cell.

    Args:
        cell: text of the cell.
        decimal: decimal sign, "." or ",".

    Raises:
        NoNumber: the cell is no number.
    """
    if not cell:
        raise NoNumber("is empty")
    if cell[0] in "=@":
        raise NoNumber("is a formula; export values")
    plain = cell.replace("\N{MINUS SIGN}", "-")
    if decimal == ",":
        if "." in plain:
            raise NoNumber('has a point, and the map says decimal = ","')
        plain = plain.replace(",", ".", 1)
    if not _NUMBER.fullmatch(plain):
        comma = "," in plain and decimal == "."
        hint = '; if the comma is its decimal sign, write decimal = ","' if comma else ""
        raise NoNumber(f"is not a number{hint}")
    value = float(plain)
    if not math.isfinite(value):
        raise NoNumber("is too large")
    return value


def station_in(cell: str, decimal: str) -> float:
    """The station in a cell, in units of length from station 0.

    Args:
        cell: station like "10+25.50" (of 100 units), "1+025.5" (of 1000), or a number.
        decimal: decimal sign, "." or ",".

    Raises:
        NoNumber: the cell is no station.
    """
    if (found := _STATION.fullmatch(cell.strip())) is None:
        return number(cell, decimal)
    sign, full, rest, part = found.groups()
    if (step := _STEPS.get(len(rest))) is None:
        raise NoNumber("is no station; two digits follow its plus (hundreds), or three (thousands)")
    value = int(full) * step + number(rest + (part or ""), decimal)
    return -value if sign == "-" else value
