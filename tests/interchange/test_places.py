"""Places by latitude and longitude, and by stations and offsets along a baseline."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

from retrodict.interchange.cells import NoNumber, station_in
from retrodict.interchange.geodetic import degrees_in
from retrodict.interchange.stations import offset_in, point_along
from tests.interchange.test_survey import imported, refusal

LATITUDE, LONGITUDE = 42.33141, -83.04575
EAST, NORTH = 30e-5, 20e-5  # degrees from there


def _metres() -> tuple[float, float]:
    """The same from there in metres, by the radii of curvature of WGS 84."""
    a, e2 = 6378137.0, 0.00669437999014
    root = math.sqrt(1 - e2 * math.sin(math.radians(LATITUDE)) ** 2)
    east = math.radians(EAST) * a / root * math.cos(math.radians(LATITUDE))
    return east, math.radians(NORTH) * a * (1 - e2) / root**3


GEOGRAPHIC = """
[survey]
unit = "deg"
precision = "0.05 m"
axes = ["north", "east"]
origin = ["42.33141 deg", "-83.04575 deg"]
columns = { id = "Name", x = "Latitude", y = "Longitude" }
[impact_point]
point = 7
uncertainty = "0.2 m"
"""
POINTS = (
    "Name,Latitude,Longitude\n"
    f"0,{LATITUDE},{LONGITUDE}\n7,{LATITUDE + NORTH:.7f},{LONGITUDE + EAST:.7f}\n"
)
SEXAGESIMAL = "Name,Latitude,Longitude\n7,42°19'53.796\" N,83 02 43.62 W\n"
WESTWARD = POINTS.replace("-83", "83")


@pytest.mark.parametrize(
    ("content", "map_text"),
    [
        (POINTS, GEOGRAPHIC),
        (POINTS, GEOGRAPHIC.replace('["42.33141 deg", "-83.04575 deg"]', '"0"')),
        (SEXAGESIMAL, GEOGRAPHIC),
        (
            WESTWARD,
            GEOGRAPHIC.replace('"east"]', '"west"]').replace("-83.04575", "83.04575"),
        ),
    ],
)
def test_degrees_are_projected_about_the_origin(
    tmp_path: Path, content: str, map_text: str
) -> None:
    pytest.importorskip("pyproj")
    contact = imported(tmp_path, content, map_text).scene.contact
    assert (contact.x.value, contact.y.value) == pytest.approx(_metres(), abs=2e-3)


def test_without_its_library_degrees_are_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyproj", None)
    said = refusal(tmp_path, POINTS, GEOGRAPHIC)
    assert "degrees are projected by the package pyproj: run pip install pyproj" in said
    assert "\n" not in said


IN_METRES = (
    GEOGRAPHIC.replace('"deg"', '"m"')
    .replace('["42.33141 deg", "-83.04575 deg"]', '"7"')
    .replace("Latitude", "lat")
    .replace("Longitude", "lon")
)
SHORT = POINTS.replace("Latitude", "lat").replace("Longitude", "lon")


@pytest.mark.parametrize(
    ("content", "map_text", "said"),
    [
        (SHORT, IN_METRES, "a latitude is in degrees, and no length"),
        (
            POINTS,
            IN_METRES.replace("lat", "Latitude").replace("lon", "Longitude"),
            'write unit = "deg" and an origin in the map',
        ),
        (SHORT.replace("lat", "X").replace("lon", "Y"), IN_METRES.replace("lat", "X").replace(
            "lon", "Y"), "all its points lie within 0.0003 m; if these are degrees"),
        (
            POINTS,
            GEOGRAPHIC.replace('["north", "east"]', '["east", "north"]').replace(
                '["42.33141 deg", "-83.04575 deg"]', '"7"'
            ),
            "column x: is a latitude, and axes says east",
        ),
        (POINTS, GEOGRAPHIC.replace('origin = ["42.33141 deg", "-83.04575 deg"]\n', ""),
            "survey.origin: degrees are projected about an origin"),
        (POINTS, GEOGRAPHIC.replace('"42.33141 deg"', '"42.33141 m"'), "does not measure an angle"),
        (POINTS.replace("7,42", "7,142"), GEOGRAPHIC, "is more than 90 degrees"),
        (SEXAGESIMAL.replace("W", "N"), GEOGRAPHIC, "is not a coordinate to the east"),
        (SEXAGESIMAL.replace("83 02", "-83 02"), GEOGRAPHIC, "has a sign and a letter"),
        (SEXAGESIMAL.replace("02 43", "62 43"), GEOGRAPHIC, "is not degrees, minutes and seconds"),
    ],
)  # fmt: skip
def test_degrees_that_are_no_place_are_refused(
    tmp_path: Path, content: str, map_text: str, said: str
) -> None:
    if 'unit = "deg"' in map_text:
        pytest.importorskip("pyproj")
    assert said in refusal(tmp_path, content, map_text)


def test_lateral_and_longitudinal_distances_are_no_degrees(tmp_path: Path) -> None:
    content = "Name,Long,Lat\n0,1.5,2.5\n7,3.25,1.75\n"
    keys = IN_METRES.replace('origin = "7"\n', "").replace('x = "lat"', 'x = "Long"')
    keys = keys.replace('y = "lon"', 'y = "Lat"').replace('"north", "east"', '"east", "north"')
    assert imported(tmp_path, content, keys).scene.contact.x.value == 3.25


@pytest.mark.parametrize(
    ("cell", "axis", "degrees"),
    [
        ("42°30'36\" N", "north", 42.51),
        ("N 42 30 36", "north", 42.51),
        ("42:30.6", "north", 42.51),
        ("42.51 S", "north", -42.51),
        ("-0 30", "east", -0.5),
        ("83.5W", "west", 83.5),
        ("83.5E", "west", -83.5),
    ],
)
def test_degrees_as_people_write_them(cell: str, axis: str, degrees: float) -> None:
    assert degrees_in(cell, ".", axis) == pytest.approx(degrees, abs=1e-12)


STATIONS = """
[survey]
unit = "ft"
precision = "0.1 ft"
axes = ["east", "north"]
columns = { id = "Pt", station = "Station", offset = "Offset" }
[survey.baseline]
start = "10+00"
line = [["0 ft", "0 ft"], ["100 ft", "0 ft"], ["100 ft", "60 ft"]]
[impact_point]
point = 7
uncertainty = "0.2 m"
"""
ONE_COLUMN = STATIONS.replace(', offset = "Offset"', "")


@pytest.mark.parametrize(
    ("content", "map_text", "place"),
    [
        ("Pt,Station,Offset\n7,10+25.50,12.3 R\n", STATIONS, (25.5, -12.3)),
        ("Pt,Station,Offset\n7,Sta. 10+25.50,LT 8' 9\"\n", STATIONS, (25.5, 8.75)),
        ('Pt,Station,Offset\n7,11+20,"12.3 R"\n', STATIONS, (112.3, 20)),
        ('Pt,Station\n7,"10+25.50, 12.3 R"\n', ONE_COLUMN, (25.5, -12.3)),
        ("Pt;Station\n7;10+25.50 12.3' L\n", ONE_COLUMN, (25.5, 12.3)),
        ("Pt;Station;Offset\n7;1025,5;0\n", STATIONS.replace('"ft"\n', '"ft"\ndecimal = ","\n', 1),
            (25.5, 0)),
        ("Pt,Station,Offset\n7,10+25.50,-12.3\n",
            STATIONS.replace("start", 'positive = "right"\nstart'), (25.5, 12.3)),
        ("Pt,Station,Offset\n7,10+25.50,12.3 R\n", STATIONS.replace('["east", "north"]',
            '["north", "east"]'), (12.3, 25.5)),
        # a straight line goes on beyond its ends
        ("Pt,Station,Offset\n7,9+75.00,1 L\n", STATIONS.replace(', ["100 ft", "60 ft"]]', "]"),
            (-25, 1)),
    ],
)  # fmt: skip
def test_stations_and_offsets_along_a_baseline(
    tmp_path: Path, content: str, map_text: str, place: tuple[float, float]
) -> None:
    contact = imported(tmp_path, content, map_text).scene.contact
    assert (contact.x.value / 0.3048, contact.y.value / 0.3048) == pytest.approx(place, abs=1e-3)


@pytest.mark.parametrize(
    ("content", "map_text", "said"),
    [
        ("Pt,Station,Offset\n7,10+25.50,12.3\n", STATIONS, 'has no side, like "12.3 R"'),
        ("Pt,Station,Offset\n7,10+25.50,-12.3 R\n", STATIONS, "has a side and a sign"),
        ("Pt,Station,Offset\n7,10+5,12.3 R\n", STATIONS, "two digits follow its plus"),
        ("Pt,Station,Offset\n7,12+00,1 R\n", STATIONS, "is beyond the baseline"),
        ("Pt,Station,Offset\n7,10+25,curb\n", STATIONS, "is not a number"),
        ("Pt,Station,Offset\n7,10+25,1 R\n", STATIONS.split("[survey.baseline]")[0],
            "survey.columns.station = \"Station\": stations count along a line"),
        ("Pt,Station,Offset\n7,10+25,1 R\n", STATIONS.replace('"10+00"', '"begin"'),
            'survey.baseline.start = "begin": is not a number; write a station'),
        ("Pt,Station,Offset\n7,10+25,1 R\n", STATIONS.replace('["100 ft", "0 ft"]', '["0 m", "0 m"]'),
            "two corners that follow each other are one place"),
        ("Pt,Station,Offset\n7,10+25,1 R\n", STATIONS.replace('station = "Station", ', ""),
            'survey.columns.x: missing; write x = "Easting", or station'),
        ("Pt,Station,Offset\n7,10+25,1 R\n", STATIONS.replace('station =', 'x = "Pt", station ='),
            "a place twice"),
    ],
)  # fmt: skip
def test_stations_that_are_no_place_are_refused(
    tmp_path: Path, content: str, map_text: str, said: str
) -> None:
    assert said in refusal(tmp_path, content, map_text)


def test_a_station_of_metres_has_three_digits_after_its_plus() -> None:
    assert station_in("1+025.5", ".") == 1025.5
    assert station_in("-0+10", ".") == -10
    with pytest.raises(NoNumber):
        station_in("1+0255", ".")


@pytest.mark.parametrize(
    "cell", ["12.3R", "R12.3", "12.3 Rt.", "right 12.3", "RT. 12.3", "r 12.3 ft"]
)
def test_sides_as_people_write_them(cell: str) -> None:
    assert offset_in(cell, ".", 0.3048, None) == pytest.approx(-12.3)


def test_a_place_beside_a_bend_is_at_its_piece() -> None:
    line = [(0.0, 0.0), (3.0, 4.0), (3.0, 14.0)]
    assert point_along(line, 2.5, 1.0) == pytest.approx((1.5 - 0.8, 2 + 0.6))
    assert point_along(line, 7.0, -1.0) == pytest.approx((4.0, 6.0))
    for end in (0.0, 15.0):
        assert point_along(line, end, 0.0) == pytest.approx(line[0] if end == 0 else line[-1])
