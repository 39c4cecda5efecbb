"""Actions on the impact: its point, the contact line, and what A struck."""

from __future__ import annotations

import cmath
import math
from typing import Any

from retrodict.explore.board.arguments import Given, refused
from retrodict.explore.board.changes import centre_changes, place_changes, without_vehicles, written
from retrodict.explore.board.plan import Plan
from retrodict.explore.board.state import State
from retrodict.scene.load import value_at
from retrodict.scene.text_edit import rewritten
from retrodict.scene.units import ANGLE

_LINE_SD = math.radians(5)  # of a contact line that was turned by its handle


def move_point(state: State, plan: Plan, given: Given) -> State:
    """Put the impact point; vehicles stay, unless they are to move along."""
    place = given.place()
    changes = place_changes(plan, "impact.point", place)
    loose = dict(state.loose)
    for car in plan.cars.values():
        if car.at is None or car.heading is None or (car.touches and given.values.get("along")):
            continue
        lever = (complex(*place) - complex(*car.at)) * cmath.rect(1, -car.heading)
        if abs(lever) <= car.reach:
            changes |= centre_changes(plan, car, lever)
            loose.pop(car.letter, None)
        elif car.touches:
            raise refused(
                f"the impact point would be {abs(lever):.1f} m from {car.letter}, which touches it: "
                "move it with the vehicles (Shift), or choose a place on both"
            )
    return written(state, plan, changes, "the impact point", loose=loose)


def line(state: State, plan: Plan, given: Given) -> State:
    """Turn the contact line to an angle from the y axis, or by one; degrees counter-clockwise."""
    if "by" not in given.values:
        angle = math.radians(given.number("angle", 360))
    elif plan.line is None:
        raise refused(
            "there is no contact line yet: take the proposal, or click two points along it"
        )
    else:
        angle = plan.line + math.radians(given.number("by", 360))
    angle = math.remainder(angle, math.pi)  # a line has no sense
    raw = value_at(plan.document, "impact.contact_line")
    sd = math.radians(given.number("sd", 60)) if "sd" in given.values else None
    sd = sd or (None if raw is not None else _LINE_SD)
    changes = {"impact.contact_line": rewritten(raw, angle, ANGLE, sd)}
    return written(state, plan, changes, "the contact line")


def barrier(state: State, plan: Plan, given: Given) -> State:
    """Let A strike a wall, a pole or a vehicle B."""
    kind = given.word("kind", ("wall", "pole", "vehicle"))
    others: dict[str, Any] = {}
    changes: dict[str, Any] = {}
    if kind == "vehicle":
        changes["barrier"] = None
        if "B" not in plan.cars:
            changes["vehicles.B"] = {}
        if value_at(plan.document, "question") == ["speed_a"]:
            changes["question"] = None
    else:
        changes["barrier.kind"] = kind
        changes["barrier.diameter"] = (
            (value_at(plan.document, "barrier.diameter") or "0.3 m") if kind == "pole" else None
        )
        if "B" in plan.cars:
            changes[plan.cars["B"].key] = None
            others["loose"] = without_vehicles(state.loose, "B")
    said = "B in place of the barrier" if kind == "vehicle" else f"A struck a {kind}"
    return written(state, plan, changes, said, **others)
