"""What a map file says: how to read another program's file, and what of it a scene takes."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from retrodict.interchange.cells import NoNumber, station_in
from retrodict.interchange.points import SPOTS, Angles, Compass
from retrodict.scene import units
from retrodict.scene.entries.impact import SurfaceName
from retrodict.scene.entries.table import IS_AN_SD
from retrodict.scene.entries.vehicle import Direction, RecordTime, RecordUncertainty, RestHeading
from retrodict.scene.errors import SceneError, shown
from retrodict.scene.explain import problems_of
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.load import read_text, toml_of
from retrodict.scene.outlines import MOST_CORNERS
from retrodict.scene.records import Measured
from retrodict.scene.units import Dimension, QuantityError, factor


def load_map(path: str | Path) -> MapEntry:
    """A map from a map file.

    Args:
        path: a TOML file; its keys are described in docs/import.md.

    Returns:
        The map, checked.

    Raises:
        SceneError: the file cannot be read, or something in it is wrong.
    """
    document = toml_of(read_text(path, "map"), str(path))
    try:
        return MapEntry.model_validate(document)
    except ValidationError as error:
        raise SceneError(str(path), problems_of(error, MapEntry)) from None


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


def _name(raw: object) -> object:
    """A point's name: text, or a whole number as many instruments count them."""
    if isinstance(raw, int) and not isinstance(raw, bool) and raw.bit_length() < 64:
        return str(raw)
    if not isinstance(raw, str) or not raw.strip() or len(raw) > 100 or not raw.isprintable():
        raise fault('write the name of a point, like "12"')
    return raw.strip()


def _column(raw: object) -> object:
    if isinstance(raw, int) and not isinstance(raw, bool):
        if not 1 <= raw <= 200:
            raise fault("write the number of a column, from 1, or its name in the header")
        return raw
    return _name(raw)


def _reader(dimension: Dimension) -> Callable[[object], float]:
    def read(raw: object) -> float:
        try:
            if not isinstance(raw, str):
                raise QuantityError(f'write a unit in quotes, like "{dimension.units[0]}"')
            return factor(raw, dimension)
        except QuantityError as error:
            raise fault(error.fix) from None

    return read


def _a_unit(dimension: Dimension) -> BeforeValidator:
    return BeforeValidator(_reader(dimension))


_length_unit = _reader(units.LENGTH)
Name = Annotated[str, BeforeValidator(_name)]
Column = Annotated[int | str, BeforeValidator(_column)]
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
    return _name(raw)


class FrameEntry(_Table):
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


class SurveyColumns(_Table):
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
        if len({type(each) for _, each in self if each is not None}) > 1:
            raise fault("write all columns by name, or all by number where there is no header")
        if self.station is None:
            for key, example in (("x", "Easting"), ("y", "Northing")):
                if getattr(self, key) is None:
                    raise fault(f'missing; write {key} = "{example}", or station', key)
            if self.offset is not None:
                raise fault('missing; write station = "Station"', "station")
        elif self.x is not None or self.y is not None:
            raise fault("a place twice; keep x and y, or station and offset", "station")
        return self


BLANKS = (" ", "  ")  # one or more, or two or more


def _only(raw: object) -> object:
    """What cells of a column must be, by the column; a number is written as text or as a number."""
    if not isinstance(raw, dict) or not 0 < len(raw) <= 10:
        raise fault('write a column and the cell that its rows have: { Event = "1" }')
    return {_name(column): _name(cell) for column, cell in raw.items()}


class TableEntry(_Table):
    """What `[survey]` and `[recorder]` say of a table in a text file."""

    encoding: (
        Literal[
            "utf-8", "utf-16", "utf-16-le", "cp1252", "latin-1", "cp1250", "cp1251", "cp1253",
            "cp1254", "cp437", "cp850", "mac-roman", "shift_jis", "gb18030", "euc_kr", "big5",
        ] | None
    ) = Field(None, examples=['"cp1252"'])  # fmt: skip
    separator: Literal[",", ";", "\t", "|", " ", "  "] | None = Field(None, examples=['";"'])
    decimal: Literal[".", ","] = Field(".", examples=['","'])
    below: Name | None = Field(None, examples=['"Event Record 2" (a line above the table)'])
    only: Annotated[dict[str, str], BeforeValidator(_only)] = Field(
        {}, examples=['{ Event = "1" } (the cell that all rows have in this column)']
    )

    @model_validator(mode="after")
    def _only_as_columns(self) -> TableEntry:
        by_number = any(isinstance(each, int) for _, each in getattr(self, "columns", ()))
        if by_number and not all(re.fullmatch("[1-9][0-9]{0,2}", column) for column in self.only):
            raise fault('write numbers of columns, as in columns: { 1 = "2" }', "only")
        return self


