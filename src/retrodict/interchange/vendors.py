"""Recorder files of vendors and suppliers, refused by name with the way to a CSV."""

from __future__ import annotations

from pathlib import Path

from retrodict.scene.errors import Problem, SceneError

_TABLE = "copy the table of its report into a CSV (time, speed; time, delta-v) and import that"
_VENDORS = {
    ".cdr": "a file of Bosch CDR",
    ".cdrx": "a file of Bosch CDR",
    ".edr": "an image of an event data recorder",
    ".hex": "a memory image of a recorder",
    ".hexdump": "a memory image of a recorder",
    ".bin": "a memory image of a recorder",
    ".pdf": "a report as PDF",
    ".acx": "a file of a recorder's own program",
    ".xls": "a workbook",
    ".xlsx": "a workbook",
    ".dwg": "a drawing of AutoCAD",
    ".dgn": "a drawing of MicroStation",
}
_WAYS = {
    ".pdf": "copy its tables into a CSV (time, speed; time, delta-v) and import that",
    ".xls": "save the sheet as CSV UTF-8 and import that",
    ".xlsx": "save the sheet as CSV UTF-8 and import that",
    ".dwg": "save it as DXF and import that",
    ".dgn": "save it as DXF and import that",
}


def refuse_vendor(path: str | Path) -> None:
    """Refuse a file in a format that only its vendor's program reads.

    Args:
        path: path of the file, whose suffix says the format.

    Raises:
        SceneError: the file has such a format; says how to get a CSV or DXF.
    """
    suffix = Path(path).suffix.lower()
    if suffix in _VENDORS:
        fix = f"{_VENDORS[suffix]}, which only its own program reads; {_WAYS.get(suffix, _TABLE)}"
        raise SceneError(str(path), [Problem("", "", fix)])
