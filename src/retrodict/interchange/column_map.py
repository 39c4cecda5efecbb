"""What a map file says: how to read another program's file, and what of it a scene takes."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from retrodict.interchange.cells import NoNumber, station_in
from retrodict.interchange.map_tables import (
    Column,
    Name,
    TableEntry,
    all_alike,
    point_name,
    unit_factor,
)
from retrodict.interchange.points import SPOTS, Angles, Compass
from retrodict.interchange.recorder_map import RecorderEntry
from retrodict.scene import units
from retrodict.scene.entries.impact import SurfaceName
from retrodict.scene.entries.table import IS_AN_SD, Table
from retrodict.scene.entries.vehicle import Direction, RestHeading
from retrodict.scene.errors import shown
from retrodict.scene.explain import entries_of
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.load import read_text, toml_of
from retrodict.scene.outlines import MOST_CORNERS
from retrodict.scene.records import Measured


def load_map(path: str | Path) -> MapEntry:
    """A map from a map file.

    Args:
        path: a TOML file; its keys are described in docs/import.md.

    Returns:
        The map, checked.

    Raises:
        SceneError: the file cannot be read, or something in it is wrong.
    """
    return entries_of(MapEntry, toml_of(read_text(path, "map"), str(path)), str(path))


def _length_unit(raw: object) -> float:
    return unit_factor(raw, units.LENGTH)


def _angle_unit(raw: object) -> float:
    return unit_factor(raw, units.ANGLE)


Precision = Annotated[
    Measured, Kind(units.LENGTH, 0.0001, 50, "0.02 m", uncertainty="refused", advice=IS_AN_SD)
]
Uncertainty = Annotated[
    Measured, Kind(units.LENGTH, 0, 50, "0.15 m", uncertainty="refused", advice=IS_AN_SD)
]
_Far = Annotated[Measured, Kind(units.LENGTH, -1e8, 1e8, "500000 m", uncertainty="refused")]
_Offset = Annotated[Measured, Kind(units.LENGTH, -30, 30, "2.1 m", uncertainty="refused")]


_DEGREES = Kind(units.ANGLE, -180, 180, "42.33141 deg", uncertainty="refused")


def _are_degrees(unit: object) -> bool:
    words = ("deg", "degree", "degrees", "decimal degrees", "°")
    return isinstance(unit, str) and unit.strip().lower() in words


def _length_or_degrees(raw: object) -> object:
    return "deg" if _are_degrees(raw) else _length_unit(raw)


def _origin(raw: object) -> object:
    if isinstance(raw, list):
        return raw
    return point_name(raw)


class FrameEntry(Table):
    """What the table of a file of points says of coordinates."""

    unit: Annotated[float | Literal["deg"], BeforeValidator(_length_unit)] = Field(
        examples=['"m" (or "ft", "in")']
    )
    precision: Precision
    axes: tuple[Compass, Compass] = Field(examples=['["east", "north"] (where x and y point)'])
    angles: Angles | None = Field(
        None, examples=['"counter-clockwise from east" or "clockwise from north"']
    )
    origin: Annotated[str | tuple[_Far, _Far] | None, BeforeValidator(_origin)] = Field(
        None, examples=['"a point" or ["500000 m", "4200000 m"]']
    )
    x_axis: Direction | None = None

    @model_validator(mode="after")
    def _axes_cross(self) -> FrameEntry:
        east_west = {"east", "west"}
        if (self.axes[0] in east_west) == (self.axes[1] in east_west):
            raise fault("one axis points east or west, the other north or south", "axes")
        if self.x_axis and self.angles is None:
            raise fault(f"an angle is written: {_ANGLES}", "angles")
        return self

    @property
    def metre(self) -> float:
        """Length of the unit in which points are read, m: degrees are projected to metres."""
        return self.unit if isinstance(self.unit, float) else 1.0


_ANGLES = 'write "counter-clockwise from east" or "clockwise from north"'


class SurveyColumns(Table):
    """`[survey.columns]`: by name in the header, or all by number where there is none."""

    id: Column = Field(examples=['"Point"'])
    x: Column | None = Field(None, examples=['"Easting"'])
    y: Column | None = Field(None, examples=['"Northing"'])
    station: Column | None = Field(None, examples=['"Station"'])
    offset: Column | None = Field(None, examples=['"Offset"'])
    z: Column | None = Field(None, examples=['"Height"'])
    description: Column | None = Field(None, examples=['"Code"'])
    heading: Column | None = Field(None, examples=['"Azimuth"'])

    @model_validator(mode="after")
    def _all_by_name_or_number(self) -> SurveyColumns:
        all_alike(self)
        if self.station is None:
            for key, example in (("x", "Easting"), ("y", "Northing")):
                if getattr(self, key) is None:
                    raise fault(f'missing; write {key} = "{example}", or station', key)
            if self.offset is not None:
                raise fault('missing; write station = "Station"', "station")
        elif self.x is not None or self.y is not None:
            raise fault("a place twice; keep x and y, or station and offset", "station")
        return self


def _station(raw: object) -> float:
    try:
        return station_in(str(point_name(raw)), ".")
    except NoNumber as wrong:
        raise fault(f'{wrong}; write a station, like "10+00"') from None


class BaselineEntry(Table):
    """`[survey.baseline]`: the line along which stations count."""

    start: Annotated[float, BeforeValidator(_station)] = Field(
        examples=['"10+00" (station of the first corner of the line)']
    )
    line: list[tuple[_Far, _Far]] = Field(
        min_length=2,
        max_length=MOST_CORNERS,
        examples=['[["0 ft", "0 ft"], ["200 ft", "0 ft"]] (its corners, in axes)'],
    )
    positive: Literal["left", "right"] | None = Field(
        None, examples=['"right" (side of offsets that are written without L or R)']
    )

    @model_validator(mode="after")
    def _has_a_course(self) -> BaselineEntry:
        for (x, y), (x_next, y_next) in itertools.pairwise(self.line):
            if math.hypot(x_next.value - x.value, y_next.value - y.value) < 1e-3:
                raise fault("two corners that follow each other are one place", "line")
        return self


class SurveyEntry(FrameEntry, TableEntry):
    """`[survey]`: points as CSV."""

    unit: Annotated[float | Literal["deg"], BeforeValidator(_length_or_degrees)] = Field(
        examples=['"m" (or "ft", "in", or "deg" of latitude and longitude)']
    )
    baseline: BaselineEntry | None = Field(
        None, examples=['{ start = "10+00", line = [["0 ft", "0 ft"], ["200 ft", "0 ft"]] }']
    )

    columns: SurveyColumns = Field(examples=['{ id = "Point", x = "Easting", y = "Northing" }'])
    angle_unit: Annotated[float | None, BeforeValidator(_angle_unit)] = Field(
        None, examples=['"deg"']
    )

    @model_validator(mode="before")
    @classmethod
    def _origin_as_unit(cls, raw: Any) -> Any:
        """The origin of degrees in degrees."""
        if not isinstance(raw, dict) or not _are_degrees(raw.get("unit")):
            return raw
        origin = raw.get("origin")
        if isinstance(origin, list) and len(origin) == 2:
            try:
                return raw | {"origin": [_DEGREES.read(each) for each in origin]}
            except PydanticCustomError as wrong:
                raise fault(str(wrong), "origin") from None
        if not isinstance(origin, str):
            fix = (
                "degrees are projected about an origin; write the name of a point, or as axes say: "
                '["42.33141 deg", "-83.04575 deg"]'
            )
            raise fault(fix, "origin")
        return raw

    @model_validator(mode="after")
    def _stations_have_a_line(self) -> SurveyEntry:
        if self.columns.station is not None and self.baseline is None:
            raise fault(
                'stations count along a line; write baseline = { start = "10+00", line = '
                '[["0 ft", "0 ft"], ["200 ft", "0 ft"]] }',
                "columns.station",
            )
        if self.columns.station is None and self.baseline is not None:
            raise fault("no column of stations; write columns.station", "baseline")
        if self.columns.station is not None and self.unit == "deg":
            raise fault("stations are lengths; write their unit", "unit")
        return self

    @model_validator(mode="after")
    def _headings_are_explained(self) -> SurveyEntry:
        if self.columns.heading is not None:
            if self.angle_unit is None:
                raise fault('a column of angles needs its unit; write "deg"', "angle_unit")
            if self.angles is None:
                raise fault(f"a column of angles needs them: {_ANGLES}", "angles")
        return self


class DrawingEntry(FrameEntry):
    """`[drawing]`: DXF."""


class LandXmlEntry(FrameEntry):
    """`[landxml]`: coordinate points of LandXML, northing before easting as it defines them."""

    axes: tuple[Compass, Compass] = Field(("east", "north"), examples=['["east", "north"]'])


class ImpactPointEntry(Table):
    """`[impact_point]`."""

    point: Name = Field(examples=['"12"'])
    uncertainty: Uncertainty


_POINTS = '{ front_left_corner = "A1", rear_right_corner = "A3" }'


def _spots(raw: object) -> object:
    if isinstance(raw, dict):
        for spot in raw:
            if spot not in SPOTS:
                raise fault(f"{shown(spot)} is no spot of a vehicle; write {', '.join(SPOTS)}")
    return raw


class RestEntry(Table):
    """`[rest.A]`: a pose from two points or more on the vehicle, or from one and its heading."""

    points: Annotated[dict[str, Name], BeforeValidator(_spots)] = Field({}, examples=[_POINTS])
    offsets: dict[str, tuple[_Offset, _Offset]] = Field(
        {}, max_length=50, examples=['{ A7 = ["2.1 m", "-0.8 m"] } (ahead and left of its centre)']
    )
    heading: RestHeading | None = None
    uncertainty: Uncertainty

    @model_validator(mode="after")
    def _has_points(self) -> RestEntry:
        if not self.points and not self.offsets:
            raise fault(f"no point; write points = {_POINTS}")
        if self.heading and len(self.points) + len(self.offsets) > 1:
            raise fault("it follows from two points or more; leave it out", "heading")
        return self


_LIST: Any = Field(min_length=1, max_length=50, examples=['["21", "22"]'])


class MarksEntry(Table):
    """One of `[[marks.A]]`: points that a part of the vehicle passed, in any order."""

    points: list[Name] = _LIST
    of: Literal["centre", "front_left", "front_right", "rear_left", "rear_right"] = Field(
        examples=['"front_left", or "centre"']
    )
    uncertainty: Uncertainty


class EdgeEntry(Table):
    """`[edges.NAME]`: two points or more along the edge of a surface."""

    points: list[Name] = _LIST
    side: Literal["left", "right"] = Field(
        examples=['"left" or "right" (of the way from the first point to the last)']
    )
    uncertainty: Uncertainty


class OutlineEntry(Table):
    """`[outlines.NAME]`: points along the outline of a surface, in order; the last joins the first."""

    points: list[Name] = Field(
        min_length=1, max_length=MOST_CORNERS, examples=['["21", "22", "23"]']
    )
    uncertainty: Uncertainty


class RestsEntry(Table):
    """`[rest]`."""

    A: RestEntry | None = Field(default=None, examples=[f"{{ points = {_POINTS}, … }}"])
    B: RestEntry | None = Field(default=None, examples=[f"{{ points = {_POINTS}, … }}"])


class AllMarksEntry(Table):
    """`[marks]`."""

    A: list[MarksEntry] = Field(default=[], max_length=50, examples=['[{ points = ["21"], … }]'])
    B: list[MarksEntry] = Field(default=[], max_length=50, examples=['[{ points = ["21"], … }]'])


class MapEntry(Table):
    """The whole map file."""

    schema_version: int = Field(alias="schema", strict=True, ge=1, le=1, examples=["1"])
    survey: SurveyEntry | None = Field(None, examples=['{ unit = "m", … }'])
    drawing: DrawingEntry | None = Field(None, examples=['{ unit = "m", … }'])
    landxml: LandXmlEntry | None = Field(None, examples=['{ unit = "m", … }'])
    recorder: RecorderEntry | None = Field(None, examples=['{ vehicle = "A", … }'])
    impact_point: ImpactPointEntry | None = Field(
        None, examples=['{ point = "12", uncertainty = "0.3 m" }']
    )
    rest: RestsEntry = Field(RestsEntry(), examples=["{ A = { … } }"])
    marks: AllMarksEntry = Field(AllMarksEntry(), examples=["{ A = [{ … }] }"])
    edges: dict[SurfaceName, EdgeEntry] = Field({}, max_length=20, examples=["{ berm = { … } }"])
    outlines: dict[SurfaceName, OutlineEntry] = Field(
        {}, max_length=20, examples=["{ oil = { … } }"]
    )

    @model_validator(mode="after")
    def _one_kind_of_file(self) -> MapEntry:
        frames = [each for each in (self.survey, self.drawing, self.landxml) if each is not None]
        if len(frames) + (self.recorder is not None) != 1:
            raise fault(
                "write one table of [survey] (points as CSV), [drawing] (DXF), [landxml] or "
                "[recorder] (CSV)"
            )
        frame = frames[0] if frames else None
        of_points = {"impact_point", "rest", "marks", "edges", "outlines"} & self.model_fields_set
        if frame is None and of_points:
            raise fault(
                "points are taken of a [survey], [drawing] or [landxml]", sorted(of_points)[0]
            )
        for name in sorted(self.edges.keys() & self.outlines.keys()):
            raise fault("this surface has an edge too; leave out one of them", f"outlines.{name}")
        headed = [v for v in ("A", "B") if (rest := getattr(self.rest, v)) and rest.heading]
        if headed and frame and frame.angles is None:
            raise fault(f"rest.{headed[0]} has a heading; in the table of the file, {_ANGLES}")
        return self