def _station(raw: object) -> float:
    try:
        return station_in(str(_name(raw)), ".")
    except NoNumber as wrong:
        raise fault(f'{wrong}; write a station, like "10+00"') from None


class BaselineEntry(_Table):
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
    angle_unit: Annotated[float | None, _a_unit(units.ANGLE)] = Field(None, examples=['"deg"'])

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


class ImpactPointEntry(_Table):
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


class RestEntry(_Table):
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


class MarksEntry(_Table):
    """One of `[[marks.A]]`: points that a part of the vehicle passed, in any order."""

    points: list[Name] = _LIST
    of: Literal["centre", "front_left", "front_right", "rear_left", "rear_right"] = Field(
        examples=['"front_left", or "centre"']
    )
    uncertainty: Uncertainty


class EdgeEntry(_Table):
    """`[edges.NAME]`: two points or more along the edge of a surface."""

    points: list[Name] = _LIST
    side: Literal["left", "right"] = Field(
        examples=['"left" or "right" (of the way from the first point to the last)']
    )
    uncertainty: Uncertainty


class OutlineEntry(_Table):
    """`[outlines.NAME]`: points along the outline of a surface, in order; the last joins the first."""

    points: list[Name] = Field(
        min_length=1, max_length=MOST_CORNERS, examples=['["21", "22", "23"]']
    )
    uncertainty: Uncertainty


# what a recorder's table may have: unit, and where the sign is the other way round, a scene's name
RECORDED = {
    "time": units.TIME,
    "speed": units.SPEED,
    "delta_v": units.SPEED,
    "delta_v_forward": units.SPEED,
    "delta_v_left": units.SPEED,
    "delta_v_right": units.SPEED,
    "acceleration_forward": units.DECELERATION,
    "acceleration_left": units.DECELERATION,
    "acceleration_right": units.DECELERATION,
    "yaw_rate": units.YAW_RATE,
    "yaw_rate_clockwise": units.YAW_RATE,
}
_SAME = (
    ("delta_v_forward", "acceleration_forward"),
    ("delta_v_left", "delta_v_right", "acceleration_left", "acceleration_right"),
    ("yaw_rate", "yaw_rate_clockwise"),
)


def taken_as(column: str) -> str:
    """The key of `[recorder]` that takes a column: speed, delta_v or yaw_rate."""
    if column.startswith("acceleration"):
        return "delta_v"
    return next((key for key in ("speed", "delta_v", "yaw_rate") if column.startswith(key)), "")


class RecorderColumns(_Table):
    """`[recorder.columns]`: by name in the header, or all by number where there is none."""

    time: Column = Field(examples=['"Time (s)"'])
    speed: Column | None = Field(None, examples=['"Speed (mph)"'])
    delta_v: Column | None = Field(None, examples=['"Resultant delta-v"'])
    delta_v_forward: Column | None = Field(None, examples=['"Longitudinal delta-v"'])
    delta_v_left: Column | None = Field(None, examples=['"Lateral delta-v"'])
    delta_v_right: Column | None = Field(None, examples=['"Lateral delta-v"'])
    acceleration_forward: Column | None = Field(None, examples=['"Longitudinal acceleration"'])
    acceleration_left: Column | None = Field(None, examples=['"Lateral acceleration"'])
    acceleration_right: Column | None = Field(None, examples=['"Lateral acceleration"'])
    yaw_rate: Column | None = Field(None, examples=['"Yaw rate"'])
    yaw_rate_clockwise: Column | None = Field(None, examples=['"Yaw rate"'])

    @model_validator(mode="after")
    def _each_once(self) -> RecorderColumns:
        if len({type(each) for _, each in self if each is not None}) > 1:
            raise fault("write all columns by name, or all by number where there is no header")
        for group in _SAME:
            first, *others = [key for key in group if getattr(self, key) is not None] or [""]
            if others:
                raise fault(f"the same twice; keep it, or {others[0]}", first)
        return self


_SpeedSD = RecordUncertainty
_YawRateSD = Annotated[
    Measured, Kind(units.YAW_RATE, 0.01, 100, "2 deg/s", uncertainty="refused", advice=IS_AN_SD)
]


def _moment_or_window(raw: object) -> object:
    return raw if isinstance(raw, list) else [raw, raw]


class RecordedSpeedEntry(_Table):
    """`[recorder.speed]`."""

    impact: Annotated[tuple[RecordTime, RecordTime], BeforeValidator(_moment_or_window)] = Field(
        examples=['"0 s", or ["-0.5 s", "0 s"] (earliest and latest)']
    )
    uncertainty: _SpeedSD


_AT: Any = Field(examples=['"last", or "0.15 s"'])


