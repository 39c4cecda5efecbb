"""The entries of a vehicle's motion: approach, pose at impact, departure, marks and rest."""

from __future__ import annotations

import itertools
from typing import Annotated, ClassVar, Literal

from pydantic import Field, ValidatorFunctionWrapHandler, WrapValidator, model_validator

from retrodict.scene import units
from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.entries.impact import SurfaceName
from retrodict.scene.entries.table import FROM_ORIGIN, IS_AN_SD, Table, not_empty, with_fields
from retrodict.scene.fields import (
    APPROACH,
    DEPARTURE,
    FROM_IMPACT,
    POSE_AT_IMPACT,
    SKID,
    YAW_MARK,
)
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.measured import UNKNOWN, Measured

_RECORDED = 200  # speeds of a record
_PIECES = 20  # of a skid
_MARK = "that of the mark goes into its key uncertainty"
_RECORD = "that of all goes into the key uncertainty"
RecordedSpeed = Annotated[
    Measured, Kind(units.SPEED, 0, 150, "40 mph", uncertainty="refused", advice=_RECORD)
]
RecordTime = Annotated[
    Measured,
    Kind(
        units.TIME,
        -600,
        600,
        "-0.5 s",
        uncertainty="refused",
        advice="the recorder's clock is exact",
    ),
]
RecordUncertainty = Annotated[
    Measured,
    Kind(
        units.SPEED,
        0.01,
        50,
        "1 mph",
        uncertainty="refused",
        advice=IS_AN_SD,
    ),
]
RestCoordinate = Annotated[
    Measured,
    Kind(
        units.LENGTH,
        -1000,
        1000,
        "-5.1 ± 0.15 m",
        default=DEFAULTS["rest_position"],
        advice=FROM_ORIGIN,
    ),
]
RestHeading = Annotated[
    Measured,
    Kind(
        units.DIRECTION,
        -360,
        360,
        "215 ± 3 deg",
        default=DEFAULTS["rest_heading"],
        advice="whole turns go into rotation",
    ),
]
Rotation = Annotated[
    Measured,
    Kind(
        units.ANGLE,
        -3600,
        3600,
        "35 deg",
        uncertainty="refused",
        advice="it only selects the number of whole turns",
    ),
]
MarkCoordinate = Annotated[
    Measured,
    Kind(units.LENGTH, -1000, 1000, "3 m", uncertainty="refused", advice=_MARK),
]
MarkUncertainty = Annotated[
    Measured,
    Kind(
        units.LENGTH,
        0.001,
        100,
        "0.2 m",
        uncertainty="refused",
        advice=IS_AN_SD,
    ),
]
MethodError = Annotated[
    Measured, Kind(units.SHARE, 0.5, 50, "10 %", uncertainty="refused", advice=IS_AN_SD)
]
Direction = Annotated[Measured, APPROACH["direction"]]
Course = Annotated[Measured, DEPARTURE["direction"]]
Speed = Annotated[Measured, APPROACH["speed"]]


def _or_unknown(raw: object, read: ValidatorFunctionWrapHandler) -> Measured | str:
    if isinstance(raw, str) and not any(c.isdigit() for c in raw):
        if raw.strip().casefold() != UNKNOWN:
            raise fault('write a number with its unit, or "unknown" for a vehicle that slid')
        return UNKNOWN
    measured: Measured = read(raw)
    return measured


class ImpactPoseEntry(Table):
    """`[vehicles.A.impact]`: how the vehicle stood at impact."""

    heading: Annotated[Measured, POSE_AT_IMPACT["heading"]]


@with_fields(SKID)
class SkidEntry(Table):
    """An entry of `skids`: a piece of the skid up to the impact, on one surface, with one braking."""

    length: Annotated[Measured, SKID["length"]]
    surface: SurfaceName | None = Field(None, examples=['"road"'])

    @model_validator(mode="after")
    def _has_one_deceleration(self) -> SkidEntry:
        written = {name for name, each in self if each is not None}
        if "drag_factor" in written and (twice := written & {"surface", "braking"}):
            raise fault(
                f"a drag factor is the whole deceleration; keep it, or {' and '.join(sorted(twice))}",
                "drag_factor",
            )
        return self


# no figure that could be read says how far a method's speed lies off the true one
_NO_ERROR = (
    'missing; write error = "10 %", one standard deviation of the method\'s speed: no default is '
    "given, because published tests do not agree (biases of 10 to 15 % on average by the abstract of "
    "SAE 2014-01-0467, which says that others dispute it)"
)


@with_fields(YAW_MARK)
class YawMarkEntry(Table):
    """`yaw_mark` of an approach: the arc of a critical-speed yaw mark, up to where its skid begins."""

    error: MethodError | None = None
    surface: SurfaceName | None = Field(None, examples=['"road"'])

    @model_validator(mode="after")
    def _is_an_arc_with_an_error(self) -> YawMarkEntry:
        if self.error is None:
            raise fault(_NO_ERROR, "error")
        values = dict(self)
        if values["middle_ordinate"].value >= values["chord"].value / 2:
            raise fault(
                "as long as half the chord; it is the arc's height above it", "middle_ordinate"
            )
        return self


