"""What a map file says of the table of an event data recorder, and what of it a scene takes."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Field,
    PlainValidator,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)

from retrodict.interchange.map_tables import Column, Name, TableEntry, all_alike, unit_factor
from retrodict.scene import units
from retrodict.scene.entries.table import IS_AN_SD, Table
from retrodict.scene.entries.vehicle import RecordTime, RecordUncertainty
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.records import Measured

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


class RecorderColumns(Table):
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
        all_alike(self)
        for group in _SAME:
            first, *others = [key for key in group if getattr(self, key) is not None] or [""]
            if others:
                raise fault(f"the same twice; keep it, or {others[0]}", first)
        return self


_YawRateSD = Annotated[
    Measured, Kind(units.YAW_RATE, 0.01, 100, "2 deg/s", uncertainty="refused", advice=IS_AN_SD)
]


def _moment_or_window(raw: object) -> object:
    return raw if isinstance(raw, list) else [raw, raw]


class RecordedSpeedEntry(Table):
    """`[recorder.speed]`."""

    impact: Annotated[tuple[RecordTime, RecordTime], BeforeValidator(_moment_or_window)] = Field(
        examples=['"0 s", or ["-0.5 s", "0 s"] (earliest and latest)']
    )
    uncertainty: RecordUncertainty


_AT: Any = Field(examples=['"last", or "0.15 s"'])


def _at(raw: object, read: ValidatorFunctionWrapHandler) -> Any:
    return None if raw == "last" else read(raw)


_PULSE_TIME = Kind(units.TIME, -600, 600, "0.15 s", uncertainty="refused")


def _at_or_end(raw: object) -> Any:
    if raw in ("last", "end"):
        return "end" if raw == "end" else None
    return _PULSE_TIME.read(raw)


_Moment = Annotated[RecordTime | None, WrapValidator(_at)]


class RecordedDeltaVEntry(Table):
    """`[recorder.delta_v]`."""

    at: Annotated[Measured | Literal["end"] | None, PlainValidator(_at_or_end)] = Field(
        examples=['"last", "end" (of the pulse), or "0.15 s"']
    )
    ended: Literal["early", "after the impact"] = Field(examples=['"early" or "after the impact"'])
    uncertainty: RecordUncertainty

    @model_validator(mode="after")
    def _end_is_recorded(self) -> RecordedDeltaVEntry:
        if self.at == "end" and self.ended == "early":
            raise fault('a record that ended early does not have it; write "last"', "at")
        return self


class RecordedYawRateEntry(Table):
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
        found[column] = unit_factor(unit, RECORDED[column], column)
    return found


class LongEntry(Table):
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
