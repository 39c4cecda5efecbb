"""Questions asked of a reconstruction, as frozen records, and the reader of propositions.

A proposition is read by a small grammar (`read_proposition`); nothing of it is ever evaluated.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from retrodict.scene import units
from retrodict.scene.errors import shown
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
_QUANTITY = rf"{_NAME}(?: ?([+−-]) ?{_NAME})?"
_ONE_LIMIT = re.compile(rf"{_QUANTITY} ?(?:({_ABOVE})|({_BELOW})) ?(.{{1,60}})")
_TWO_LIMITS = re.compile(rf"(.{{1,60}}?) ?(?:<=|<|≤) ?{_QUANTITY} ?(?:<=|<|≤) ?(.{{1,60}})")
_BETWEEN = re.compile(rf"{_QUANTITY} between (.{{1,60}}) and (.{{1,60}})")
_WORDS = re.compile(r"([()]|\b(?:and|or)\b)", re.IGNORECASE)
_LENGTH = 160
_TEXT = 640  # characters of a whole compound
_PARTS = 12  # propositions of a compound
_DEPTH = 5  # parentheses within parentheses
_NEVER_NEGATIVE = (*BEFORE, "delta_v_a", "delta_v_b")


@dataclass(frozen=True, slots=True)
class Proposition:
    """Proposition that a quantity lies between two limits (SI units, radians), or several joined.

    One record for both, because stored results lose infinite limits within a union of types.

    Args:
        name: flat name of the quantity, as written; `meant` replaces it by the one that it stands for.
        low: lower limit, exclusive, maybe infinite.
        high: upper limit, exclusive, maybe infinite.
        text: proposition as it was written.
        other: flat name of a quantity that is added to the first or subtracted from it; empty for none.
        sign: sign of the other quantity, 1 or -1.
        joined: "and" where all of `parts` have to hold, "or" where one has to; empty for a single one.
        parts: propositions that are joined, in the place of a quantity and limits of its own.
    """

    name: str
    low: float
    high: float
    text: str
    other: str = ""
    sign: Literal[1, -1] = -1
    joined: Literal["", "and", "or"] = ""
    parts: tuple[Proposition, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Flat names of all quantities, each once."""
        if self.joined:
            return tuple(dict.fromkeys(name for each in self.parts for name in each.names))
        return (self.name, self.other) if self.other else (self.name,)

    def meant(self, skidded: Collection[str]) -> Proposition:
        """The same proposition about the quantities that its names stand for in a scene.

        A speed limit concerns the speed at which a vehicle travelled. For a vehicle that skidded up to
        the impact, that is the speed before the skid, unless the impact speed is asked for by name.

        Args:
            skidded: vehicles with a measured skid up to the impact.
        """
        name, other = (_meant(each, skidded) for each in (self.name, self.other))
        parts = tuple(each.meant(skidded) for each in self.parts)
        return replace(self, name=name, other=other, parts=parts)

    def compared(self, values: Callable[[str], np.ndarray]) -> tuple[np.ndarray, ...]:
        """Draws that are compared with limits; `values` gives those of a quantity by its flat name."""
        if self.joined:
            return tuple(draws for each in self.parts for draws in each.compared(values))
        own = values(self.name)
        return (own + self.sign * values(self.other) if self.other else own,)

    def holds(self, draws: np.ndarray) -> np.ndarray:
        """Mask of the draws between the limits; False for a draw that is not a number."""
        return (draws > self.low) & (draws < self.high)

    def holds_for(self, values: Callable[[str], np.ndarray]) -> np.ndarray:
        """Mask of the draws for which the proposition holds; `values` as of `compared`."""
        if not self.joined:
            return self.holds(*self.compared(values))
        first, *others = (each.holds_for(values) for each in self.parts)
        for mask in others:
            first = first & mask if self.joined == "and" else first | mask
        return first


def _meant(name: str, skidded: Collection[str]) -> str:
    """Flat name of the quantity that a name in a proposition stands for."""
    if name in _AT_IMPACT:
        return _AT_IMPACT[name]
    v = name[-1:]
    if name in (f"speed_{v}", f"travelling_speed_{v}"):
        return f"travelling_speed_{v}" if v in skidded else f"speed_{v}"
    return name


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
    """A proposition as people write it, or several joined by "and" and "or".

    The grammar, "and" binding closer than "or":

        any   = all {"or" all}
        all   = one {"and" one}
        one   = "(" any ")" | quantity (">" | "<") limit | limit "<" quantity "<" limit
              | quantity "between" limit "and" limit
        quantity = name [("+" | "-") name]

    Args:
        text: "speed_b > 45 mph", "speed_b at most 45 mph", "40 mph < speed_b < 50 mph", "speed_b
            between 40 mph and 50 mph", "speed_a - speed_b > 10 mph" or "speed_a > 35 mph and speed_b <
            20 mph"; any reported quantity, in any unit that `units` reads.

    Returns:
        The proposition in SI units or radians.

    Raises:
        QuantityError: the text is no proposition; says what to write instead.
    """
    if not isinstance(text, str) or len(text) > _TEXT:
        raise QuantityError(f"not a proposition; {_EXAMPLE}")
    plain = " ".join(text.split())
    words = [word.strip() for word in _WORDS.split(plain)]
    reader = _Reader([word for word in words if word])
    found = reader.any_of()
    if reader.next:
        raise QuantityError(f'{shown(reader.next)} stands where "and" or "or" has to; {_JOINED}')
    return replace(found, text=plain)


