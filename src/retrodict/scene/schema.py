"""The scene file as it may be written: which tables and keys there are."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    AliasChoices,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationInfo,
    create_model,
    model_validator,
)

from retrodict.scene.asked import Proposition, read_comparison, read_proposition
from retrodict.scene.defaults import FRICTION
from retrodict.scene.departure import ITEMS
from retrodict.scene.errors import shown
from retrodict.scene.kinds import (
    ApproachDirection,
    ApproachYawRate,
    AxleDistance,
    BetweenVehicles,
    ContactLine,
    Course,
    Deceleration,
    DistanceBefore,
    DragFactor,
    EdgeCoordinate,
    EdgeDirection,
    EdgeUncertainty,
    EndCoordinate,
    EndHeading,
    EnergyLost,
    Friction,
    Grip,
    Heading,
    HeightOfCentre,
    ImpactAngle,
    ImpactCoordinate,
    ImpactDistance,
    MarkCoordinate,
    MarkUncertainty,
    Mass,
    MomentCentre,
    NumberScale,
    OutlineCoordinate,
    OutlineLength,
    OutlineWidth,
    PoleDiameter,
    ReactionTime,
    RecordedSpeed,
    RecordTime,
    RecordUncertainty,
    RestCoordinate,
    RestHeading,
    RoadGrade,
    Rotation,
    RunOutHeading,
    RunOutPosition,
    Skid,
    Span,
    Speed,
    SpeedDependence,
    SpeedLimit,
    SpeedScale,
    Steer,
    TimeBefore,
    Track,
    Uphill,
    Wheel,
    YawInertia,
    YawRateScale,
    fault,
    of_departure,
)
from retrodict.scene.names import vehicle_of
from retrodict.scene.outlines import outline_fault
from retrodict.scene.quantities import UNKNOWNS
from retrodict.scene.records import Measured
from retrodict.scene.units import QuantityError
from retrodict.scene.vehicle_library import find, near


def _line(limit: int) -> BeforeValidator:
    def read(raw: object) -> str:
        # characters that do not print could forge lines in a terminal or a report
        if not isinstance(raw, str) or not raw.strip():
            raise fault("write some text in quotes")
        if len(raw) > limit or not raw.replace("\N{NO-BREAK SPACE}", " ").isprintable():
            raise fault(f"write one line of at most {limit} printable characters")
        return raw

    return BeforeValidator(read)


def _pattern_name(raw: object) -> str:
    name = str(raw)
    plain = name.isascii() and name.replace("_", "a").isalnum() and name.islower()
    if not plain or not name[0].isalpha() or len(name) > 40:
        raise fault("write a surface's name in lower case: letters, digits and _, a letter first")
    return name


def _asked(raw: object) -> tuple[str, ...]:
    names = ", ".join(f'"{name}"' for name in UNKNOWNS)
    if not isinstance(raw, list) or not raw:
        raise fault(f'write a list of what is asked, like ["speed_b"], of {names}')
    for name in raw:
        if name not in UNKNOWNS:
            raise fault(f"{shown(name)} cannot be asked; write one or more of {names}")
    return tuple(name for name in UNKNOWNS if name in raw)


def _known_surface(raw: object) -> object:
    if not isinstance(raw, str) or raw not in FRICTION:
        kinds = ", ".join(f'"{kind}"' for kind in FRICTION)
        raise fault(f"no friction is known for it; write one of {kinds}, or friction")
    return raw


def _few(raw: object) -> object:
    if isinstance(raw, list) and len(raw) > _MARKS:
        raise fault(f"{len(raw)} marks; write at most {_MARKS} for a vehicle")
    return raw


def _by_wheel(raw: object) -> object:
    if raw != "locked" and not isinstance(raw, dict):
        raise fault(f'write "locked", or each wheel: wheels = {_WHEELS}')
    return None if raw == "locked" else raw


_MARKS = 50  # for a vehicle
_RECORDED = 200  # speeds of a record
_WHEELS = (
    '{ front_left = "locked", front_right = "rolling", '
    'rear_left = "rolling", rear_right = "0.3 ± 0.1" }'
)

Title = Annotated[str, _line(200)]
Note = Annotated[str, _line(1000)]
SurfaceName = Annotated[str, BeforeValidator(_pattern_name)]


_REST = '{ position = ["-5.1 ± 0.15 m", "1.9 ± 0.15 m"], heading = "215 ± 3 deg" }'


_END = '{ x = "3 ± 0.5 m", y = "1 ± 0.5 m", heading = "20 ± 5 deg" }'


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


def _not_empty(table: _Table) -> None:
    keys = list(type(table).model_fields)
    if all(getattr(table, key) is None for key in keys):
        raise fault(f"is empty; write one or more of {', '.join(keys)}")


class ImpactCentreEntry(_Table):
    """`[vehicles.A.impact_centre]`: from the centre of gravity, as seen by the driver."""

    distance: ImpactDistance
    angle: ImpactAngle


class ImpactPoseEntry(_Table):
    """`[vehicles.A.impact]`: how the vehicle stood at impact."""

    heading: Heading


class SpeedRecordEntry(_Table):
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


class ApproachEntry(_Table):
    """`[vehicles.A.approach]`: what is known of the motion just before impact."""

    speed: Speed | None = None
    speed_record: SpeedRecordEntry | None = Field(
        default=None,
        examples=[
            '{ times = ["-1 s", "0 s"], speeds = ["45 mph", "37 mph"], '
            'impact = ["-0.5 s", "0 s"], uncertainty = "1 mph" }'
        ],
    )
    direction: ApproachDirection | None = None
    yaw_rate: ApproachYawRate | None = None
    skid: Skid | None = None

    @model_validator(mode="after")
    def _has_one_speed(self) -> ApproachEntry:
        if self.speed and self.speed_record:
            raise fault("the same twice; keep it, or speed_record", "speed")
        return self


class _DepartureTable(_Table):
    @model_validator(mode="after")
    def _has_something_once(self) -> _DepartureTable:
        _not_empty(self)
        written = {name for name, measured in self if measured}
        for end in ("", "_at_least"):
            parts = [f"delta_v_forward{end}", f"delta_v_left{end}"]
            if f"delta_v{end}" in written and not written.isdisjoint(parts):
                fix = f"the same measurement twice; keep it, or {' and '.join(parts)}"
                raise fault(fix, f"delta_v{end}")
        return self


if TYPE_CHECKING:
    DepartureEntry = _DepartureTable
else:
    DepartureEntry = create_model(
        "DepartureEntry",
        __base__=_DepartureTable,
        __doc__="`[vehicles.A.departure]`: what is known of the motion just after impact.",
        **{name: (Annotated[Measured, of_departure(name)] | None, None) for name in ITEMS},
    )


class MarkEntry(_Table):
    """One of `marks` of a vehicle: a point that it passed on its way to rest."""

    point: tuple[MarkCoordinate, MarkCoordinate] = Field(examples=['["3 m", "1 m"]'])
    of: Literal["centre", "front_left", "front_right", "rear_left", "rear_right"] = Field(
        "centre", examples=['"centre", or a wheel: "front_left"']
    )
    uncertainty: MarkUncertainty | None = None
    speed: Speed | None = None
    course: Course | None = None


class EndOfRotationEntry(_Table):
    """`end_of_rotation` of a vehicle: where it stopped sliding sideways and began to roll."""

    x: EndCoordinate | None = None
    y: EndCoordinate | None = None
    heading: EndHeading | None = None

    @model_validator(mode="after")
    def _has_a_part(self) -> EndOfRotationEntry:
        _not_empty(self)
        return self


class RestEntry(_Table):
    """`[vehicles.A.rest]`: where the vehicle came to rest."""

    position: tuple[RestCoordinate, RestCoordinate] = Field(
        examples=['["-5.1 ± 0.15 m", "1.9 ± 0.15 m"]']
    )
    heading: RestHeading | None = None
    rotation: Rotation | None = None

    @model_validator(mode="after")
    def _what_turned_has_a_heading(self) -> RestEntry:
        if self.rotation is not None and self.heading is None:
            raise fault(
                "it counts the turns of a measured heading; leave it out, or write "
                'heading = "215 ± 3 deg"',
                "rotation",
            )
        return self


class WheelsEntry(_Table):
    """`wheels` of a vehicle: how each turned after the impact."""

    front_left: Wheel
    front_right: Wheel
    rear_left: Wheel
    rear_right: Wheel


class RunOutErrorEntry(_Table):
    """`run_out_error` of a vehicle: how far a run-out model misses it, one standard deviation."""

    position: RunOutPosition | None = None
    heading: RunOutHeading | None = None


class VehicleEntry(_Table):
    """`[vehicles.A]` and `[vehicles.B]`: a vehicle, how it stood at impact, where it went."""

    name: Annotated[str, _line(60)] | None = Field(None, examples=['"sedan"'])
    kind: str | None = Field(None, alias="class", examples=['"compact car"'])
    mass: Mass
    yaw_inertia: YawInertia | None = None
    wheelbase: AxleDistance | None = None
    cg_to_front_axle: AxleDistance | None = None
    cg_to_rear_axle: AxleDistance | None = None
    track: Track
    cg_height: HeightOfCentre | None = None
    length: OutlineLength | None = None
    width: OutlineWidth | None = None
    grip: Grip | None = None
    wheels: Annotated[WheelsEntry | None, BeforeValidator(_by_wheel)] = None
    drag_factor: DragFactor | None = None
    steer: Steer | None = None
    run_out_error: RunOutErrorEntry = Field(
        RunOutErrorEntry(), examples=['{ position = "4 %", heading = "8 deg" }']
    )
    impact_centre: ImpactCentreEntry = Field(
        examples=['{ distance = "2.09 ± 0.05 m", angle = "10 ± 2 deg" }']
    )
    impact: ImpactPoseEntry = Field(examples=['{ heading = "180 ± 2 deg" }'])
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
        """What is not written is that of the class, if one is named."""
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
        if self.wheelbase is None:
            for key in ("cg_to_front_axle", "cg_to_rear_axle"):
                if getattr(self, key) is None:
                    raise fault(f'missing; write {key} = "1.35 m", or the wheelbase', key)
        return self

    @model_validator(mode="after")
    def _what_steers_rolls(self) -> VehicleEntry:
        for key, why in (("steer", "do not steer"), ("drag_factor", "stay locked")):
            if getattr(self, key) is not None and self.wheels is None:
                raise fault(f"locked wheels {why}; leave it out, or add wheels = {_WHEELS}", key)
        return self


def _a_vehicle_or_a_barrier(raw: object, info: ValidationInfo) -> object:
    """Of what A struck, one: whether there is a barrier is the context, since it stands elsewhere."""
    barrier = bool(info.context and info.context["barrier"])
    if raw is None and not barrier:
        raise fault('missing; write B = { mass = "1778 ± 36 kg", … }, or what A struck: [barrier]')
    if raw is not None and barrier:
        raise fault("A struck a vehicle or a barrier; leave out one, vehicles.B or barrier")
    return raw


class VehiclesEntry(_Table):
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
        if not any(v.rest or v.departure or v.marks or v.end_of_rotation for v in vehicles):
            whose = ("either", " of one") if self.B else ("the vehicle", "")
            raise fault(
                f"nothing is known of {whose[0]} after the impact; "
                f"write rest = {_REST}, departure, marks or end_of_rotation{whose[1]}"
            )
        return self

    @property
    def by_letter(self) -> dict[str, VehicleEntry]:
        """Those that are written."""
        return {"A": self.A} | ({"B": self.B} if self.B else {})


class BarrierEntry(_Table):
    """`[barrier]`: what vehicle A struck in the place of a vehicle B, rigid and immovable."""

    kind: Literal["wall", "pole"] = Field(examples=['"wall" or "pole"'])
    name: Annotated[str, _line(60)] | None = Field(None, examples=['"concrete wall"'])
    diameter: PoleDiameter | None = None

    @model_validator(mode="after")
    def _a_pole_is_round(self) -> BarrierEntry:
        if self.kind == "pole" and self.diameter is None:
            raise fault('missing; write diameter = "0.3 m"', "diameter")
        if self.kind == "wall" and self.diameter is not None:
            raise fault('a wall has none; leave it out, or write kind = "pole"', "diameter")
        return self


class ImpactEntry(_Table):
    """`[impact]`: where and along which line the vehicles touched, and what it took of their energy."""

    point: tuple[ImpactCoordinate, ImpactCoordinate] = Field(
        examples=['["0 ± 0.3 m", "0 ± 0.3 m"]']
    )
    contact_line: ContactLine
    interlocked: bool = Field(default=False, strict=True, examples=["true"])
    energy_lost: EnergyLost | None = None
    energy_lost_at_least: EnergyLost | None = None
    energy_lost_at_most: EnergyLost | None = None

    @model_validator(mode="after")
    def _energy_is_stated_once(self) -> ImpactEntry:
        least, most = self.energy_lost_at_least, self.energy_lost_at_most
        if self.energy_lost and (least or most):
            fix = "the same twice; keep it, or energy_lost_at_least and energy_lost_at_most"
            raise fault(fix, "energy_lost")
        if least and most and least.value >= most.value:
            raise fault("not above energy_lost_at_least; exchange them", "energy_lost_at_most")
        return self


class EdgeEntry(_Table):
    """`edge` of a surface: the straight line beyond which it lies."""

    point: tuple[EdgeCoordinate, EdgeCoordinate] = Field(examples=['["0 m", "4 m"]'])
    direction: EdgeDirection
    side: Literal["left", "right"] = Field(examples=['"left" or "right"'])
    uncertainty: EdgeUncertainty | None = None


def _around(corners: list[tuple[Measured, Measured]]) -> list[tuple[Measured, Measured]]:
    if wrong := outline_fault([(x.value, y.value) for x, y in corners]):
        raise fault(wrong)
    return corners


_CORNERS = '[["2 m", "-3 m"], ["6 m", "-3 m"], ["6 m", "1 m"]]'


class OutlineEntry(_Table):
    """`outline` of a surface: the corners that it lies between."""

    corners: Annotated[
        list[tuple[OutlineCoordinate, OutlineCoordinate]], AfterValidator(_around)
    ] = Field(examples=[_CORNERS])
    uncertainty: EdgeUncertainty | None = None


class SurfaceEntry(_Table):
    """`[surfaces.NAME]`: what the vehicles slid over."""

    kind: Annotated[str, BeforeValidator(_known_surface)] | None = Field(
        None, examples=['"dry asphalt"']
    )
    friction: Friction | None = None
    speed_dependence: SpeedDependence | None = None
    edge: EdgeEntry | None = Field(
        default=None, examples=['{ point = ["0 m", "4 m"], direction = "0 deg", side = "left" }']
    )
    outline: OutlineEntry | None = Field(default=None, examples=[f"{{ corners = {_CORNERS} }}"])

    @model_validator(mode="after")
    def _friction_is_known(self) -> SurfaceEntry:
        if self.friction is None and self.kind is None:
            fix = 'missing; write friction = "0.50 ± 0.03", or kind = "dry asphalt"'
            raise fault(fix, "friction")
        return self

    @model_validator(mode="after")
    def _ends_in_one_way(self) -> SurfaceEntry:
        if self.edge and self.outline:
            raise fault("the surface ends twice; keep it, or edge", "outline")
        return self


class SlopeEntry(_Table):
    """`[slope]`: how steeply the whole ground rises, and where to."""

    grade: RoadGrade
    uphill: Uphill


class PriorEntry(_Table):
    """What every override of a prior has."""

    source: Annotated[str, _line(200)] = Field(examples=['"survey of speeds on this road"'])

    @model_validator(mode="after")
    def _overrides_something(self) -> PriorEntry:
        keys = [key for key in type(self).model_fields if key != "source"]
        if all(getattr(self, key) is None for key in keys):
            raise fault(f"overrides nothing; write one or more of {', '.join(keys)}")
        return self


class SpeedPriorEntry(PriorEntry):
    """`[priors.speed_a]`, `speed_b` and `impulse`: how large a speed, or change of it, may be."""

    scale: SpeedScale


class YawRatePriorEntry(PriorEntry):
    """`[priors.omega_a]`, `omega_b` and `Omega`: how large a yaw rate may be."""

    scale: YawRateScale


class RestitutionPriorEntry(PriorEntry):
    """`[priors.e]`: its scale in fast and in slow impacts, and the closing speed between them."""

    fast: NumberScale | None = None
    slow: NumberScale | None = None
    over: SpeedScale | None = None


class MuPriorEntry(PriorEntry):
    """`[priors.mu]`: how far it is below its critical value, and friction where sliding goes on."""

    scale: NumberScale | None = None
    friction: BetweenVehicles | None = None


class MomentPriorEntry(PriorEntry):
    """`[priors.e_m]`."""

    centre: MomentCentre | None = None
    scale: NumberScale | None = None


class PriorsEntry(_Table):
    """`[priors]`: what is assumed of the unknowns, in place of the defaults."""

    speed_a: SpeedPriorEntry | None = Field(
        default=None, examples=['{ scale = "40 m/s", source = "…" }']
    )
    speed_b: SpeedPriorEntry | None = Field(
        default=None, examples=['{ scale = "40 m/s", source = "…" }']
    )
    omega_a: YawRatePriorEntry | None = Field(
        default=None, examples=['{ scale = "1 rad/s", source = "…" }']
    )
    omega_b: YawRatePriorEntry | None = Field(
        default=None, examples=['{ scale = "1 rad/s", source = "…" }']
    )
    e: RestitutionPriorEntry | None = Field(
        default=None, examples=['{ fast = 0.13, source = "…" }']
    )
    mu: MuPriorEntry | None = Field(default=None, examples=['{ scale = 0.2, source = "…" }'])
    e_m: MomentPriorEntry | None = Field(default=None, examples=['{ scale = 0.5, source = "…" }'])
    impulse: SpeedPriorEntry | None = Field(
        default=None, examples=['{ scale = "20 m/s", source = "…" }']
    )
    Omega: YawRatePriorEntry | None = Field(
        default=None, examples=['{ scale = "5 rad/s", source = "…" }']
    )


def _propositions(raw: object) -> tuple[Proposition, ...]:
    texts = raw if isinstance(raw, list) else [raw]
    if len(texts) > _ASKED:
        raise fault(f"{len(texts)} propositions; write at most {_ASKED}")
    return tuple(_proposition(text) for text in texts)


def _proposition(raw: object) -> Proposition:
    try:
        return read_proposition(raw)
    except QuantityError as found:
        raise fault(found.fix) from None


def _one_limit(asked: tuple[Proposition, ...]) -> tuple[Proposition, ...]:
    for each in asked:
        if math.isfinite(each.low) and math.isfinite(each.high):
            raise fault(f"{shown(each.text)} has two limits; write it under between")
    return asked


def _two_limits(asked: tuple[Proposition, ...]) -> tuple[Proposition, ...]:
    for each in asked:
        if not (math.isfinite(each.low) and math.isfinite(each.high)):
            raise fault(f"{shown(each.text)} has one limit; write it under exceeds")
    return asked


_ASKED = 20  # of each kind of question
Propositions = Annotated[tuple[Proposition, ...], PlainValidator(_propositions)]
_FIRST, _SECOND = '"speed_b at most 45 mph"', '"speed_b at least 55 mph"'
_AVOIDABLE = (
    '[{ vehicle = "B", limit = "45 mph", reaction = "1.5 ± 0.3 s", deceleration = "0.7 ± 0.07 g", '
    'seen_time = "2.5 ± 0.3 s" }]'
)


class LikelihoodRatioEntry(_Table):
    """One of `likelihood_ratio`: two propositions about one speed before the impact."""

    first: Annotated[Proposition, PlainValidator(_proposition)] = Field(examples=[_FIRST])
    second: Annotated[Proposition, PlainValidator(_proposition)] = Field(examples=[_SECOND])

    @model_validator(mode="after")
    def _exclude_each_other(self) -> LikelihoodRatioEntry:
        try:
            read_comparison(self.first, self.second)
        except QuantityError as found:
            raise fault(found.fix) from None
        return self


class AvoidableEntry(_Table):
    """One of `avoidable`: a driver, and how it would have reacted at the speed limit."""

    vehicle: Literal["A", "B"] = Field(examples=['"B"'])
    limit: SpeedLimit
    reaction: ReactionTime
    deceleration: Deceleration
    seen_time: TimeBefore | None = None
    seen_distance: DistanceBefore | None = None
    clear: DistanceBefore | None = None

    @model_validator(mode="after")
    def _is_seen_once(self) -> AvoidableEntry:
        if self.seen_time and self.seen_distance:
            raise fault("the same twice; keep it, or seen_distance", "seen_time")
        return self


class QuestionsEntry(_Table):
    """`[questions]`: what is asked of the answer."""

    exceeds: Annotated[Propositions, AfterValidator(_one_limit)] = Field(
        default=(), examples=['"speed_b > 45 mph"']
    )
    between: Annotated[Propositions, AfterValidator(_two_limits)] = Field(
        default=(), examples=['"40 mph < speed_b < 50 mph"']
    )
    likelihood_ratio: list[LikelihoodRatioEntry] = Field(
        default=[], max_length=_ASKED, examples=[f"[{{ first = {_FIRST}, second = {_SECOND} }}]"]
    )
    avoidable: list[AvoidableEntry] = Field(default=[], max_length=_ASKED, examples=[_AVOIDABLE])
    time_distance: Span | None = None
    corners: bool = Field(default=False, strict=True, examples=["true"])
    one_at_a_time: bool = Field(default=True, strict=True, examples=["false"])
    checks: bool = Field(default=True, strict=True, examples=["false"])


_ROAD = '{ road = { friction = "0.50 ± 0.03" } }'


def _one_without_end(surfaces: dict[str, SurfaceEntry]) -> dict[str, SurfaceEntry]:
    bare = [name for name, surface in surfaces.items() if not (surface.edge or surface.outline)]
    if len(bare) != 1:
        found = f"{', '.join(bare)} have none" if bare else "here none is without"
        raise fault(f"write an edge or outline for every surface but one, the road; {found}")
    return surfaces


class SceneEntry(_Table):
    """The whole scene file."""

    schema_version: int = Field(alias="schema", strict=True, ge=1, le=1, examples=["1"])
    title: Title = Field(examples=['"Two cars on a bend"'])
    notes: list[Note] = Field([], max_length=50, examples=['["one remark", "another"]'])
    question: Annotated[tuple[str, ...], BeforeValidator(_asked)] = Field(
        (), examples=['["speed_b"]']
    )
    errors: Literal["normal", "robust"] = Field("normal", examples=['"robust", or "normal"'])
    vehicles: VehiclesEntry = Field(examples=["{ A = { … }, B = { … } }"])
    barrier: BarrierEntry | None = Field(None, examples=['{ kind = "wall" }'])
    impact: ImpactEntry = Field(
        examples=['{ point = ["0 ± 0.3 m", "0 ± 0.3 m"], contact_line = "-8.9 ± 3 deg" }']
    )
    surfaces: Annotated[dict[SurfaceName, SurfaceEntry], AfterValidator(_one_without_end)] = Field(
        {}, max_length=20, examples=[_ROAD]
    )
    slope: SlopeEntry | None = Field(
        None, examples=['{ grade = "4 ± 0.5 %", uphill = "90 ± 5 deg" }']
    )
    priors: PriorsEntry = Field(PriorsEntry(), examples=["{ speed_b = { … } }"])
    questions: QuestionsEntry = Field(
        QuestionsEntry(), examples=['{ exceeds = "speed_b > 45 mph" }']
    )

    @model_validator(mode="after")
    def _what_slid_slid_on_something(self) -> SceneEntry:
        slid = any(
            v.rest or v.marks or v.end_of_rotation or v.approach.skid
            for v in self.vehicles.by_letter.values()
        )
        if slid and not self.surfaces:
            raise fault(f"missing; write surfaces = {_ROAD}", "surfaces")
        return self

    @model_validator(mode="after")
    def _a_barrier_is_asked_nothing(self) -> SceneEntry:
        if self.barrier is None:
            return self
        still = "a scene with a barrier has no vehicle B"
        if "speed_b" in self.question:
            raise fault(f'{still}; write question = ["speed_a"]', "question")
        for prior in ("speed_b", "omega_b"):
            if getattr(self.priors, prior) is not None:
                raise fault(f"{still}; leave this prior out", f"priors.{prior}")
        asked = self.questions
        for key, propositions in (
            ("exceeds", asked.exceeds),
            ("between", asked.between),
            ("likelihood_ratio", [each.first for each in asked.likelihood_ratio]),
        ):
            if any(vehicle_of(each.name) == "b" for each in propositions):
                raise fault(f"{still}; ask it of A, as in speed_a", f"questions.{key}")
        if any(each.vehicle == "B" for each in asked.avoidable):
            raise fault(f'{still}; write vehicle = "A"', "questions.avoidable")
        if any(each.clear for each in asked.avoidable):
            raise fault("a barrier never clears the way; leave clear out", "questions.avoidable")
        if asked.corners:
            fix = "the corner range is of B's speed, and a scene with a barrier has no B; leave it out"
            raise fault(fix, "questions.corners")
        return self


def validated(document: Mapping[str, Any]) -> SceneEntry:
    """The tables and keys of a scene file, validated; its vehicles know whether there is a barrier.

    Args:
        document: as TOML reads it.

    Raises:
        ValidationError: something in it is wrong.
    """
    return SceneEntry.model_validate(
        document, context={"barrier": document.get("barrier") is not None}
    )
