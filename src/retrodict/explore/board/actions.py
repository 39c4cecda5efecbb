"""What can be done on the drawing board: each action makes a state of another, by keys of the file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from retrodict.explore.board import of_ground, of_impact, of_keys, of_vehicles
from retrodict.explore.board.arguments import Given, refused
from retrodict.explore.board.plan import Plan, plan_of
from retrodict.explore.board.state import State
from retrodict.scene.errors import shown

Action = Callable[[State, Plan, Given], State]


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
    "scale": of_ground.scale,
    "north": of_ground.north,
    "origin": of_ground.origin,
    "no_backdrop": of_ground.no_backdrop,
}
