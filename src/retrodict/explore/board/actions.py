"""What can be done on the drawing board: each action makes a state of another, by keys of the file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from retrodict.explore.board import of_ground, of_impact, of_keys, of_questions, of_vehicles
from retrodict.explore.board.arguments import Given, refused
from retrodict.explore.board.changes import written
from retrodict.explore.board.plan import Plan, plan_of, sds_at
from retrodict.explore.board.state import State
from retrodict.scene.errors import shown
from retrodict.scene.load import value_at
from retrodict.scene.text_edit import rewritten
from retrodict.scene.units import LENGTH

Action = Callable[[State, Plan, Given], State]

_SHARPEST, _WIDEST = 0.001, 50.0  # m: standard deviations of a place


def perform(state: State, name: str, values: Mapping[str, Any]) -> State:
    """The state after an action.

    Args:
        state: state before the action.
        name: name of the action, in `ACTIONS`.
        values: arguments of the action, as JSON has them.

    Returns:
        The new state; the same one where nothing changes.

    Raises:
        SceneError: there is no such action, or it would write what a scene file may not have.
    """
    if name not in ACTIONS:
        raise refused(f"no action is called {shown(name)}")
    return ACTIONS[name](state, plan_of(state), Given(values))


def _nudge(state: State, plan: Plan, given: Given) -> State:
    """Move a thing by a step: a vehicle, the impact point, or a mark."""
    by = given.place("dx", "dy")
    thing = given.word("thing", ("car", "point", "mark"))
    if thing == "point":
        if plan.point is None:
            raise refused("there is no impact point yet: click it first")
        x, y = plan.point
        moved = {"x": x + by[0], "y": y + by[1], "along": bool(given.values.get("along"))}
        return of_impact.move_point(state, plan, Given(moved))
    car = given.car(plan)
    if thing == "mark":
        number = of_vehicles.mark_number(car, given)
        x, y = next(each[1:3] for each in car.marks if each[0] == number)
    else:
        at = car.rest if given.word("at", ("impact", "rest")) == "rest" else car.at
        if at is None:
            raise refused(f"{car.letter} is not placed there yet: place it first")
        x, y = at
    moved = dict(given.values) | {"x": x + by[0], "y": y + by[1]}
    move = of_vehicles.move_mark if thing == "mark" else of_vehicles.place
    return move(state, plan, Given(moved))


def _spread(state: State, plan: Plan, given: Given) -> State:
    """Say how uncertain a place is, of the impact or of a vehicle at rest: by sd, m, or by a factor."""
    if given.word("thing", ("car", "point")) == "point":
        key, place, default, said = "impact.point", plan.point, "impact_point", "the impact point"
    else:
        car = given.car(plan)
        key, place, default = f"{car.key}.rest.position", car.rest, "rest_position"
        said = f"{car.letter} at rest"
    before = sds_at(plan, key, default)
    if place is None or before is None:
        raise refused(f"{said} has no place yet: place it first")
    if "by" in given.values:
        new = [sd * abs(given.number("by", 10)) for sd in before]
    else:
        new = [abs(given.number(axis, _WIDEST)) for axis in "xy"]
    raw = value_at(plan.document, key)
    changes = {
        f"{key}[{i}]": rewritten(raw[i], place[i], LENGTH, max(round(new[i], 3), _SHARPEST))
        for i in (0, 1)
        if abs(new[i] - before[i]) > _SHARPEST / 2
    }
    return written(state, plan, changes, f"the uncertainty of {said}")


ACTIONS: dict[str, Action] = {
    "place": of_vehicles.place,
    "nudge": _nudge,
    "turn": of_vehicles.turn,
    "struck": of_vehicles.strike,
    "point": of_impact.move_point,
    "wheel": of_vehicles.wheel,
    "mark": of_vehicles.mark,
    "move_mark": of_vehicles.move_mark,
    "remove_mark": of_vehicles.remove_mark,
    "end_of_rotation": of_vehicles.end_of_rotation,
    "corners": of_vehicles.place_by_corners,
    "line": of_impact.line,
    "course": of_vehicles.course,
    "barrier": of_impact.barrier,
    "edge": of_ground.edge,
    "outline": of_ground.outline,
    "write": of_keys.write,
    "ask_avoidable": of_questions.ask_avoidable,
    "spread": _spread,
    "scale": of_ground.scale,
    "north": of_ground.north,
    "origin": of_ground.origin,
    "no_backdrop": of_ground.no_backdrop,
}