class SpeedRecordEntry(Table):
    """`[vehicles.A.approach.speed_record]`: speeds that a recorder kept, the impact's time unknown."""

    times: list[RecordTime] = Field(max_length=_RECORDED, examples=['["-1 s", "-0.5 s", "0 s"]'])
    speeds: list[RecordedSpeed] = Field(
        max_length=_RECORDED, examples=['["45 mph", "41 mph", "37 mph"]']
    )
    impact: tuple[RecordTime, RecordTime] = Field(examples=['["-0.5 s", "0 s"]'])
    uncertainty: RecordUncertainty

    @model_validator(mode="after")
    def _impact_lies_within(self) -> SpeedRecordEntry:
        times = [t.value for t in self.times]
        if len(times) != len(self.speeds) or len(times) < 2:
            raise fault("write as many times as speeds, two or more", "times")
        if any(after <= before for before, after in itertools.pairwise(times)):
            raise fault("write times that increase", "times")
        low, high = (t.value for t in self.impact)
        if not low < high:
            raise fault("write the earliest and the latest time of the impact; or speed", "impact")
        if not times[0] <= low < high <= times[-1]:
            raise fault(
                "reaches beyond the record; add a time and a speed there, as you assume it went on",
                "impact",
            )
        return self


@with_fields(APPROACH)
class ApproachEntry(Table):
    """`[vehicles.A.approach]`: what is known of the motion just before impact."""

    instead: ClassVar = {"skid": ("skids",), "speed": ("speed_record",)}
    speed: Speed | None = None
    speed_record: SpeedRecordEntry | None = Field(
        default=None,
        examples=[
            '{ times = ["-1 s", "0 s"], speeds = ["45 mph", "37 mph"], '
            'impact = ["-0.5 s", "0 s"], uncertainty = "1 mph" }'
        ],
    )
    direction: (
        Annotated[
            Measured | str,
            APPROACH["direction"],
            WrapValidator(_or_unknown),
            Field(examples=['"180 ± 2 deg", or "unknown"']),
        ]
        | None
    ) = None
    yaw_rate: Annotated[Measured | str, APPROACH["yaw_rate"], WrapValidator(_or_unknown)] | None = (
        None
    )
    skid: Annotated[Measured, APPROACH["skid"]] | None = None
    skids: list[SkidEntry] = Field(
        default=[],
        max_length=_PIECES,
        examples=['[{ length = "9 m", surface = "gravel" }, { length = "12 m" }]'],
    )
    yaw_mark: YawMarkEntry | None = Field(
        default=None,
        examples=['{ chord = "12 m", middle_ordinate = "0.45 ± 0.02 m", error = "10 %" }'],
    )

    @property
    def slid_on(self) -> set[str]:
        """Names of the surfaces of its skids and its yaw mark, where they are written."""
        surfaces = {piece.surface for piece in self.skids}
        surfaces |= {self.yaw_mark.surface} if self.yaw_mark else set()
        return {surface for surface in surfaces if surface is not None}

    @property
    def marked(self) -> bool:
        """Whether marks on the road say how it slowed down."""
        return bool(self.skid or self.skids or self.yaw_mark)


@with_fields(DEPARTURE)
class DepartureEntry(Table):
    """`[vehicles.A.departure]`: what is known of the motion just after impact."""

    @model_validator(mode="after")
    def _has_something_once(self) -> DepartureEntry:
        not_empty(self)
        written = {name for name, measured in self if measured}
        for end in ("", "_at_least"):
            parts = [f"delta_v_forward{end}", f"delta_v_left{end}"]
            if f"delta_v{end}" in written and not written.isdisjoint(parts):
                fix = f"the same measurement twice; keep it, or {' and '.join(parts)}"
                raise fault(fix, f"delta_v{end}")
        return self


class MarkEntry(Table):
    """An entry of `marks` of a vehicle: a point that it passed on its way to rest."""

    point: tuple[MarkCoordinate, MarkCoordinate] = Field(examples=['["3 m", "1 m"]'])
    of: Literal["centre", "front_left", "front_right", "rear_left", "rear_right"] = Field(
        "centre", examples=['"centre", or a wheel: "front_left"']
    )
    uncertainty: MarkUncertainty | None = None
    speed: Speed | None = None
    course: Course | None = None


@with_fields(FROM_IMPACT)
class RestEntry(Table):
    """`[vehicles.A.rest]`: where the vehicle came to rest, as a position or from the impact."""

    instead: ClassVar = {"position": ("distance", "direction")}
    position: tuple[RestCoordinate, RestCoordinate] | None = Field(
        None, examples=['["-5.1 ± 0.15 m", "1.9 ± 0.15 m"]']
    )
    distance: Annotated[Measured, FROM_IMPACT["distance"]] | None = None
    direction: Annotated[Measured, FROM_IMPACT["direction"]] | None = None
    heading: RestHeading | None = None
    rotation: Rotation | None = None

    @model_validator(mode="after")
    def _is_somewhere(self) -> RestEntry:
        if self.position is None and self.distance is None:
            raise fault(
                'missing; write position = ["-5.1 m", "1.9 m"], or distance = "12 ± 0.5 m" from the '
                "impact",
                "position",
            )
        if self.position is None and self.heading is not None:
            raise fault("it needs a position; leave it out, or write position", "heading")
        return self

    @model_validator(mode="after")
    def _what_turned_has_a_heading(self) -> RestEntry:
        if self.rotation is not None and self.heading is None:
            raise fault(
                "it counts the turns of a measured heading; leave it out, or write "
                'heading = "215 ± 3 deg"',
                "rotation",
            )
        return self
