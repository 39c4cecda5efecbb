"""Changes of a scene file's text by key, as the actions of the board make them."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from retrodict.explore.board.arguments import refused
from retrodict.explore.board.needs import faults, is_missing
from retrodict.explore.board.plan import FILE, Car, Plan
from retrodict.explore.board.state import Place, State
from retrodict.scene.errors import SceneError
from retrodict.scene.load import value_at
from retrodict.scene.text_edit import edited, in_missing_tables, rewritten
from retrodict.scene.units import ANGLE, LENGTH


def written(
    state: State, plan: Plan, changes: Mapping[str, Any], said: str, **others: Any
) -> State:
    """The state with other values at some keys of the scene file.

    Args:
        state: state before.
        plan: plan of that state.
        changes: new values by key; None removes a key, if it is there.
        said: name of the step, in words.
        others: other fields of the state.

    Raises:
        SceneError: a new value is one that a scene file may not have.
    """
    document = plan.document
    new = {key: value for key, value in changes.items() if value != value_at(document, key)}
    text = state.text
    if new:
        whole = in_missing_tables(document, new)
        bom = "\ufeff" if text.startswith("\ufeff") else ""
        try:
            text = bom + edited(text.removeprefix("\ufeff"), whole, FILE)
            text.encode()
        except UnicodeEncodeError:
            raise refused("that is no text: write it anew") from None
        before = set(faults(state.text))
        wrong = [
            each
            for each in faults(text)
            if not is_missing(each) and each not in before and _concerns(each.key, new | whole)
        ]
        if wrong:
            raise SceneError(FILE, wrong)
    after = replace(state, text=text, **others)
    return state if after == state else replace(after, said=said)


def _concerns(key: str, changes: Mapping[str, Any]) -> bool:
    return any(key == each or key.startswith((f"{each}.", f"{each}[")) for each in changes)


def rewritten_at(plan: Plan, key: str, value: float, dimension: Any, **how: Any) -> object:
    """A quantity's text with a new value, as the one at the key was written."""
    return rewritten(value_at(plan.document, key), value, dimension, **how)


def place_changes(plan: Plan, key: str, place: Place) -> dict[str, Any]:
    """Changes of a pair of coordinates, each as it was written."""
    raw = value_at(plan.document, key)
    if isinstance(raw, list) and len(raw) == 2:  # one by one, for the comments between them
        return {f"{key}[{i}]": rewritten(raw[i], place[i], LENGTH) for i in (0, 1)}
    return {key: [rewritten(None, each, LENGTH) for each in place]}


def centre_changes(plan: Plan, car: Car, lever: complex) -> dict[str, Any]:
    """The impact centre of a vehicle, `lever` (m) from its centre of gravity, in its own axes."""
    distance, angle = cmath.polar(lever)
    key = f"{car.key}.impact_centre"
    return {
        f"{key}.distance": rewritten_at(plan, f"{key}.distance", distance, LENGTH),
        f"{key}.angle": rewritten_at(plan, f"{key}.angle", angle, ANGLE),
    }


def without_vehicles(loose: Mapping[str, Place], *letters: str) -> dict[str, Place]:
    """Positions at impact of all vehicles but some."""
    return {v: at for v, at in loose.items() if v not in letters}


def wrapped(angle: float) -> float:
    """An angle from -180 deg (without) to 180 deg (with), rad."""
    return -math.remainder(-angle, math.tau) if angle else 0.0
