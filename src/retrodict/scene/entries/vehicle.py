"""The entries of the vehicles: the properties of each, and what is known of its motion."""

from __future__ import annotations

from typing import Annotated

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
from retrodict.scene.defaults import SLIDING
from retrodict.scene.entries.motion import (
    ApproachEntry,
    DepartureEntry,
    ImpactPoseEntry,
    MarkEntry,
    RestEntry,
)
from retrodict.scene.entries.motion import Direction as Direction
from retrodict.scene.entries.motion import RecordTime as RecordTime
from retrodict.scene.entries.motion import RecordUncertainty as RecordUncertainty
from retrodict.scene.entries.motion import RestHeading as RestHeading
from retrodict.scene.entries.table import (
    FOR_DRAWING,
    IS_AN_SD,
    Table,
    one_line,
    with_fields,
    with_tables,
)
from retrodict.scene.fields import AFTER, IMPACT_CENTRE, VEHICLE
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.measured import Measured
from retrodict.scene.vehicle_library import find, near

_OF_WHEELS = (
    "wheelbase", "cg_to_front_axle", "cg_to_rear_axle", "track", "cg_height", "wheels", "drag_factor",
    "steer",
)  # fmt: skip
_MARKS = 50  # for a vehicle
_WHEELS = (
    '{ front_left = "locked", front_right = "rolling", '
    'rear_left = "rolling", rear_right = "0.3 ± 0.1" }'
)
_REST = '{ position = ["-5.1 ± 0.15 m", "1.9 ± 0.15 m"], heading = "215 ± 3 deg" }'
_IMPACT_CENTRE = '{ distance = "2.09 ± 0.05 m", angle = "10 ± 2 deg" }'

OutlineLength = Annotated[
    Measured, Kind(units.LENGTH, 0.5, 30, "5.2 m", uncertainty="refused", advice=FOR_DRAWING)
]
OutlineWidth = Annotated[
    Measured, Kind(units.LENGTH, 0.3, 6, "1.8 m", uncertainty="refused", advice=FOR_DRAWING)
]
DragFactor = Annotated[Measured, Kind(units.NUMBER, 0.1, 10, "1 ± 0.3", "lognormal")]
RunOutPosition = Annotated[
    Measured, Kind(units.SHARE, 0, 50, "4 %", uncertainty="refused", advice=IS_AN_SD)
]
RunOutHeading = Annotated[
    Measured, Kind(units.ANGLE, 0, 90, "8 deg", uncertainty="refused", advice=IS_AN_SD)
]
Steer = Annotated[Measured, Kind(units.ANGLE, -90, 90, "0 ± 2 deg")]
_WHEELBASE = Kind(units.LENGTH, 0.05, 20, "2.85 m", "lognormal")


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


def _locked(raw: object) -> str | None:
    if raw is not None and raw != "locked":
        free = raw == "free"
        why = "a free articulation, about which tractor and trailer turn, is not modelled; " * free
        raise fault(f'{why}write "locked", for one rigid body, or leave it out')
    return raw


class ImpactCentreEntry(Table):
    """`[vehicles.A.impact_centre]`: its place from the centre of gravity, as the driver sees it."""

    distance: Annotated[Measured, IMPACT_CENTRE["distance"]]
    angle: Annotated[Measured, IMPACT_CENTRE["angle"]]


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


@with_tables(AFTER)
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
    articulation: Annotated[str | None, BeforeValidator(_locked)] = None
    impact: ImpactPoseEntry | None = Field(
        None, validate_default=True, examples=['{ heading = "180 ± 2 deg" }']
    )
    approach: ApproachEntry = Field(ApproachEntry(), examples=['{ speed = "45 ± 2 mph" }'])
    departure: DepartureEntry | None = Field(None, examples=['{ delta_v = "12 ± 1 m/s" }'])
    marks: Annotated[list[MarkEntry], BeforeValidator(_few)] = Field(
        [], examples=['[{ point = ["3 m", "1 m"], of = "front_left" }]']
    )
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
        if "slides" in raw:
            missing &= {"mass"}
        elif known.track is None and "track" not in raw:
            words = ", ".join(f'"{word}"' for word in SLIDING)
            raise fault(
                f"{known.name} has no track: write slides = {words}, or its drag factor", "class"
            )
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
        if self.approach.yaw_mark:
            raise fault("what slides has no tyres; leave it out, or slides", "approach.yaw_mark")
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

    def tables(self, where: str = "") -> list[Table]:
        """The written tables of evidence after the impact.

        Args:
            where: place of the measurements, as in `fields.Evidence`; empty for any.
        """
        of_place = (own.table for own in AFTER.values() if where in ("", own.where))
        return [table for key in of_place if (table := getattr(self, key))]

    @property
    def on_way(self) -> bool:
        """Whether anything was measured between the impact and rest."""
        return bool(self.marks or self.tables("on the way"))

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
        before = self.A.approach
        slid = (before.skid or before.skids) and before.speed
        if self.B is None and (slid or before.yaw_mark):
            return self  # a skid up to a known speed says all, and so does a critical speed
        if not any(v.marks or v.tables() for v in vehicles):
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
