"""Coordinate points (CgPoint) of LandXML."""

from __future__ import annotations

import math
from collections import Counter
from xml.etree import ElementTree

from retrodict.interchange.cells import NoNumber, number
from retrodict.interchange.column_map import LandXmlEntry
from retrodict.interchange.points import Point
from retrodict.interchange.source_file import SourceFile
from retrodict.scene.errors import shown

_POINTS = 100_000
# linearUnit of its Units: worth in m, and the unit to write in a map
_UNITS = {
    "millimeter": (0.001, "mm"),
    "centimeter": (0.01, "cm"),
    "meter": (1.0, "m"),
    "kilometer": (1000.0, "km"),
    "inch": (0.0254, "in"),
    "foot": (0.3048, "ft"),
    "USSurveyFoot": (1200 / 3937, "ftUS"),
    "mile": (1609.344, "mi"),
}
_OTHERS = ("P", "RawObservation", "ReducedObservation", "Parcel", "Alignment")


class _Tree(ElementTree.TreeBuilder):
    """A tree of a file without a document type, in which alone entities can be declared."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise ValueError("document type")


def landxml_points(file: SourceFile, entry: LandXmlEntry) -> tuple[list[Point], list[str]]:
    """The coordinate points of a LandXML file; x is their easting, y their northing.

    Args:
        file: LandXML file.
        entry: the map's [landxml] table.

    Returns:
        Points by their names, their codes or descriptions being their groups, those that cannot be used
        with the reason; and lines on what is left out.

    Raises:
        SceneError: the file is not LandXML, has another unit than the map, or too many points.
    """
    root = _root(file)
    _check_unit(file, root, entry)
    points: list[Point] = []
    left: Counter[str] = Counter()
    for element in root.iter():
        kind = _kind(element)
        if kind in _OTHERS:
            left[kind] += 1
        if kind != "CgPoint" or (element.get("pntRef") and not (element.text or "").strip()):
            continue
        if len(points) == _POINTS:
            raise file.refuse(f"more than {_POINTS} points; export only what belongs to the scene")
        points.append(_point(element, len(points) + 1))
    if not points:
        raise file.refuse("it has no CgPoint; export the coordinates of its points")
    return points, [f"{n} {kind}: places are taken of CgPoint" for kind, n in left.items()]


def _root(file: SourceFile) -> ElementTree.Element:
    parser = ElementTree.XMLParser(target=_Tree())
    try:
        parser.feed(file.content)
        root = parser.close()
    except ElementTree.ParseError as error:
        line, _ = error.position
        raise file.refuse("not XML that can be read; export it anew", f"line {line}") from None
    except (ValueError, LookupError):  # a document type, or a character set that nobody knows
        raise file.refuse("its document type or character set is not LandXML's") from None
    if not isinstance(root, ElementTree.Element) or _kind(root) != "LandXML":
        raise file.refuse("is XML, but not LandXML; export its points as LandXML or CSV")
    return root


def _check_unit(file: SourceFile, root: ElementTree.Element, entry: LandXmlEntry) -> None:
    """Refuse a map whose unit is not that of the file."""
    for element in root.iter():
        if _kind(element) not in ("Metric", "Imperial"):
            continue
        unit = element.get("linearUnit", "")
        worth, name = _UNITS.get(unit, (None, ""))
        if worth is not None and not math.isclose(worth, entry.metre, rel_tol=1e-7):
            fix = f'its unit is not that of the map; write unit = "{name}" in [landxml]'
            raise file.refuse(fix, "linearUnit", shown(unit))
        return


def _point(element: ElementTree.Element, count: int) -> Point:
    fault, coordinates = "", [0.0, 0.0]
    cells = (element.text or "").split()[:3]
    try:
        coordinates = [number(cell, ".") for cell in cells]
    except NoNumber as error:
        fault = f"{shown(' '.join(cells))} {error}"
    if len(cells) < 2:
        fault, coordinates = "has no northing and easting", [0.0, 0.0]
    return Point(
        name=(element.get("name") or element.get("oID") or "").strip(),
        group=(element.get("code") or element.get("desc") or "").strip(),
        x=coordinates[1],
        y=coordinates[0],
        where=f"CgPoint {count}",
        fault=fault,
    )


def _kind(element: ElementTree.Element) -> str:
    """The name of an element without its namespace, which differs by version."""
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""
