"""A scene file written otherwise, which has to give the same answer: A and B exchanged, other units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from retrodict.scene import units

_OTHER = {
    "kg": "lb", "lb": "kg",
    "m": "ft", "ft": "m", "in": "m",
    "m/s": "mph", "mph": "m/s", "km/h": "ft/s", "ft/s": "km/h",
    "deg": "rad", "rad": "deg",
    "deg/s": "rad/s", "rad/s": "deg/s",
    "kg m^2": "slug ft^2", "lb ft s^2": "kg m^2", "slug ft^2": "kg m^2",
    "kJ": "ft lbf", "J": "ft lbf", "ft lbf": "kJ",
}  # fmt: skip
_DIMENSIONS = (
    units.MASS, units.INERTIA, units.LENGTH, units.SPEED, units.ANGLE, units.YAW_RATE, units.ENERGY
)  # fmt: skip
_OF_UNIT = {unit: dimension for dimension in _DIMENSIONS for unit in dimension.units}
_NUMBER = r"[+-]?[0-9]+(?:\.[0-9]+)?"
_TEXT = re.compile(rf"({_NUMBER})(?: ± ({_NUMBER}))? ([a-z][a-z/^2 ]*)")
_SAME = 1e-9  # relative difference of two numbers that are the same but for rounding
_TEXTS = ("text", "title", "name", "source", "notes")  # keys and fields that hold no number


def exchanged(document: Mapping[str, Any]) -> dict[str, Any] | None:
    """The tables of a scene file with the letters of its vehicles exchanged.

    Args:
        document: tables and keys of the scene file, of which its questions other than `question` are
            not carried over.

    Returns:
        The tables; None where there is one vehicle alone.
    """
    vehicles = {letter.upper(): table for letter, table in document["vehicles"].items()}
    if set(vehicles) != {"A", "B"}:
        return None
    found = {key: value for key, value in document.items() if key != "questions"}
    found["vehicles"] = {"A": vehicles["B"], "B": vehicles["A"]}
    if "question" in found:
        found["question"] = [_other(name) for name in found["question"]]
    if "priors" in found:
        found["priors"] = {_other(name): table for name, table in found["priors"].items()}
    return found


def _other(name: str) -> str:
    """The name of the other vehicle's quantity; that of the impact stays."""
    if not name.startswith(("speed_", "omega_")):
        return name
    return name[:-1] + {"a": "b", "b": "a"}[name[-1]]


def in_other_units(value: Any) -> Any:
    """The tables of a scene file in other units: metres in feet, feet in metres, degrees in radians.

    Args:
        value: tables and keys, or any value below them. Quantities whose unit is not one that messages
            suggest, and those with an error in per cent, stay as they are.

    Returns:
        The same, with every other quantity converted.
    """
    if isinstance(value, Mapping):
        unit = value.get("unit")
        if "value" in value:
            written = {key: value[key] for key in ("value", "sd") if key in value}
            if unit not in _OTHER or not all(isinstance(n, int | float) for n in written.values()):
                return dict(value)
            other, factor = _conversion(unit)
            return {**value, **{key: n * factor for key, n in written.items()}, "unit": other}
        return {
            key: below if key in _TEXTS else in_other_units(below) for key, below in value.items()
        }
    if isinstance(value, list):
        return [in_other_units(below) for below in value]
    found = _TEXT.fullmatch(value) if isinstance(value, str) else None
    if found and found[3] in _OTHER:
        other, factor = _conversion(found[3])
        table = {"value": float(found[1]) * factor, "unit": other}
        return table | ({"sd": float(found[2]) * factor} if found[2] else {})
    return value


def _conversion(unit: str) -> tuple[str, float]:
    other = _OTHER[unit]
    dimension = _OF_UNIT[unit]
    return other, units.factor(unit, dimension) / units.factor(other, dimension)


def same_numbers(one: Any, other: Any) -> bool:
    """Whether two scenes, or two values of them, agree but for rounding; texts are not compared."""
    if isinstance(one, bool) or isinstance(other, bool):
        return one is other
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=_SAME, abs_tol=1e-12)
    if type(one) is not type(other):
        return False
    if is_dataclass(one):
        return all(
            same_numbers(getattr(one, field.name), getattr(other, field.name))
            for field in fields(one)
            if field.name not in _TEXTS
        )
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(same_numbers(one[k], other[k]) for k in one)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(same_numbers, one, other))
    return bool(one == other)
