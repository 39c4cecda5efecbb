"""Kinds of values that a scene file's keys accept: dimension, bounds, error law, default uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from retrodict.scene import units
from retrodict.scene.defaults import Default
from retrodict.scene.measured import Law, Measured

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler
    from pydantic_core import CoreSchema, PydanticCustomError


def fault(fix: str, key: str = "") -> PydanticCustomError:
    """The error of a validator that says what to write instead, at this key below its own."""
    from pydantic_core import PydanticCustomError  # labels and records do without

    return PydanticCustomError("fault", "{fix}", {"fix": fix, "at": key})


@dataclass(frozen=True, slots=True)
class Kind:
    """Kind of value that a key accepts: the annotation that reads it into a `Measured`.

    Args:
        dimension: dimension of the quantity.
        low: the least value accepted, in the first of the dimension's units.
        high: the greatest value accepted, in the same unit.
        example: example of a written value.
        law: error law.
        uncertainty: "optional" (exact without one, or the default's), "required" or "refused".
        default: uncertainty where none is written.
        at_zero: uncertainty of a 0 that is written without one; None where it needs one as others do.
        advice: text added to a complaint about the uncertainty or, where that is optional, the bounds.
    """

    dimension: units.Dimension
    low: float
    high: float
    example: str
    law: Law = "normal"
    uncertainty: Literal["optional", "required", "refused"] = "optional"
    default: Default | None = None
    advice: str = ""
    at_zero: Default | None = None

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(self.read)

    def read(self, raw: object) -> Measured:
        """A TOML value as a measured quantity in SI units or radians.

        Args:
            raw: value as for `units.read_quantity`; a quantity that was read already stays as it is.

        Returns:
            The quantity, with the default uncertainty where there is one and none is written.

        Raises:
            PydanticCustomError: it cannot be read, or is out of bounds; says what to write.
        """
        if isinstance(raw, Measured):  # from the library of vehicles
            return raw
        try:
            reading = units.read_quantity(raw, self.dimension, self.example)
            worth = units.factor(self.dimension.units[0], self.dimension) if self._unit else 1.0
        except units.QuantityError as found:
            raise fault(found.fix, found.key) from None
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
        default = self.default if reading.value or self.default else self.at_zero
        if self.uncertainty == "required" and reading.sd is None and default is None:
            raise fault(
                "needs an uncertainty (one standard deviation); "
                f'write it like "{self.example}"{self._advice}'
            )
        sd, source, assumed = reading.sd, reading.source, False
        if sd is None and default:
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
