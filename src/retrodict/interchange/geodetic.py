"""Latitudes and longitudes, projected to metres about the origin of a scene."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace

from retrodict.interchange.cells import NoNumber, number
from retrodict.interchange.column_map import SurveyEntry
from retrodict.interchange.points import Point, named
from retrodict.interchange.source_file import SourceFile
from retrodict.scene.records import Measured

_BETWEEN = re.compile(r"\s*[°'′’\"″”\s:]+\s*")
_HEADING = re.compile(r"(latitude|longitude)\b")
_SHORT = {"lat": "latitude", "lon": "longitude", "lng": "longitude", "long": "longitude"}
_SPOT = 0.05  # m: no survey is as small


def degrees_in(cell: str, decimal: str, axis: str) -> float:
    """The latitude or longitude in a cell, in degrees towards an axis.

    Args:
        cell: degrees, or degrees, minutes and seconds, with a sign or a letter: `42°19'53.2" N`.
        decimal: decimal sign, "." or ",".
        axis: direction in which the coordinate grows: "north", "south", "east" or "west".

    Raises:
        NoNumber: the cell is no angle, or one along the other axis.
    """
    text, sign = cell.replace("\N{MINUS SIGN}", "-").strip(), 0.0
    for letter in (text[:1].upper(), text[-1:].upper()):
        if letter and letter in "NSEW":
            if (letter in "NS") != (axis in ("north", "south")):
                raise NoNumber(f"is not a coordinate to the {axis}; correct axes or columns")
            sign = 1.0 if letter == axis[0].upper() else -1.0
            text = text.strip("NSEWnsew ")
            break
    parts = [number(part, decimal) for part in _BETWEEN.split(text.rstrip("°'′’\"″” "))]
    if len(parts) > 3 or any(not 0 <= part < 60 for part in parts[1:]):
        raise NoNumber("is not degrees, minutes and seconds")
    size = sum(abs(part) / 60**i for i, part in enumerate(parts))
    limit = 90 if axis in ("north", "south") else 180
    if size > limit:
        raise NoNumber(f"is more than {limit} degrees")
    if sign and text[0] in "+-":
        raise NoNumber("has a sign and a letter; write one of them")
    return (sign or 1.0) * (-size if text.startswith("-") else size)


def projected(file: SourceFile, points: Sequence[Point], survey: SurveyEntry) -> list[Point]:
    """Points of a survey in degrees, in metres from its origin along the same axes.

    The projection is azimuthal equidistant about the origin, on the ellipsoid WGS 84.

    Args:
        file: file of the points, for messages.
        points: points whose x and y are degrees.
        survey: the map's [survey] table, with its origin.

    Raises:
        SceneError: pyproj is not installed.
    """
    try:
        from pyproj import Proj
    except ImportError:
        fix = (
            "degrees are projected by the package pyproj: run pip install pyproj, or export the "
            "points in metres or feet of a grid"
        )
        raise file.refuse(fix) from None
    if isinstance(survey.origin, str):
        there = [point for point in named(points).get(survey.origin, []) if not point.fault]
        if not there:  # which the caller says, as of any point
            return list(points)
        origin = (there[0].x, there[0].y)
    else:
        assert survey.origin is not None
        origin = (_degrees(survey.origin[0]), _degrees(survey.origin[1]))
    east = 0 if survey.axes[0] in ("east", "west") else 1
    signs = [1.0 if axis in ("east", "north") else -1.0 for axis in survey.axes]
    about = [sign * each for sign, each in zip(signs, origin, strict=True)]
    project = Proj(proj="aeqd", lon_0=about[east], lat_0=about[1 - east], datum="WGS84", units="m")
    found = []
    for point in points:
        place = [sign * each for sign, each in zip(signs, (point.x, point.y), strict=True)]
        e, n = (0.0, 0.0) if point.fault else project(place[east], place[1 - east])
        x, y = (e, n) if east == 0 else (n, e)
        fault = point.fault or ("" if math.isfinite(x + y) else "cannot be projected")
        found.append(replace(point, x=signs[0] * x, y=signs[1] * y, fault=fault))
    return found


def refuse_degrees(
    file: SourceFile, points: Sequence[Point], survey: SurveyEntry, headings: Sequence[str]
) -> None:
    """Refuse degrees that a map takes for lengths, and latitudes that it takes for longitudes.

    Args:
        file: file of the points.
        points: points of the file, in its own coordinates.
        survey: the map's [survey] table.
        headings: headings of the columns x and y; empty where there is no header.

    Raises:
        SceneError: the columns are of degrees, or exchanged; says what to write.
    """
    way = 'write unit = "deg" and an origin in the map, or export the points in metres'
    sound = [(point.x, point.y) for point in points if not point.fault]
    # short names are of lateral and longitudinal distances too, which have few decimals
    small = [each for place in sound for each in place if abs(each) <= 180]
    fine = any(abs(1e4 * each - round(1e4 * each)) > 1e-4 for each in small)
    names = [_name(heading, fine) for heading in headings]
    for key, name, axis in zip(("x", "y"), names, survey.axes, strict=True):
        if name and survey.unit != "deg":
            raise file.refuse(f"a {name} is in degrees, and no length; {way}", f"column {key}")
        if name and (name == "latitude") != (axis in ("north", "south")):
            fix = f"is a {name}, and axes says {axis}; correct axes in the map"
            raise file.refuse(fix, f"column {key}")
    if survey.unit == "deg" or len(set(sound)) < 2:
        return
    xs, ys = zip(*sound, strict=True)
    size = max(max(xs) - min(xs), max(ys) - min(ys)) * survey.metre
    far = min(max(abs(x), abs(y)) for x, y in sound)
    if size < _SPOT and 1 < far <= 180:
        fix = f"all its points lie within {size:.2g} m; if these are degrees, {way}"
        raise file.refuse(fix)


def _name(heading: str, fine: bool) -> str:
    """Which of latitude and longitude a heading names; empty for neither."""
    text = heading.strip().lower()
    found = _HEADING.match(text)
    return found[1] if found else _SHORT.get(text.rstrip("."), "") if fine else ""


def _degrees(angle: Measured) -> float:
    return math.degrees(angle.value)
