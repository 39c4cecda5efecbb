"""Actions on vehicles: where they stand and stood, their wheels, their marks and their courses."""

from __future__ import annotations

import cmath
import math
from typing import Any

from retrodict.explore.board.arguments import Given, refused
from retrodict.explore.board.changes import (
    centre_changes,
    place_changes,
    rewritten_at,
    without_vehicles,
    wrapped,
    written,
)
from retrodict.explore.board.plan import WHEELS, Car, Plan
from retrodict.explore.board.state import Place, State
from retrodict.interchange.points import fitted_pose
from retrodict.scene.load import value_at
from retrodict.scene.text_edit import rewritten
from retrodict.scene.units import ANGLE, DIRECTION, LENGTH

_NEXT_WHEEL = {"locked": "rolling", "rolling": "damaged", "damaged": "locked"}
_MISFIT = 0.5  # m: of four corners, beyond which they are those of another vehicle


def place(state: State, plan: Plan, given: Given) -> State:
    """Put a vehicle at a place, at the impact or at rest; the impact point stays."""
    car, place = given.car(plan), given.place()
    if given.word("at", ("impact", "rest")) == "rest":
        changes = place_changes(plan, f"{car.key}.rest.position", place)
        if car.rest is None:
            heading = given.number("heading", 360) if "heading" in given.values else None
            heading = math.radians(heading) if heading is not None else car.heading or 0.0
            changes[f"{car.key}.rest.heading"] = rewritten(None, wrapped(heading), DIRECTION)
        return written(state, plan, changes, f"{car.letter} placed at rest")
    changes = {}
    heading = car.heading
    if heading is None:
        heading = math.radians(given.number("heading", 360)) if "heading" in given.values else 0.0
        key = f"{car.key}.impact.heading"
        changes[key] = rewritten(None, wrapped(heading), DIRECTION)
    return _stand(state, plan, car, place, heading, changes, f"{car.letter} placed at the impact")


def _stand(
    state: State,
    plan: Plan,
    car: Car,
    place: Place,
    heading: float,
    changes: dict[str, Any],
    said: str,
) -> State:
    """A vehicle at a pose at the impact, which it touches where it reaches the impact point."""
    loose = dict(state.loose)
    lever = complex(math.inf)
    if plan.point is not None:
        lever = (complex(*plan.point) - complex(*place)) * cmath.rect(1, -heading)
    if abs(lever) <= car.reach:
        changes = changes | centre_changes(plan, car, lever)
        loose = without_vehicles(loose, car.letter)
    elif car.hit is not None and plan.point is not None:
        raise refused(
            f"{car.letter} would be {abs(lever):.1f} m from the impact point, which lies on it: move "
            "the impact point with the vehicles (Shift), or leave the vehicle where it touches"
        )
    else:
        loose[car.letter] = (round(place[0], 3), round(place[1], 3))
    return written(state, plan, changes, said, loose=loose)


def turn(state: State, plan: Plan, given: Given) -> State:
    """Turn a vehicle about its centre of gravity by some degrees, counter-clockwise; turns count."""
    car, by = given.car(plan), math.radians(given.number("by", 3600))
    key, of_rotation = car.key, f"{car.key}.rest.rotation"
    if given.word("at", ("impact", "rest")) == "rest":
        if car.rest is None:
            raise refused(f"{car.letter} is not placed at rest yet: place it first")
        heading = car.rest_heading if car.rest_heading is not None else car.heading or 0.0
        changes = {
            f"{key}.rest.heading": rewritten_at(
                plan, f"{key}.rest.heading", wrapped(heading + by), DIRECTION
            )
        }
        rotation = (
            car.rotation
            if car.rotation is not None
            else math.remainder(heading - (car.heading or 0.0), math.tau)
        ) + by
        if car.rotation is not None or abs(rotation) > math.pi:  # it was counted
            changes[of_rotation] = rewritten_at(
                plan, of_rotation, rotation, ANGLE, whole_turns=True
            )
        return written(state, plan, changes, f"{car.letter} turned at rest")
    if car.heading is None:
        raise refused(f"{car.letter} is not placed at the impact yet: place it first")
    heading = wrapped(car.heading + by)
    changes = {
        f"{key}.impact.heading": rewritten_at(plan, f"{key}.impact.heading", heading, DIRECTION)
    }
    if car.rotation is not None:  # the heading at rest stays
        changes[of_rotation] = rewritten_at(
            plan, of_rotation, car.rotation - by, ANGLE, whole_turns=True
        )
    if car.touches and car.hit is not None:
        changes |= centre_changes(plan, car, complex(*car.hit) * cmath.rect(1, -by))
    return written(state, plan, changes, f"{car.letter} turned at the impact")


