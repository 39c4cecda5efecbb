"""The entries of the vehicles: properties, approach, pose at impact, departure and rest of each."""

from __future__ import annotations

import itertools
from typing import Annotated, Literal

from pydantic import (
    AliasChoices,
    BeforeValidator,
    Field,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)

from retrodict.scene import units
from retrodict.scene.defaults import DEFAULTS, SLIDING
from retrodict.scene.entries.table import (
    FOR_DRAWING,
    FROM_ORIGIN,
    IS_AN_SD,
    Table,
    not_empty,
    one_line,
    with_fields,
)
from retrodict.scene.fields import (
    APPROACH,
    DEPARTURE,
    END_OF_ROTATION,
    FROM_IMPACT,
    IMPACT_CENTRE,
    POSE_AT_IMPACT,
    VEHICLE,
)
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.measured import UNKNOWN, Measured
from retrodict.scene.vehicle_library import find, near

_OF_WHEELS = (
    "wheelbase", "cg_to_front_axle", "cg_to_rear_axle", "track", "cg_height", "wheels", "drag_factor",
    "steer",
)  # fmt: skip
_MARKS = 50  # for a vehicle
_RECORDED = 200  # speeds of a record
_WHEELS = (
    '{ front_left = "locked", front_right = "rolling", '
    'rear_left = "rolling", rear_right = "0.3 ± 0.1" }'
)
_REST = '{ position = ["-5.1 ± 0.15 m", "1.9 ± 0.15 m"], heading = "215 ± 3 deg" }'
_IMPACT_CENTRE = '{ distance = "2.09 ± 0.05 m", angle = "10 ± 2 deg" }'
_END = '{ x = "3 ± 0.5 m", y = "1 ± 0.5 m", heading = "20 ± 5 deg" }'

_MARK = "that of the mark goes into its key uncertainty"
_RECORD = "that of all goes into the key uncertainty"
OutlineLength = Annotated[
    Measured, Kind(units.LENGTH, 0.5, 30, "5.2 m", uncertainty="refused", advice=FOR_DRAWING)
]
OutlineWidth = Annotated[
    Measured, Kind(units.LENGTH, 0.3, 6, "1.8 m", uncertainty="refused", advice=FOR_DRAWING)
]
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
DragFactor = Annotated[Measured, Kind(units.NUMBER, 0.1, 10, "1 ± 0.3", "lognormal")]
RunOutPosition = Annotated[
    Measured, Kind(units.SHARE, 0, 50, "4 %", uncertainty="refused", advice=IS_AN_SD)
]
RunOutHeading = Annotated[
    Measured, Kind(units.ANGLE, 0, 90, "8 deg", uncertainty="refused", advice=IS_AN_SD)
]
Steer = Annotated[Measured, Kind(units.ANGLE, -90, 90, "0 ± 2 deg")]
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
_WHEELBASE = Kind(units.LENGTH, 0.05, 20, "2.85 m", "lognormal")
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


WHEEL_WORDS = ("locked", "rolling", "rolling, in gear", "damaged")


def _wheel(raw: object, read: ValidatorFunctionWrapHandler) -> Measured | str:
    if isinstance(raw, str) and raw in WHEEL_WORDS:
        return raw
    if isinstance(raw, str) and not any(c.isdigit() for c in raw):
        words = ", ".join(f'"{word}"' for word in WHEEL_WORDS)
        raise fault(f'write {words}, or its braking force over the friction, like "0.3 ± 0.1"')
    measured: Measured = read(raw)
    return measured


# a word is kept: the drag that it stands for depends on the road's friction
Wheel = Annotated[
    Measured | str,
    Kind(units.NUMBER, 0, 1, "0.3 ± 0.1", "logitnormal"),
    WrapValidator(_wheel),
    Field(examples=['"locked"']),
]


def _sliding(raw: object, read: ValidatorFunctionWrapHandler) -> Measured:
    if isinstance(raw, str) and not any(c.isdigit() for c in raw):
        if (known := SLIDING.get(raw)) is None:
            words = ", ".join(f'"{word}"' for word in SLIDING)
            raise fault(f'no drag factor is known for it; write {words}, or one like "0.45 ± 0.1"')
        source = f"assumed of a {raw}: {known}"
        return Measured(known.value, known.sd, "lognormal", source, "value")
    measured: Measured = read(raw)
    return measured


def _few(raw: object) -> object:
    if isinstance(raw, list) and len(raw) > _MARKS:
        raise fault(f"{len(raw)} marks; write at most {_MARKS} for a vehicle")
    return raw


def _by_wheel(raw: object) -> object:
    if raw != "locked" and not isinstance(raw, dict):
        raise fault(f'write "locked", or each wheel: wheels = {_WHEELS}')
    return None if raw == "locked" else raw


class ImpactCentreEntry(Table):
    """`[vehicles.A.impact_centre]`: its place from the centre of gravity, as the driver sees it."""

    distance: Annotated[Measured, IMPACT_CENTRE["distance"]]
    angle: Annotated[Measured, IMPACT_CENTRE["angle"]]


