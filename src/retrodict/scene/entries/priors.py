"""The entries of the priors of the unknowns, which replace the defaults."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import Field, create_model, model_validator

from retrodict.scene import units
from retrodict.scene.entries.table import Table, one_line
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.measured import Measured
from retrodict.scene.priors import FAMILIES

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


class PriorEntry(Table):
    """Keys that every override of a prior has."""

    source: Annotated[str, one_line(200)] = Field(examples=['"survey of speeds on this road"'])

    @model_validator(mode="after")
    def _says_one_prior(self) -> PriorEntry:
        of_families = {key for keys in FAMILIES.values() for key in keys}
        fields = type(self).model_fields.keys() - {"source", "family"}
        written = {key for key in fields if getattr(self, key) is not None}
        family = getattr(self, "family", None)
        if family is None:
            _has_no_family(written & of_families)
            if not written:
                own = [k for k in type(self).model_fields if k in fields - of_families]
                if own == ["scale"]:
                    raise fault('missing; write scale = "40 m/s", or a family', "scale")
                raise fault(f"overrides nothing; write one or more of {', '.join(own)}")
            return self
        keys = FAMILIES[family]
        both = " and ".join(keys)
        if missing := [key for key in keys if key not in written]:
            raise fault(f'missing; a prior of family = "{family}" has {both}', missing[0])
        if other := sorted(written - set(keys)):
            raise fault(f'a prior of family = "{family}" has {both}; leave this out', other[0])
        _has_an_extent(family, *(getattr(self, key) for key in keys))
        return self


def _has_no_family(written: set[str]) -> None:
    """Refuse the numbers of a family that is not named."""
    if written:
        key = min(written)
        families = " or ".join(f'family = "{name}"' for name, own in FAMILIES.items() if key in own)
        raise fault(f"which distribution this is a number of is not said; write {families}", key)


def _has_an_extent(family: str, first: Measured, second: Measured | None = None) -> None:
    """Refuse bounds that are exchanged, and a log-normal about zero."""
    if family == "uniform" and second and first.value >= second.value:
        raise fault("not above low; exchange them", "high")
    if family == "lognormal" and first.value <= 0:
        raise fault("a log-normal quantity is positive; write a mean above 0", "mean")


def _with_families[T: PriorEntry](
    dimension: units.Dimension, low: float, high: float, example: str, spread: str, *, beta: bool
) -> Callable[[type[T]], type[T]]:
    """A decorator that adds the families of priors, and their numbers, to an override.

    Args:
        dimension: dimension of the unknown.
        low: least value of the unknown, in the first of the dimension's units.
        high: greatest value that is plausible, in the same unit.
        example: example of a value.
        spread: example of a standard deviation.
        beta: whether the unknown may have a beta distribution, which lies between 0 and 1.
    """

    def number(
        dimension: units.Dimension, least: float, most: float, example: str
    ) -> tuple[Any, None]:
        kind = Kind(dimension, least, most, example, uncertainty="refused", advice=_SPREAD)
        return Annotated[Measured, kind] | None, None

    def complete(table: type[T]) -> type[T]:
        names = [name for name in FAMILIES if beta or name != "beta"]
        listed = ", ".join(f'"{name}"' for name in names)
        keys: dict[str, Any] = {
            "family": (Literal[*names] | None, Field(None, examples=[listed]))
        } | {key: number(dimension, low, high, example) for key in ("mean", "low", "high", "value")}
        keys["sd"] = number(dimension, 0.001, high, spread)
        if beta:
            keys |= {key: number(units.NUMBER, 0.1, 1000, "2") for key in FAMILIES["beta"]}
        name, module = table.__name__, table.__module__
        return create_model(name, __base__=table, __doc__=table.__doc__, __module__=module, **keys)

    return complete


@_with_families(units.SPEED, 0, 150, "15 m/s", "4 m/s", beta=False)
class SpeedPriorEntry(PriorEntry):
    """`[priors.speed_a]` and `speed_b`: how large a speed may be."""

    scale: SpeedScale | None = None


class ImpulsePriorEntry(PriorEntry):
    """`[priors.impulse]`: how large a change of speed may be."""

    scale: SpeedScale


class YawRatePriorEntry(PriorEntry):
    """`[priors.omega_a]`, `omega_b` and `Omega`: how large a yaw rate may be."""

    scale: YawRateScale


@_with_families(units.NUMBER, 0, 1, "0.1", "0.05", beta=True)
class RestitutionPriorEntry(PriorEntry):
    """`[priors.e]`: the scale of e in fast and in slow impacts, and the closing speed between them."""

    fast: NumberScale | None = None
    slow: NumberScale | None = None
    over: SpeedScale | None = None


@_with_families(units.NUMBER, 0, 5, "0.5", "0.1", beta=True)
class MuPriorEntry(PriorEntry):
    """`[priors.mu]`: how far mu is below its critical value, and friction where sliding goes on."""

    scale: NumberScale | None = None
    friction: BetweenVehicles | None = None


@_with_families(units.NUMBER, -1, 1, "0.9", "0.2", beta=True)
class MomentPriorEntry(PriorEntry):
    """`[priors.e_m]`: centre and scale of e_m."""

    centre: MomentCentre | None = None
    scale: NumberScale | None = None


class PriorsEntry(Table):
    """`[priors]`: priors of the unknowns, which replace the defaults."""

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
    impulse: ImpulsePriorEntry | None = Field(
        default=None, examples=['{ scale = "20 m/s", source = "…" }']
    )
    Omega: YawRatePriorEntry | None = Field(
        default=None, examples=['{ scale = "5 rad/s", source = "…" }']
    )
