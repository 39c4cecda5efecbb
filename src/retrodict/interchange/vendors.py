"""Files of recorders, instruments and programs, refused by name with the way to a CSV."""

from __future__ import annotations

import re
from pathlib import Path

from retrodict.interchange.column_map import MapEntry
from retrodict.interchange.source_file import SourceFile
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
_POINTS = (
    "in the program of the instrument or of the office, export the coordinates of its points as CSV "
    "(point, easting, northing, code), LandXML or DXF and import that"
)
_GPS = "save its points as CSV (point, longitude, latitude) and import that"
_INSTRUMENTS = {
    ".gsi": "a file of a Leica instrument (GSI)",
    ".sdr": "a file of a Sokkia instrument (SDR)",
    ".rw5": "raw data of Carlson SurvCE (RW5)",
    ".cr5": "coordinates of Carlson SurvCE in binary (CR5)",
    ".crd": "coordinates of Carlson in binary (CRD)",
    ".job": "a job of a field instrument",
    ".jxl": "a job of Trimble Access (JobXML)",
    ".dc": "a file of a Trimble instrument (DC)",
    ".fbk": "a field book of Autodesk (FBK)",
    ".gts": "a file of a Topcon instrument (GTS)",
    ".kml": "places of Google Earth (KML)",
    ".kmz": "places of Google Earth (KMZ)",
    ".gpx": "a track of a GPS receiver (GPX)",
    ".shp": "a shapefile",
}
# how the same files begin, which are often called .txt
_BEGINNINGS = {
    ".gsi": r"\*?[0-9]{2}[0-9.]{4}[+-][0-9A-Za-z .]{8}",
    ".sdr": r"00NMSDR",
    ".rw5": r"JB,NM",
    ".jxl": r"(?s:.{0,1000})<JOBFile\b",
    ".kml": r"(?s:.{0,1000})<kml\b",
    ".gpx": r"(?s:.{0,1000})<gpx\b",
}
_LANDXML = re.compile(rb"(?:\xef\xbb\xbf)?\s*<(?s:.{0,1000})<?LandXML\b")


def refuse_vendor(path: str | Path) -> None:
    """Refuse a file in a format that only its vendor's program reads.

    Args:
        path: path of the file, whose suffix says the format.

    Raises:
        SceneError: the file has such a format; says how to get a CSV or DXF.
    """
    suffix = Path(path).suffix.lower()
    if suffix in _INSTRUMENTS:
        raise SceneError(str(path), [Problem("", "", _of_instrument(suffix))])
    if suffix in _VENDORS:
        fix = f"{_VENDORS[suffix]}, which only its own program reads; {_WAYS.get(suffix, _TABLE)}"
        raise SceneError(str(path), [Problem("", "", fix)])


def refuse_by_content(file: SourceFile, entry: MapEntry) -> None:
    """Refuse a file by how it begins: of an instrument, or LandXML where the map reads a table.

    Args:
        file: file to import.
        entry: the map.

    Raises:
        SceneError: the file begins as such a file does; says what to do.
    """
    if entry.drawing is not None:
        return
    if entry.landxml is None and _LANDXML.match(file.content):
        raise file.refuse("is LandXML; write its table in the map as [landxml], without columns")
    beginning = file.content[:2000].decode("latin-1").removeprefix("\xef\xbb\xbf").lstrip()
    for suffix, pattern in _BEGINNINGS.items():
        if re.match(pattern, beginning):
            raise file.refuse(_of_instrument(suffix))


def _of_instrument(suffix: str) -> str:
    way = _GPS if suffix in (".kml", ".kmz", ".gpx") else _POINTS
    return f"{_INSTRUMENTS[suffix]}, which is not read; {way}"
