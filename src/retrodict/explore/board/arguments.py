"""Arguments of the board's actions, such as a browser sends: nothing in them is trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from retrodict.explore.board.plan import FILE, Car, Plan
from retrodict.explore.board.state import Place
from retrodict.scene.errors import Problem, SceneError, shown
from retrodict.scene.units import LENGTH, QuantityError, read_quantity

_FARTHEST = 1000.0  # m: of a coordinate, as the schema has it
WORDS = 2000  # characters of what is typed


@dataclass(frozen=True, slots=True)
class Given:
    """What an action is given, such as by a browser: nothing in it is trusted.

    Args:
        values: values by name, as JSON has them.
    """

    values: Mapping[str, Any]

    def number(self, name: str, most: float = _FARTHEST) -> float:
        """A finite number of at most this size."""
        value = self.values.get(name)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= most:
            raise refused(f"{name}: write a number from {-most:g} to {most:g}")
        return float(value)

    def place(self, x: str = "x", y: str = "y") -> Place:
        """A place on the ground, m."""
        return self.number(x), self.number(y)

    def length(self, name: str) -> float:
        """A length: metres, or a text with its unit."""
        value = self.values.get(name)
        if not isinstance(value, str):
            return self.number(name)
        try:
            return read_quantity(value, LENGTH, "12.5 m").value
        except QuantityError as error:
            raise refused(f"{shown(value)}: {error.fix}") from None

    def places(self, name: str, least: int, most: int) -> list[Place]:
        """Several places on the ground, m."""
        value = self.values.get(name)
        if not isinstance(value, list) or not least <= len(value) <= most:
            raise refused(
                f"{name}: click {least if least == most else f'{least} to {most}'} places"
            )
        pairs = [
            each if isinstance(each, list) and len(each) == 2 else [None] * 2 for each in value
        ]
        return [Given({"x": x, "y": y}).place() for x, y in pairs]

    def word(self, name: str, words: Sequence[str]) -> str:
        """One of some words."""
        value = self.values.get(name)
        if value not in words:
            raise refused(f"{name}: write one of {', '.join(words)}")
        return str(value)

    def text(self, name: str) -> str:
        """A short text."""
        value = self.values.get(name)
        if not isinstance(value, str) or len(value) > WORDS:
            raise refused(f"{name}: write a short text")
        return value.strip()

    def car(self, plan: Plan) -> Car:
        """A vehicle that the file has a table for."""
        letter = self.word("vehicle", ("A", "B"))
        if letter not in plan.cars:
            raise refused(f"there is no vehicle {letter}: A struck a barrier")
        return plan.cars[letter]


def refused(fix: str) -> SceneError:
    """The refusal of an action, with what to do instead."""
    return SceneError(FILE, [Problem("", "", fix)])


def reason(error: SceneError | OSError) -> str:
    """Why something was refused, in a line."""
    if isinstance(error, SceneError):
        return "; ".join(str(problem) for problem in error.problems)
    return f"not kept: {error}"
