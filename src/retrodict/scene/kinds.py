"""What each quantity of a scene file accepts: its dimension, bounds, error law and default."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field, GetCoreSchemaHandler, ValidatorFunctionWrapHandler, WrapValidator
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from retrodict.scene import units
from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.departure import ITEMS
from retrodict.scene.energy import CLASS_STIFFNESS_ERROR
from retrodict.scene.records import UNKNOWN, Law, Measured


def fault(fix: str, at: str = "") -> PydanticCustomError:
    """The error by which a validator says what to write instead, at a key below its own."""
    return PydanticCustomError("fault", "{fix}", {"fix": fix, "at": at})


@dataclass(frozen=True, slots=True)
class Kind:
    """What a key accepts: the annotation that reads it into a `Measured`.

    Args:
        dimension: what it measures.
        low: the least value accepted, in the first of the dimension's units.
        high: the greatest, likewise.
        example: how it could be written.
        law: error law.
        uncertainty: "optional" (exact without one, or the default's), "required" or "refused".
        default: key of `DEFAULTS` for the uncertainty where none is written.
        advice: added to a complaint about the uncertainty, or where that is optional, the bounds.
    """

    dimension: units.Dimension
    low: float
    high: float
    example: str
    law: Law = "normal"
    uncertainty: Literal["optional", "required", "refused"] = "optional"
    default: str = ""
    advice: str = ""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def read(self, raw: object) -> Measured:
        """A TOML value as a measured quantity in SI units or radians.

        Args:
            raw: see `units.read_quantity`; a quantity that was read already stays as it is.

        Returns:
            The quantity, with the default uncertainty where it has one and none is written.

        Raises:
            PydanticCustomError: it cannot be read, or is out of bounds; says what to write.
        """
        if isinstance(raw, Measured):  # from the library of vehicles
            return raw
        try:
            reading = units.read_quantity(raw, self.dimension, self.example)
            worth = units.factor(self.dimension.units[0], self.dimension) if self._unit else 1.0
        except units.QuantityError as found:
            raise fault(found.fix, found.at) from None
        span = (self.high - self.low) * worth
        slack = 1e-12 * span  # the bounds themselves are accepted, whatever the rounding
        if not self.low * worth - slack <= reading.value <= self.high * worth + slack:
            low, high = (
                units.in_unit_of(raw, end * worth, self.dimension) for end in (self.low, self.high)
            )
            bounds = f"between {low.partition(' ')[0]} and {high}"
            advice = self._advice if self.uncertainty == "optional" else ""
            raise fault(f"not plausible; write {self.dimension.phrase} {bounds}{advice}")
        if self.uncertainty == "refused" and reading.sd is not None:
            raise fault(
                f'no uncertainty is used here; write it like "{self.example}"{self._advice}'
            )
        if self.uncertainty == "required" and reading.sd is None:
            raise fault(
                "needs an uncertainty (one standard deviation); "
                f'write it like "{self.example}"{self._advice}'
            )
        sd, source, assumed = reading.sd, reading.source, False
        if sd is None and self.default:
            default = DEFAULTS[self.default]
            sd, assumed = default.amount(reading.value), True
            source = "; ".join(s for s in (source, f"uncertainty assumed: {default}") if s)
        if sd is not None and not 1e-9 * span <= sd <= span:
            raise fault(f'not a plausible uncertainty; write it like "{self.example}"')
        if self.law == "lognormal" and sd is not None and sd > reading.value:
            said = "default uncertainty is" if assumed else "uncertainty is"
            raise fault(f'its {said} over 100 %; write a smaller one, like "{self.example}"')
        if (
            self.law == "logitnormal"
            and sd is not None
            and sd > reading.value * (1 - reading.value)
        ):
            raise fault(
                "its uncertainty is over value (1 - value), too wide for a share between 0 and 1; "
                f'write a smaller one, like "{self.example}"'
            )
        return Measured(reading.value, sd or 0.0, self.law, source, "sd" if assumed else "")

    @property
    def _unit(self) -> str:
        return self.dimension.units[0] if self.dimension.units else ""

    @property
    def _advice(self) -> str:
        return f"; {self.advice}" if self.advice else ""


_OF_DEPARTURE = {"angle": units.ANGLE, "speed": units.SPEED, "yaw rate": units.YAW_RATE}


def of_departure(name: str) -> Kind:
    """What the key of a measurement just after the impact accepts.

    Args:
        name: in `departure.ITEMS`.
    """
    item = ITEMS[name]
    uncertainty: Literal["optional", "required"] = "optional" if item.default else "required"
    dimension = _OF_DEPARTURE[item.dimension]
    return Kind(
        *(dimension, item.low, item.high, item.example),
        uncertainty=uncertainty,
        default=item.default,
    )


# bounds are generous: they catch slips of a unit or a digit, not unusual vehicles
Mass = Annotated[
    Measured, Kind(units.MASS, 50, 100_000, "1857 ± 37 kg", "lognormal", default="mass")
]
YawInertia = Annotated[
    Measured,
    Kind(units.INERTIA, 5, 5e6, "3374 ± 270 kg m^2", "lognormal", default="yaw_inertia"),
]
AxleDistance = Annotated[Measured, Kind(units.LENGTH, 0.05, 20, "1.35 m", "lognormal")]
Track = Annotated[Measured, Kind(units.LENGTH, 0.2, 5, "1.54 m", "lognormal")]
HeightOfCentre = Annotated[
    Measured,
    Kind(units.LENGTH, 0.1, 3, "0.53 ± 0.03 m", "lognormal", default="cg_height"),
]
_OUTLINE = "it is for drawing"
OutlineLength = Annotated[
    Measured, Kind(units.LENGTH, 0.5, 30, "5.2 m", uncertainty="refused", advice=_OUTLINE)
]
OutlineWidth = Annotated[
    Measured, Kind(units.LENGTH, 0.3, 6, "1.8 m", uncertainty="refused", advice=_OUTLINE)
]
PoleDiameter = Annotated[
    Measured, Kind(units.LENGTH, 0.02, 10, "0.3 m", uncertainty="refused", advice=_OUTLINE)
]
ImpactDistance = Annotated[
    Measured,
    Kind(units.LENGTH, 0.01, 20, "2.09 ± 0.05 m", "lognormal", default="impact_distance"),
]
ImpactAngle = Annotated[
    Measured, Kind(units.ANGLE, -360, 360, "10 ± 2 deg", default="impact_angle")
]
Heading = Annotated[Measured, Kind(units.ANGLE, -360, 360, "180 ± 2 deg", default="heading")]


def _or_unknown(raw: object, read: ValidatorFunctionWrapHandler) -> Measured | str:
    if isinstance(raw, str) and not any(c.isdigit() for c in raw):
        if raw.strip().casefold() != UNKNOWN:
            raise fault('write a number with its unit, or "unknown" for a vehicle that slid')
        return UNKNOWN
    measured: Measured = read(raw)
    return measured


_DIRECTION = Kind(units.ANGLE, -360, 360, "180 ± 2 deg", default="direction")
Direction = Annotated[Measured, _DIRECTION]
ApproachDirection = Annotated[
    Measured | str,
    _DIRECTION,
    WrapValidator(_or_unknown),
    Field(examples=['"180 ± 2 deg", or "unknown"']),
]
ApproachYawRate = Annotated[
    Measured | str,
    Kind(units.YAW_RATE, -2000, 2000, "0 ± 2 deg/s", default="yaw_rate"),
    WrapValidator(_or_unknown),
    Field(examples=['"0 ± 2 deg/s", or "unknown"']),
]
Speed = Annotated[
    Measured,
    Kind(units.SPEED, 0, 150, "45 ± 2 mph", uncertainty="required"),
]
_RECORDED = "that of all goes into the key uncertainty"
RecordedSpeed = Annotated[
    Measured, Kind(units.SPEED, 0, 150, "40 mph", uncertainty="refused", advice=_RECORDED)
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
        advice="it is itself one standard deviation",
    ),
]
Skid = Annotated[Measured, Kind(units.LENGTH, 0.1, 500, "12 ± 0.5 m", "lognormal", default="skid")]
Course = Annotated[Measured, of_departure("direction")]
_ORIGIN = "count from an origin near the impact"
RestCoordinate = Annotated[
    Measured,
    Kind(units.LENGTH, -1000, 1000, "-5.1 ± 0.15 m", default="rest_position", advice=_ORIGIN),
]
RestHeading = Annotated[
    Measured,
    Kind(
        units.ANGLE,
        -360,
        360,
        "215 ± 3 deg",
        default="rest_heading",
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
EndCoordinate = Annotated[
    Measured, Kind(units.LENGTH, -1000, 1000, "3 ± 0.5 m", uncertainty="required")
]
EndHeading = Annotated[Measured, Kind(units.ANGLE, -360, 360, "20 ± 5 deg", uncertainty="required")]
ImpactCoordinate = Annotated[
    Measured,
    Kind(units.LENGTH, -1000, 1000, "0 ± 0.3 m", default="impact_point", advice=_ORIGIN),
]
ContactLine = Annotated[
    Measured, Kind(units.ANGLE, -180, 180, "-8.9 ± 3 deg", uncertainty="required")
]
EnergyLost = Annotated[
    Measured,
    Kind(
        units.ENERGY,
        0,
        1e8,
        "60 ± 25 kJ",
        uncertainty="required",
        advice=f"from crush and stiffness by class it is {CLASS_STIFFNESS_ERROR:.0%} or more",
    ),
]
Friction = Annotated[
    Measured,
    Kind(
        units.NUMBER,
        0.01,
        1.5,
        "0.50 ± 0.03",
        "lognormal",
        uncertainty="required",
        advice="0.03 suits two or more skid tests, 0.05 one test, 0.07 a table",
    ),
]
Grip = Annotated[Measured, Kind(units.NUMBER, 0.2, 2, "1 ± 0.05", "lognormal", default="grip")]


WHEEL_WORDS = ("locked", "rolling", "rolling, in gear", "damaged")


def _wheel(raw: object, read: ValidatorFunctionWrapHandler) -> Measured | str:
    if isinstance(raw, str) and raw in WHEEL_WORDS:
        return raw
    if isinstance(raw, str) and not any(c.isdigit() for c in raw):
        words = ", ".join(f'"{word}"' for word in WHEEL_WORDS)
        raise fault(f'write {words}, or its braking force over the friction, like "0.3 ± 0.1"')
    measured: Measured = read(raw)
    return measured


# a word stays one: what it means hangs on the road's friction
Wheel = Annotated[
    Measured | str,
    Kind(units.NUMBER, 0, 1, "0.3 ± 0.1", "logitnormal"),
    WrapValidator(_wheel),
    Field(examples=['"locked"']),
]
DragFactor = Annotated[Measured, Kind(units.NUMBER, 0.1, 10, "1 ± 0.3", "lognormal")]
_ERROR = "it is itself one standard deviation"
RunOutPosition = Annotated[
    Measured, Kind(units.SHARE, 0, 50, "4 %", uncertainty="refused", advice=_ERROR)
]
RunOutHeading = Annotated[
    Measured, Kind(units.ANGLE, 0, 90, "8 deg", uncertainty="refused", advice=_ERROR)
]
Steer = Annotated[Measured, Kind(units.ANGLE, -90, 90, "0 ± 2 deg")]
SpeedDependence = Annotated[Measured, Kind(units.INVERSE_SPEED, 0, 0.2, "0.002 s/m")]
RoadGrade = Annotated[
    Measured,
    Kind(
        units.GRADE,
        0,
        30,
        "4 ± 0.5 %",
        uncertainty="required",
        advice="0.2 % suits a survey, 0.5 % a level laid on the road, 1 % a map",
    ),
]
Uphill = Annotated[Measured, Kind(units.ANGLE, -360, 360, "90 ± 5 deg", default="uphill")]
_EDGE = "that of the edge goes into its key uncertainty"
EdgeCoordinate = Annotated[
    Measured,
    Kind(units.LENGTH, -1000, 1000, "4 m", uncertainty="refused", advice=_EDGE),
]
EdgeDirection = Annotated[
    Measured,
    Kind(units.ANGLE, -360, 360, "0 deg", uncertainty="refused", advice=_EDGE),
]
_CORNERS = "that of the outline goes into its key uncertainty"
OutlineCoordinate = Annotated[
    Measured,
    Kind(units.LENGTH, -1000, 1000, "4 m", uncertainty="refused", advice=_CORNERS),
]
EdgeUncertainty = Annotated[
    Measured,
    Kind(
        units.LENGTH,
        0.0001,
        100,
        "0.2 m",
        uncertainty="refused",
        advice="it is itself one standard deviation",
    ),
]
_EXACT = "a limit is exact"
SpeedLimit = Annotated[
    Measured, Kind(units.SPEED, 1, 150, "45 mph", uncertainty="refused", advice=_EXACT)
]
ReactionTime = Annotated[Measured, Kind(units.TIME, 0.05, 20, "1.5 ± 0.3 s", "lognormal")]
Deceleration = Annotated[Measured, Kind(units.DECELERATION, 0.1, 20, "7 ± 0.7 m/s^2", "lognormal")]
TimeBefore = Annotated[Measured, Kind(units.TIME, 0.05, 60, "2.5 ± 0.3 s", "lognormal")]
DistanceBefore = Annotated[Measured, Kind(units.LENGTH, 0.1, 1000, "40 ± 3 m", "lognormal")]
Span = Annotated[Measured, Kind(units.TIME, 0.1, 60, "3 s", uncertainty="refused")]
_MARK = "that of the mark goes into its key uncertainty"
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
        advice="it is itself one standard deviation",
    ),
]
_SPREAD = "it is a parameter of a prior"
SpeedScale = Annotated[
    Measured, Kind(units.SPEED, 0.1, 150, "40 m/s", uncertainty="refused", advice=_SPREAD)
]
YawRateScale = Annotated[
    Measured, Kind(units.YAW_RATE, 0.1, 2000, "1 rad/s", uncertainty="refused", advice=_SPREAD)
]
NumberScale = Annotated[
    Measured, Kind(units.NUMBER, 0.001, 10, "0.2", uncertainty="refused", advice=_SPREAD)
]
BetweenVehicles = Annotated[
    Measured, Kind(units.NUMBER, 0.01, 5, "0.55", uncertainty="refused", advice=_SPREAD)
]
MomentCentre = Annotated[
    Measured, Kind(units.NUMBER, -1, 1, "1", uncertainty="refused", advice=_SPREAD)
]
