"""The scene file as it may be written: which tables and keys there are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import (
    AfterValidator,
    AliasChoices,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    create_model,
    model_validator,
)

from retrodict.scene.defaults import FRICTION
from retrodict.scene.departure import ITEMS
from retrodict.scene.errors import shown
from retrodict.scene.kinds import (
    AxleDistance,
    BetweenVehicles,
    ContactLine,
    Course,
    Direction,
    DragFactor,
    EdgeCoordinate,
    EdgeDirection,
    EdgeUncertainty,
    EndCoordinate,
    EndHeading,
    Friction,
    Grip,
    Heading,
    ImpactAngle,
    ImpactCoordinate,
    ImpactDistance,
    MarkCoordinate,
    MarkUncertainty,
    Mass,
    MomentCentre,
    NumberScale,
    OutlineLength,
    OutlineWidth,
    RestCoordinate,
    RestHeading,
    Rotation,
    RunOutHeading,
    RunOutPosition,
    Skid,
    Speed,
    SpeedDependence,
    SpeedScale,
    Steer,
    Track,
    Wheel,
    YawInertia,
    YawRate,
    YawRateScale,
    fault,
    of_departure,
)
from retrodict.scene.quantities import UNKNOWNS
from retrodict.scene.records import Measured


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


class ApproachEntry(_Table):
    """`[vehicles.A.approach]`: what is known of the motion just before impact."""

    speed: Speed | None = None
    direction: Direction | None = None
    yaw_rate: YawRate | None = None
    skid: Skid | None = None


class _DepartureTable(_Table):
    @model_validator(mode="after")
    def _has_something_once(self) -> _DepartureTable:
        _not_empty(self)
        written = {name for name, measured in self if measured}
        if "delta_v" in written and not written.isdisjoint({"delta_v_forward", "delta_v_left"}):
            raise fault(
                "the same measurement twice; keep it, or delta_v_forward and delta_v_left",
                "delta_v",
            )
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
    mass: Mass
    yaw_inertia: YawInertia | None = None
    wheelbase: AxleDistance | None = None
    cg_to_front_axle: AxleDistance | None = None
    cg_to_rear_axle: AxleDistance | None = None
    track: Track
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


class VehiclesEntry(_Table):
    """`[vehicles]`: exactly A and B."""

    A: VehicleEntry = Field(
        validation_alias=AliasChoices("A", "a"), examples=['{ mass = "1857 ± 37 kg", … }']
    )
    B: VehicleEntry = Field(
        validation_alias=AliasChoices("B", "b"), examples=['{ mass = "1778 ± 36 kg", … }']
    )

    @model_validator(mode="after")
    def _something_is_known_after_impact(self) -> VehiclesEntry:
        vehicles = (self.A, self.B)
        if not any(v.rest or v.departure or v.marks or v.end_of_rotation for v in vehicles):
            raise fault(
                "nothing is known of either after the impact; "
                f"write rest = {_REST}, departure, marks or end_of_rotation of one"
            )
        return self


class ImpactEntry(_Table):
    """`[impact]`: where and along which line the vehicles touched."""

    point: tuple[ImpactCoordinate, ImpactCoordinate] = Field(
        examples=['["0 ± 0.3 m", "0 ± 0.3 m"]']
    )
    contact_line: ContactLine
    interlocked: bool = Field(default=False, strict=True, examples=["true"])


class EdgeEntry(_Table):
    """`edge` of a surface: the straight line beyond which it lies."""

    point: tuple[EdgeCoordinate, EdgeCoordinate] = Field(examples=['["0 m", "4 m"]'])
    direction: EdgeDirection
    side: Literal["left", "right"] = Field(examples=['"left" or "right"'])
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

    @model_validator(mode="after")
    def _friction_is_known(self) -> SurfaceEntry:
        if self.friction is None and self.kind is None:
            fix = 'missing; write friction = "0.50 ± 0.03", or kind = "dry asphalt"'
            raise fault(fix, "friction")
        return self


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
    """`[priors.omega_b]` and `[priors.Omega]`: how large a yaw rate may be."""

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


_ROAD = '{ road = { friction = "0.50 ± 0.03" } }'


def _one_without_edge(surfaces: dict[str, SurfaceEntry]) -> dict[str, SurfaceEntry]:
    bare = [name for name, surface in surfaces.items() if surface.edge is None]
    if len(bare) != 1:
        found = f"{', '.join(bare)} have none" if bare else "here none is without"
        raise fault(f"write an edge for every surface but one, the road; {found}")
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
    impact: ImpactEntry = Field(
        examples=['{ point = ["0 ± 0.3 m", "0 ± 0.3 m"], contact_line = "-8.9 ± 3 deg" }']
    )
    surfaces: Annotated[dict[SurfaceName, SurfaceEntry], AfterValidator(_one_without_edge)] = Field(
        {}, max_length=20, examples=[_ROAD]
    )
    priors: PriorsEntry = Field(PriorsEntry(), examples=["{ speed_b = { … } }"])

    @model_validator(mode="after")
    def _what_slid_slid_on_something(self) -> SceneEntry:
        slid = any(
            v.rest or v.marks or v.end_of_rotation or v.approach.skid
            for v in (self.vehicles.A, self.vehicles.B)
        )
        if slid and not self.surfaces:
            raise fault(f"missing; write surfaces = {_ROAD}", "surfaces")
        return self
