"""The entries of the priors of the unknowns, which replace the defaults."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from retrodict.scene import units
from retrodict.scene.entries.table import Table, one_line
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.measured import Measured

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
    """`[priors.e]`: the scale of e in fast and in slow impacts, and the closing speed between them."""

    fast: NumberScale | None = None
    slow: NumberScale | None = None
    over: SpeedScale | None = None


class MuPriorEntry(PriorEntry):
    """`[priors.mu]`: how far mu is below its critical value, and friction where sliding goes on."""

    scale: NumberScale | None = None
    friction: BetweenVehicles | None = None


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
    impulse: SpeedPriorEntry | None = Field(
        default=None, examples=['{ scale = "20 m/s", source = "…" }']
    )
    Omega: YawRatePriorEntry | None = Field(
        default=None, examples=['{ scale = "5 rad/s", source = "…" }']
    )