class ImpactPoseEntry(Table):
    """`[vehicles.A.impact]`: how the vehicle stood at impact."""

    heading: Annotated[Measured, POSE_AT_IMPACT["heading"]]


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

    @model_validator(mode="after")
    def _has_one_speed(self) -> ApproachEntry:
        if self.speed and self.speed_record:
            raise fault("the same twice; keep it, or speed_record", "speed")
        return self


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


@with_fields(END_OF_ROTATION)
class EndOfRotationEntry(Table):
    """`end_of_rotation` of a vehicle: where it stopped sliding sideways and began to roll."""

    @model_validator(mode="after")
    def _has_a_part(self) -> EndOfRotationEntry:
        not_empty(self)
        return self


@with_fields(FROM_IMPACT)
class RestEntry(Table):
    """`[vehicles.A.rest]`: where the vehicle came to rest, as a position or from the impact."""

    position: tuple[RestCoordinate, RestCoordinate] | None = Field(
        None, examples=['["-5.1 ± 0.15 m", "1.9 ± 0.15 m"]']
    )
    distance: Annotated[Measured, FROM_IMPACT["distance"]] | None = None
    direction: Annotated[Measured, FROM_IMPACT["direction"]] | None = None
    heading: RestHeading | None = None
    rotation: Rotation | None = None

    @model_validator(mode="after")
    def _is_somewhere(self) -> RestEntry:
        if self.position is not None and (self.distance or self.direction):
            raise fault("the same twice; keep it, or distance and direction", "position")
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


class WheelsEntry(Table):
    """`wheels` of a vehicle: how each turned after the impact."""

    front_left: Wheel
    front_right: Wheel
    rear_left: Wheel
    rear_right: Wheel


class RunOutErrorEntry(Table):
    """`run_out_error` of a vehicle: how far a run-out model misses it, one standard deviation."""

    position: RunOutPosition | None = None
    heading: RunOutHeading | None = None


@with_fields(VEHICLE)
class VehicleEntry(Table):
    """`[vehicles.A]` and `[vehicles.B]`: a vehicle, how it stood at impact, where it went."""

    name: Annotated[str, one_line(60)] | None = Field(None, examples=['"sedan"'])
    kind: str | None = Field(None, alias="class", examples=['"compact car"'])
    mass: Annotated[Measured, VEHICLE["mass"]]
    yaw_inertia: Annotated[Measured, VEHICLE["yaw_inertia"]] | None = None
    wheelbase: Annotated[Measured, _WHEELBASE] | None = None
    cg_to_front_axle: Annotated[Measured, VEHICLE["cg_to_front_axle"]] | None = None
    cg_to_rear_axle: Annotated[Measured, VEHICLE["cg_to_rear_axle"]] | None = None
    track: Annotated[Measured, VEHICLE["track"]] | None = None
    length: OutlineLength | None = None
    width: OutlineWidth | None = None
    wheels: Annotated[WheelsEntry | None, BeforeValidator(_by_wheel)] = None
    drag_factor: DragFactor | None = None
    steer: Steer | None = None
    run_out_error: RunOutErrorEntry = Field(
        RunOutErrorEntry(), examples=['{ position = "4 %", heading = "8 deg" }']
    )
    impact_centre: ImpactCentreEntry | None = Field(None, examples=[_IMPACT_CENTRE])
    slides: Annotated[Measured, VEHICLE["slides"], WrapValidator(_sliding)] | None = None
    impact: ImpactPoseEntry | None = Field(
        None, validate_default=True, examples=['{ heading = "180 ± 2 deg" }']
    )
    approach: ApproachEntry = Field(ApproachEntry(), examples=['{ speed = "45 ± 2 mph" }'])
    departure: DepartureEntry | None = Field(None, examples=['{ delta_v = "12 ± 1 m/s" }'])
    marks: Annotated[list[MarkEntry], BeforeValidator(_few)] = Field(
        [], examples=['[{ point = ["3 m", "1 m"], of = "front_left" }]']
    )
    end_of_rotation: EndOfRotationEntry | None = Field(None, examples=[_END])
    rest: RestEntry | None = Field(None, examples=[_REST])

    @model_validator(mode="before")
    @classmethod
    def _class_fills_in(cls, raw: object) -> object:
        """Fill in the figures that are not written from the class, if one is named."""
        if not isinstance(raw, dict) or "class" not in raw:
            return raw
        name = raw["class"]
        known = find(name) if isinstance(name, str) else None
        if known is None:
            names = ", ".join(f'"{each}"' for each in near(name if isinstance(name, str) else ""))
            raise fault(f"not in the library of vehicles; write one of {names}", "class")
        missing = {"mass", "track", "width", "wheelbase", "length"} - raw.keys()
        if "track" in raw:  # the outline of the class need not fit
            missing -= {"width"}
        if "wheelbase" in raw or {"cg_to_front_axle", "cg_to_rear_axle"} <= raw.keys():
            missing -= {"wheelbase", "length"}
        of_class = {key: getattr(known, key) for key in missing}
        filled = {key: known.assumed(each) for key, each in of_class.items() if each}
        return raw | filled | {"class": known.name}

    @model_validator(mode="after")
    def _axles_are_known(self) -> VehicleEntry:
        axles = ("cg_to_front_axle", "cg_to_rear_axle")
        written = [key for key in axles if getattr(self, key) is not None]
        if self.wheelbase is None and len(written) == 1:
            (key,) = set(axles) - set(written)
            raise fault(f'missing; write {key} = "1.35 m", or the wheelbase', key)
        return self

    @model_validator(mode="after")
    def _what_is_said_of_wheels_has_their_places(self) -> VehicleEntry:
        said = [key for key in ("wheels", "cg_height") if getattr(self, key) is not None]
        for key, example in (("wheelbase", "2.85 m"), ("track", "1.54 m")):
            if said and key in self.unwritten:
                raise fault(f'missing; write {key} = "{example}", which {said[0]} needs', key)
        return self

    @model_validator(mode="after")
    def _what_slides_has_no_wheels(self) -> VehicleEntry:
        if self.slides is None:
            return self
        for key in (*_OF_WHEELS, "yaw_inertia", "end_of_rotation"):
            if getattr(self, key):
                raise fault(
                    "what slides has no wheels and does not yaw; leave it out, or slides", key
                )
        if any(mark.of != "centre" for mark in self.marks):
            raise fault("what slides has no wheels; leave of out, or slides", "marks")
        return self

    @model_validator(mode="after")
    def _stands_some_way(self) -> VehicleEntry:
        goes = isinstance(self.approach.direction, Measured)
        if self.impact is None and not (self.slides and goes):
            raise fault('missing; write impact = { heading = "180 ± 2 deg" }', "impact")
        return self

    @property
    def heading(self) -> Measured:
        """Heading at impact; of what slides the direction in which it came, where it has none."""
        if self.impact is not None:
            return self.impact.heading
        assert isinstance(self.approach.direction, Measured), "the schema sees to it"
        return self.approach.direction

    @property
    def unwritten(self) -> tuple[str, ...]:
        """Keys that only some of the models need, and that the file does not have."""
        lacks_axles = self.wheelbase is None and self.cg_to_front_axle is None
        lacks = {
            "impact_centre": self.impact_centre is None,
            "wheelbase": lacks_axles,
            "track": self.track is None,
        }
        return tuple(key for key, missing in lacks.items() if missing)

    @model_validator(mode="after")
    def _what_steers_rolls(self) -> VehicleEntry:
        for key, why in (("steer", "do not steer"), ("drag_factor", "stay locked")):
            if getattr(self, key) is not None and self.wheels is None:
                raise fault(f"locked wheels {why}; leave it out, or add wheels = {_WHEELS}", key)
        return self


