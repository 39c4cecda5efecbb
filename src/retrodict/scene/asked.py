"""Questions asked of a reconstruction, as frozen records, and the reader of propositions.

A proposition is read by a regular expression; nothing of it is ever evaluated.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from retrodict.scene import units
from retrodict.scene.measured import Measured
from retrodict.scene.quantities import DERIVED, REPORTED, SPEEDS, describe
from retrodict.scene.units import QuantityError, read_quantity

if TYPE_CHECKING:
    import numpy as np


_AT_IMPACT = {"impact_speed_a": "speed_a", "impact_speed_b": "speed_b"}
ASKABLE = tuple(dict.fromkeys((*REPORTED, *_AT_IMPACT, *DERIVED, "closing_speed")))
BEFORE = (*SPEEDS, *_AT_IMPACT)

_DIMENSIONS = {
    "speed": units.SPEED,
    "angle": units.ANGLE,
    "yaw rate": units.YAW_RATE,
    "energy": units.ENERGY,
    "number": units.NUMBER,
}
_ABOVE = r">=|>|≥|above|over|at least"
_BELOW = r"<=|<|≤|below|under|at most"
_NAME = r"([A-Za-z_]{1,40})"
_ONE_LIMIT = re.compile(rf"{_NAME} ?(?:({_ABOVE})|({_BELOW})) ?(.{{1,60}})")
_TWO_LIMITS = re.compile(rf"(.{{1,60}}?) ?(?:<=|<|≤) ?{_NAME} ?(?:<=|<|≤) ?(.{{1,60}})")
_BETWEEN = re.compile(rf"{_NAME} between (.{{1,60}}) and (.{{1,60}})")
_LENGTH = 160


@dataclass(frozen=True, slots=True)
class Proposition:
    """Proposition that a quantity lies between two limits (SI units, radians), one maybe infinite.

    Args:
        name: flat name of the quantity, as written; `meant` replaces it by the one that it stands for.
        low: lower limit, exclusive.
        high: upper limit, exclusive.
        text: proposition as it was written.
    """

    name: str
    low: float
    high: float
    text: str

    def meant(self, skidded: Collection[str]) -> Proposition:
        """The same proposition about the quantity that its name stands for in a scene.

        A speed limit concerns the speed at which a vehicle travelled. For a vehicle that skidded up to
        the impact, that is the speed before the skid, unless the impact speed is asked for by name.

        Args:
            skidded: vehicles with a measured skid up to the impact.
        """
        v = self.name[-1]
        if self.name in _AT_IMPACT:
            return replace(self, name=_AT_IMPACT[self.name])
        if self.name in (f"speed_{v}", f"travelling_speed_{v}"):
            return replace(self, name=f"travelling_speed_{v}" if v in skidded else f"speed_{v}")
        return self

    def holds(self, draws: np.ndarray) -> np.ndarray:
        """Mask of the draws for which the proposition holds; False for a draw that is not a number."""
        return (draws > self.low) & (draws < self.high)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two propositions about one speed, of which at most one holds."""

    first: Proposition
    second: Proposition

    def meant(self, skidded: Collection[str]) -> Comparison:
        """The same comparison of the speed that its name stands for; see `Proposition.meant`."""
        return Comparison(self.first.meant(skidded), self.second.meant(skidded))


@dataclass(frozen=True, slots=True)
class Avoidance:
    """Question whether a driver could have avoided the impact at the speed limit (SI units).

    Args:
        vehicle: vehicle of that driver, "a" or "b".
        limit: speed limit, m/s.
        reaction: time from the perception of the hazard to braking, s.
        deceleration: deceleration when braking, m/s².
        seen_time: time before the impact at which the hazard could be perceived, s; None where it
            follows from `seen_distance`, or from the skid and the reaction time.
        seen_distance: distance travelled from that perception to the impact, m.
        clear: distance that the other vehicle had yet to travel at the impact to clear the path, m;
            None where it follows from both outlines and directions of travel.
    """

    vehicle: Literal["a", "b"]
    limit: float
    reaction: Measured
    deceleration: Measured
    seen_time: Measured | None = None
    seen_distance: Measured | None = None
    clear: Measured | None = None


@dataclass(frozen=True, slots=True)
class Questions:
    """Questions asked of a reconstruction.

    Args:
        probabilities: propositions whose probabilities are asked.
        comparisons: pairs of propositions whose likelihood ratios are asked.
        avoidance: questions whether a driver could have avoided the impact.
        time_distance: time before the impact at which the table of the vehicles' distances begins, s;
            None for no table.
        corners: whether the range over all inputs at their limits is asked.
        one_at_a_time: whether the effect of each measurement is asked.
        checks: whether the named checks of the field are asked.
    """

    probabilities: tuple[Proposition, ...] = ()
    comparisons: tuple[Comparison, ...] = ()
    avoidance: tuple[Avoidance, ...] = ()
    time_distance: float | None = None
    corners: bool = False
    one_at_a_time: bool = True
    checks: bool = True


def read_proposition(text: object) -> Proposition:
    """A proposition as people write it.

    Args:
        text: "speed_b > 45 mph", "speed_b at most 45 mph", "40 mph < speed_b < 50 mph" or "speed_b
            between 40 mph and 50 mph"; any reported quantity, in any unit that `units` reads.

    Returns:
        The proposition in SI units or radians.

    Raises:
        QuantityError: the text is no proposition; says what to write instead.
    """
    example = 'write it like "speed_b > 45 mph" or "40 mph < speed_b < 50 mph"'
    if not isinstance(text, str) or len(text) > _LENGTH:
        raise QuantityError(f"not a proposition; {example}")
    plain = " ".join(text.split())
    if match := _ONE_LIMIT.fullmatch(plain):
        name, above, _, limit = match.groups()
        value = _limit(name, limit)
        low, high = (value, math.inf) if above else (-math.inf, value)
    elif match := _BETWEEN.fullmatch(plain):
        name, *limits = match.groups()
        low, high = (_limit(name, limit) for limit in limits)
    elif match := _TWO_LIMITS.fullmatch(plain):
        least, name, most = match.groups()
        low, high = _limit(name, least), _limit(name, most)
    else:
        raise QuantityError(f"not a proposition; {example}")
    if not low < high:
        raise QuantityError("holds for no value; write the smaller limit first")
    return Proposition(name, low, high, plain)


def read_comparison(first: Proposition, second: Proposition) -> Comparison:
    """Two propositions about one speed before the impact that exclude each other.

    Raises:
        QuantityError: they are not about one such speed, or may both hold; says what to write instead.
    """
    example = 'write them like "speed_b at most 45 mph" and "speed_b at least 55 mph"'
    if first.name != second.name or first.name not in BEFORE:
        names = ", ".join(BEFORE)
        raise QuantityError(f"not two propositions about one of {names}; {example}")
    if max(first.low, second.low) < min(first.high, second.high):
        raise QuantityError(f"both may hold at once; {example}")
    return Comparison(first, second)


def _limit(name: str, text: str) -> float:
    """A limit of a quantity, in SI units or radians."""
    if name not in ASKABLE:
        names = ", ".join(ASKABLE)
        raise QuantityError(f"{name} is not a reported quantity; write one of {names}")
    dimension = _DIMENSIONS[describe(name)[1]]
    example = f"45 {dimension.units[0]}" if dimension.units else "0.2"
    reading = read_quantity(text, dimension, example)
    if reading.sd is not None:
        raise QuantityError(f'a limit has no uncertainty; write it like "{example}"')
    return reading.value
