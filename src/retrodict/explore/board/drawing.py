"""What the page draws of a board, in the form that JSON has: metres and degrees."""

from __future__ import annotations

import math
from typing import Any

from retrodict.explore.board.contact import proposed
from retrodict.explore.board.plan import Car, Plan, sds_at
from retrodict.explore.board.state import State


def drawing(state: State, plan: Plan) -> dict[str, Any]:
    """Everything to draw of a state, but its surveyed points.

    Args:
        state: state of the board.
        plan: plan of that state.
    """
    backdrop = state.backdrop
    proposal = proposed(plan)
    return {
        "cars": [_car(plan, car) for car in plan.cars.values()],
        "point": plan.point,
        "pointSd": sds_at(plan, "impact.point", "impact_point"),
        "line": _degrees(plan.line),
        "proposal": _degrees(proposal.angle) if proposal else None,
        "grounds": [
            {
                "name": ground.name,
                "point": ground.point,
                "angle": math.degrees(ground.direction),
                "side": ground.side,
                "corners": ground.corners,
            }
            for ground in plan.grounds
        ],
        "barrier": plan.barrier,
        "diameter": plan.diameter,
        "backdrop": None
        if backdrop is None
        else {
            "url": f"/ground?{backdrop.sha256[:16]}",
            "width": backdrop.width,
            "height": backdrop.height,
            "metres": backdrop.metres,
            "x": backdrop.x,
            "y": backdrop.y,
            "turn": math.degrees(backdrop.turn),
            "scaled": backdrop.scaled,
        },
    }


def _car(plan: Plan, car: Car) -> dict[str, Any]:
    return {
        "letter": car.letter,
        "name": car.name,
        "middle": car.middle,
        "front": car.front_axle,
        "rear": car.rear_axle,
        "track": car.track,
        "length": car.length,
        "width": car.width,
        "sized": car.sized,
        "at": car.at if car.heading is not None else None,
        "heading": _degrees(car.heading),
        "touches": car.touches,
        "hit": car.hit,
        "course": _degrees(car.course),
        "rest": car.rest,
        "restHeading": _degrees(car.rest_heading),
        "restSd": sds_at(plan, f"{car.key}.rest.position", "rest_position") if car.rest else None,
        "rotation": _degrees(car.rotation),
        "marks": [list(mark) for mark in car.marks],
        "wheels": dict(car.wheels) if car.wheels else None,
    }


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else math.degrees(angle)