def _a_vehicle_or_a_barrier(raw: object, info: ValidationInfo) -> object:
    """Check that A struck one of the two; the context says whether the file has a barrier."""
    context = info.context or {}
    barrier, alone = context.get("barrier", False), context.get("alone", False)
    if raw is None and not (barrier or alone):
        raise fault(
            'missing; write B = { mass = "1778 ± 36 kg", … }, or what A struck: [barrier], or above all '
            "tables alone = true"
        )
    if raw is not None and (barrier or alone):
        key, what = ("barrier", "a barrier") if barrier else ("alone", "nothing")
        raise fault(f"A struck a vehicle or {what}; leave out one, vehicles.B or {key}")
    return raw


class VehiclesEntry(Table):
    """`[vehicles]`: exactly A and B, or A alone where it struck a barrier."""

    A: VehicleEntry = Field(
        validation_alias=AliasChoices("A", "a"), examples=['{ mass = "1857 ± 37 kg", … }']
    )
    B: Annotated[VehicleEntry | None, BeforeValidator(_a_vehicle_or_a_barrier)] = Field(
        None,
        validation_alias=AliasChoices("B", "b"),
        validate_default=True,
        examples=['{ mass = "1778 ± 36 kg", … }'],
    )

    @model_validator(mode="after")
    def _something_is_known_after_impact(self) -> VehiclesEntry:
        vehicles = self.by_letter.values()
        if self.B is None and self.A.approach.skid and self.A.approach.speed:
            return self  # a skid up to a known speed says all
        if not any(v.rest or v.departure or v.marks or v.end_of_rotation for v in vehicles):
            whose = ("either", " of one") if self.B else ("the vehicle", "")
            raise fault(
                f"nothing is known of {whose[0]} after the impact; "
                f"write rest = {_REST}, departure, marks or end_of_rotation{whose[1]}"
            )
        return self

    @property
    def by_letter(self) -> dict[str, VehicleEntry]:
        """The vehicles that are written, by letter."""
        return {"A": self.A} | ({"B": self.B} if self.B else {})