def strike(state: State, plan: Plan, given: Given) -> State:
    """Say which place of a vehicle was hit; the vehicle moves so that it lies at the impact point."""
    car = given.car(plan)
    lever = complex(given.number("ahead", 30), given.number("left", 30))
    changes = centre_changes(plan, car, lever)
    if plan.point is None and car.at is not None and car.heading is not None:
        there = complex(*car.at) + lever * cmath.rect(1, car.heading)
        changes |= place_changes(plan, "impact.point", (there.real, there.imag))
    said = f"the place that was hit on {car.letter}"
    loose = state.loose
    if plan.point is not None or car.at is not None:
        loose = without_vehicles(loose, car.letter)
    return written(state, plan, changes, said, loose=loose)


def wheel(state: State, plan: Plan, given: Given) -> State:
    """Go on from locked to rolling to damaged, of one wheel after the impact."""
    car, which = given.car(plan), given.word("wheel", WHEELS)
    wheels = dict(car.wheels or dict.fromkeys(WHEELS, "locked"))
    wheels[which] = _NEXT_WHEEL.get(wheels[which], "locked")
    key, said = f"{car.key}.wheels", f"{car.letter}: {which.replace('_', ' ')} {wheels[which]}"
    if car.wheels is not None:
        changes: dict[str, Any] = {f"{key}.{which}": wheels[which]}
    else:
        changes = {key: wheels}
    return written(state, plan, changes, said)


def mark(state: State, plan: Plan, given: Given) -> State:
    """Add a mark that a vehicle left on its way to rest."""
    car, of = given.car(plan), given.word("of", ("centre", *WHEELS))
    x, y = (rewritten(None, each, LENGTH) for each in given.place())
    marks = value_at(plan.document, f"{car.key}.marks")
    kept = list(marks) if isinstance(marks, list) else []
    changes = {f"{car.key}.marks": [*kept, {"point": [x, y], "of": of}]}
    return written(state, plan, changes, f"a mark of {car.letter}")


def move_mark(state: State, plan: Plan, given: Given) -> State:
    """Put a mark elsewhere."""
    car = given.car(plan)
    number = mark_number(car, given)
    key = f"{car.key}.marks[{number}].point"
    changes = place_changes(plan, key, given.place())
    return written(state, plan, changes, f"a mark of {car.letter} moved")


def remove_mark(state: State, plan: Plan, given: Given) -> State:
    """Take a mark away."""
    car = given.car(plan)
    number, marks = mark_number(car, given), value_at(plan.document, f"{car.key}.marks")
    left = [each for i, each in enumerate(marks) if i != number]
    return written(
        state, plan, {f"{car.key}.marks": left or None}, f"a mark of {car.letter} taken away"
    )


def mark_number(car: Car, given: Given) -> int:
    """The number of a mark that a vehicle has."""
    number = int(given.number("number"))
    if number not in [each[0] for each in car.marks]:
        raise refused(f"{car.letter} has no mark {number + 1}")
    return number


def end_of_rotation(state: State, plan: Plan, given: Given) -> State:
    """Say where a vehicle stopped sliding sideways and began to roll."""
    car, place = given.car(plan), given.place()
    key = f"{car.key}.end_of_rotation"
    changes = {}
    for axis, value in zip("xy", place, strict=True):
        raw = value_at(plan.document, f"{key}.{axis}")
        changes[f"{key}.{axis}"] = rewritten(raw, value, LENGTH, None if raw else 0.5)
    return written(state, plan, changes, f"the end of {car.letter}'s rotation")


def place_by_corners(state: State, plan: Plan, given: Given) -> State:
    """Put a vehicle where its corners are: front left, front right, rear right, rear left."""
    car = given.car(plan)
    places = given.places("corners", 4, 4)
    ahead, half = car.length / 2, car.width / 2
    body = [(ahead, half), (ahead, -half), (-ahead, -half), (-ahead, half)]
    body = [(u + car.middle, w) for u, w in body]
    try:
        pose = fitted_pose(body, places, 0.05)
    except ValueError:
        raise refused("corners: click four places that differ") from None
    if pose.misfit > _MISFIT:
        raise refused(
            f"the corners miss {car.letter}'s outline by {pose.misfit:.2f} m: click front left, front "
            "right, rear right, rear left, or look at its length and width"
        )
    at, said = given.word("at", ("impact", "rest")), f"{car.letter} placed by its corners"
    if at == "rest":
        key = f"{car.key}.rest"
        changes = place_changes(plan, f"{key}.position", (pose.x, pose.y))
        changes[f"{key}.heading"] = rewritten_at(plan, f"{key}.heading", pose.heading, DIRECTION)
        return written(state, plan, changes, said)
    key = f"{car.key}.impact.heading"
    changes = {key: rewritten_at(plan, key, pose.heading, DIRECTION)}
    return _stand(state, plan, car, (pose.x, pose.y), pose.heading, changes, said)


def course(state: State, plan: Plan, given: Given) -> State:
    """Turn a vehicle's direction of travel before the impact, degrees counter-clockwise from x."""
    car, angle = given.car(plan), math.radians(given.number("angle", 360))
    key = f"{car.key}.approach.direction"
    changes = {key: rewritten_at(plan, key, wrapped(angle), DIRECTION)}
    return written(state, plan, changes, f"the course of {car.letter}")