def _at(raw: object, read: ValidatorFunctionWrapHandler) -> Any:
    return None if raw == "last" else read(raw)


_PULSE_TIME = Kind(units.TIME, -600, 600, "0.15 s", uncertainty="refused")


def _at_or_end(raw: object) -> Any:
    if raw in ("last", "end"):
        return "end" if raw == "end" else None
    return _PULSE_TIME.read(raw)


_Moment = Annotated[RecordTime | None, WrapValidator(_at)]


class RecordedDeltaVEntry(_Table):
    """`[recorder.delta_v]`."""

    at: Annotated[Measured | Literal["end"] | None, PlainValidator(_at_or_end)] = Field(
        examples=['"last", "end" (of the pulse), or "0.15 s"']
    )
    ended: Literal["early", "after the impact"] = Field(examples=['"early" or "after the impact"'])
    uncertainty: _SpeedSD

    @model_validator(mode="after")
    def _end_is_recorded(self) -> RecordedDeltaVEntry:
        if self.at == "end" and self.ended == "early":
            raise fault('a record that ended early does not have it; write "last"', "at")
        return self


class RecordedYawRateEntry(_Table):
    """`[recorder.yaw_rate]`."""

    at: _Moment = _AT
    to: Literal["approach", "departure"] = Field(
        examples=['"approach" or "departure" (just before, or just after the impact)']
    )
    uncertainty: _YawRateSD


def _known_units(raw: object) -> object:
    """Units of columns, as factors to SI."""
    if not isinstance(raw, dict):
        raise fault('write a table: { time = "s", speed = "mph" }')
    found = {}
    for column, unit in raw.items():
        if column not in RECORDED:
            raise fault(f"unknown column; write {', '.join(RECORDED)}", column)
        try:
            if not isinstance(unit, str):
                raise QuantityError(f'write a unit in quotes, like "{RECORDED[column].units[0]}"')
            found[column] = factor(unit, RECORDED[column])
        except QuantityError as error:
            raise fault(error.fix, column) from None
    return found


class LongEntry(_Table):
    """`[recorder.long]`: a table with a row for each value, whose columns have these names."""

    parameter: Name = Field(examples=['"Signal"'])
    value: Name = Field(examples=['"Value"'])
    unit: Name | None = Field(None, examples=['"Unit"'])


class RecorderEntry(TableEntry):
    """`[recorder]`: the table of an event data recorder as CSV."""

    vehicle: Literal["A", "B"] = Field(examples=['"A" or "B"'])
    columns: RecorderColumns = Field(examples=['{ time = "Time (s)", speed = "Speed (mph)" }'])
    units: Annotated[dict[str, float], BeforeValidator(_known_units)] = Field(
        examples=['{ time = "s", speed = "mph" }']
    )
    long: LongEntry | None = Field(
        None, examples=['{ parameter = "Signal", value = "Value" } (a row for each value)']
    )
    speed: RecordedSpeedEntry | None = Field(
        None, examples=['{ impact = ["-0.5 s", "0 s"], uncertainty = "1 mph" }']
    )
    delta_v: RecordedDeltaVEntry | None = Field(
        None, examples=['{ at = "last", ended = "early", uncertainty = "1 mph" }']
    )
    yaw_rate: RecordedYawRateEntry | None = Field(
        None, examples=['{ at = "0 s", to = "approach", uncertainty = "2 deg/s" }']
    )

    @model_validator(mode="after")
    def _columns_are_explained(self) -> RecorderEntry:
        for column, there in self.columns:
            if there is not None and column not in self.units:
                first = RECORDED[column].units[0]
                raise fault(f'no unit of {column}; write {column} = "{first}"', "units")
        for key in ("speed", "delta_v", "yaw_rate"):
            columns = [c for c, there in self.columns if there is not None and taken_as(c) == key]
            if getattr(self, key) is not None and not columns:
                raise fault(f'no such column; add it to columns, like {key} = "…"', key)
        if self.long and isinstance(self.columns.time, int):
            raise fault("write the name in the header, and the names of parameters", "columns.time")
        return self


class RestsEntry(_Table):
    """`[rest]`."""

    A: RestEntry | None = Field(default=None, examples=[f"{{ points = {_POINTS}, … }}"])
    B: RestEntry | None = Field(default=None, examples=[f"{{ points = {_POINTS}, … }}"])


class AllMarksEntry(_Table):
    """`[marks]`."""

    A: list[MarksEntry] = Field(default=[], max_length=50, examples=['[{ points = ["21"], … }]'])
    B: list[MarksEntry] = Field(default=[], max_length=50, examples=['[{ points = ["21"], … }]'])


class MapEntry(_Table):
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
