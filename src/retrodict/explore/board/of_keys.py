"""The action that writes what is known at a key of the scene file, as it was typed."""

from __future__ import annotations

import cmath
import math
import re
from typing import Any

from retrodict.explore.board.arguments import WORDS, Given, refused
from retrodict.explore.board.changes import centre_changes, rewritten_at, written
from retrodict.explore.board.plan import Plan
from retrodict.explore.board.state import State
from retrodict.scene.errors import shown
from retrodict.scene.text_edit import emptied
from retrodict.scene.units import ANGLE, DIRECTION, QuantityError, read_quantity

_KEY = re.compile(r"[A-Za-z0-9_]+(\[[0-9]{1,3}\])?(\.[A-Za-z0-9_]+(\[[0-9]{1,3}\])?){0,6}")
_ITEMS = 100  # of a list
# keys of one table of which the one that was written last holds
_IN_PLACE_OF = {"speed": ("speed_record",), "friction": ("kind",), "kind": ("friction",)}


def write(state: State, plan: Plan, given: Given) -> State:
    """Write what is known at a key, as it was typed; an empty text takes the key away."""
    key = _spelled(plan, given.text("key"))
    if not _KEY.fullmatch(key):
        raise refused(f"{shown(key)}: not a key of a scene file")
    value = given.values.get("value")
    match value:
        case str() if len(value) <= WORDS:
            new: Any = value.strip() or None
        case bool():
            new = value
        case list() if len(value) <= _ITEMS and all(isinstance(each, str) for each in value):
            new = value or None
        case _:
            raise refused("value: write a text")
    changes = {key if new is not None else emptied(plan.document, key): new}
    if new is not None:
        changes |= _along_with(plan, key, new)
        for other in _IN_PLACE_OF.get(key.rpartition(".")[2], ()):
            changes[f"{key.rpartition('.')[0]}.{other}"] = None
    return written(state, plan, changes, f"{key} written" if new else f"{key} taken away")


def _along_with(plan: Plan, key: str, new: object) -> dict[str, Any]:
    """What follows a heading at the impact that was typed: the vehicle turns where it stands."""
    for car in plan.cars.values():
        if key != f"{car.key}.impact.heading" or car.heading is None or not isinstance(new, str):
            continue
        try:
            by = read_quantity(new, DIRECTION, "1 deg").value - car.heading
        except QuantityError:
            return {}
        changes = {}
        if car.rotation is not None:
            at = f"{car.key}.rest.rotation"
            turned = car.rotation - math.remainder(by, math.tau)
            changes[at] = rewritten_at(plan, at, turned, ANGLE, whole_turns=True)
        if car.touches and car.hit is not None:
            changes |= centre_changes(plan, car, complex(*car.hit) * cmath.rect(1, -by))
        return changes
    return {}


def _spelled(plan: Plan, key: str) -> str:
    """A key with the vehicle's letter as the file has it."""
    for car in plan.cars.values():
        if key.startswith(f"vehicles.{car.letter}."):
            return f"{car.key}{key.removeprefix(f'vehicles.{car.letter}')}"
    return key