_EXAMPLE = 'write it like "speed_b > 45 mph" or "40 mph < speed_b < 50 mph"'
_JOINED = 'write it like "(speed_a > 35 mph or speed_b > 35 mph) and e < 0.2"'


class _Reader:
    """Recursive descent over the words of a compound: parentheses, "and", "or" and what is between."""

    def __init__(self, words: list[str]) -> None:
        self._words = words
        self._place = self._depth = self._count = 0

    @property
    def next(self) -> str:
        """The word to be read next, "and" and "or" in lower case; empty at the end."""
        word = self._words[self._place] if self._place < len(self._words) else ""
        return word.lower() if word.lower() in ("and", "or") else word

    def _take(self) -> str:
        word = self.next
        self._place += 1
        return word

    def any_of(self) -> Proposition:
        """Propositions joined by "or"."""
        return _joined("or", self._each("or", self._all_of))

    def _all_of(self) -> Proposition:
        return _joined("and", self._each("and", self._one))

    def _each(
        self, between: Literal["and", "or"], part: Callable[[], Proposition]
    ) -> Iterator[Proposition]:
        yield part()
        while self.next == between:
            self._take()
            yield part()

    def _one(self) -> Proposition:
        word = self._take()
        if word == "(":
            self._depth += 1
            if self._depth > _DEPTH:
                raise QuantityError(f"more than {_DEPTH} parentheses within each other; {_JOINED}")
            found = self.any_of()
            if self._take() != ")":
                raise QuantityError(f"a parenthesis is not closed; {_JOINED}")
            self._depth -= 1
            return found
        if word in ("", ")", "and", "or"):
            raise QuantityError(f"not a proposition; {_EXAMPLE}")
        if " between " in f"{word} " and self.next == "and":  # of its two limits
            word = f"{word} {self._take()} {self._take()}"
        self._count += 1
        if self._count > _PARTS:
            raise QuantityError(f"more than {_PARTS} propositions in one; ask several questions")
        return _simple(word)


def _joined(word: Literal["and", "or"], parts: Iterator[Proposition]) -> Proposition:
    """One proposition as it is, several as a compound; those of the same kind become one."""
    found: list[Proposition] = []
    for each in parts:
        found += each.parts if each.joined == word else [each]
    if len(found) == 1:
        return found[0]
    text = f" {word} ".join(each.text for each in found)
    return Proposition("", -math.inf, math.inf, text, joined=word, parts=tuple(found))


def _simple(plain: str) -> Proposition:
    """A proposition without "and" and "or", but for those between two limits."""
    if len(plain) > _LENGTH:
        raise QuantityError(f"not a proposition; {_EXAMPLE}")
    if match := _ONE_LIMIT.fullmatch(plain):
        *quantity, above, _, limit = match.groups()
        value = _limit(quantity, limit)
        low, high = (value, math.inf) if above else (-math.inf, value)
    elif match := _BETWEEN.fullmatch(plain):
        *quantity, least, most = match.groups()
        low, high = _limit(quantity, least), _limit(quantity, most)
    elif match := _TWO_LIMITS.fullmatch(plain):
        least, *quantity, most = match.groups()
        low, high = _limit(quantity, least), _limit(quantity, most)
    else:
        raise QuantityError(f"not a proposition; {_EXAMPLE}")
    if not low < high:
        raise QuantityError("holds for no value; write the smaller limit first")
    name, sign, other = quantity
    if not other and high <= 0 and name in _NEVER_NEGATIVE:
        raise QuantityError(
            f'{name} is never below 0; of a vehicle that stood write "{name} < 1 mph"'
        )
    return Proposition(name, low, high, plain, other or "", 1 if sign == "+" else -1)


def read_comparison(first: Proposition, second: Proposition) -> Comparison:
    """Two propositions about one speed before the impact that exclude each other.

    Raises:
        QuantityError: they are not about one such speed, or may both hold; says what to write instead.
    """
    example = 'write them like "speed_b at most 45 mph" and "speed_b at least 55 mph"'
    names = ", ".join(BEFORE)
    if (
        first.joined
        or second.joined
        or first.names != second.names
        or first.names[0] not in BEFORE
        or first.other
    ):
        raise QuantityError(f"not two propositions about one of {names}; {example}")
    if max(first.low, second.low) < min(first.high, second.high):
        raise QuantityError(f"both may hold at once; {example}")
    return Comparison(first, second)


def _limit(quantity: list[str | None], text: str) -> float:
    """A limit of a quantity, or of two with a sign between them, in SI units or radians."""
    name, sign, other = quantity
    for each in (name, other):
        if each is not None and each not in ASKABLE:
            names = ", ".join(ASKABLE)
            raise QuantityError(f"{each} is not a reported quantity; write one of {names}")
    kind = describe(str(name))[1]
    if other is not None and (kind != describe(other)[1] or name == other):
        raise QuantityError(
            f"{name} {sign} {other} is no quantity; write two different ones of the same unit, "
            'like "speed_a - speed_b > 10 mph"'
        )
    dimension = _DIMENSIONS[kind]
    example = f"45 {dimension.units[0]}" if dimension.units else "0.2"
    reading = read_quantity(text, dimension, example)
    if reading.sd is not None:
        raise QuantityError(f'a limit has no uncertainty; write it like "{example}"')
    return reading.value
