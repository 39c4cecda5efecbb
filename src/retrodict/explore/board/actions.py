"""What can be done on the drawing board: each action makes a state of another, by keys of the file."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from retrodict.explore.board.needs import faults, is_missing
from retrodict.explore.board.plan import FILE, WHEELS, Car, Plan, plan_of
from retrodict.explore.board.state import Place, State
from retrodict.interchange.points import fitted_pose
from retrodict.scene.errors import Problem, SceneError, shown
from retrodict.scene.load import value_at
from retrodict.scene.text_edit import edited, emptied, in_missing_tables, rewritten
from retrodict.scene.units import ANGLE, DIRECTION, LENGTH, QuantityError, read_quantity

_FARTHEST = 1000.0  # m: of a coordinate, as the schema has it
_LINE_SD = math.radians(5)  # of a contact line that was turned by its handle
_WORDS = 2000  # characters of what is typed
_KEY = re.compile(r"[A-Za-z0-9_]+(\[[0-9]{1,3}\])?(\.[A-Za-z0-9_]+(\[[0-9]{1,3}\])?){0,6}")
_NEXT_WHEEL = {"locked": "rolling", "rolling": "damaged", "damaged": "locked"}
_ITEMS = 100  # of a list
_MISFIT = 0.5  # m: of four corners, beyond which they are those of another vehicle


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
        if not isinstance(value, str) or len(value) > _WORDS:
            raise refused(f"{name}: write a short text")
        return value.strip()

    def car(self, plan: Plan) -> Car:
        """A vehicle that the file has a table for."""
        letter = self.word("vehicle", ("A", "B"))
        if letter not in plan.cars:
            raise refused(f"there is no vehicle {letter}: A struck a barrier")
        return plan.cars[letter]


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


def refused(fix: str) -> SceneError:
    """The refusal of an action, with what to do instead."""
    return SceneError(FILE, [Problem("", "", fix)])


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


def _new(plan: Plan, key: str, value: float, dimension: Any, **how: Any) -> object:
    return rewritten(value_at(plan.document, key), value, dimension, **how)


def _place_at(plan: Plan, key: str, place: Place) -> dict[str, Any]:
    """Changes of a pair of coordinates, each as it was written."""
    raw = value_at(plan.document, key)
    if isinstance(raw, list) and len(raw) == 2:  # one by one, for the comments between them
        return {f"{key}[{i}]": rewritten(raw[i], place[i], LENGTH) for i in (0, 1)}
    return {key: [rewritten(None, each, LENGTH) for each in place]}


def _hit(plan: Plan, car: Car, lever: complex) -> dict[str, Any]:
    """The impact centre of a vehicle, `lever` (m) from its centre of gravity, in its own axes."""
    distance, angle = cmath.polar(lever)
    key = f"{car.key}.impact_centre"
    return {
        f"{key}.distance": _new(plan, f"{key}.distance", distance, LENGTH),
        f"{key}.angle": _new(plan, f"{key}.angle", angle, ANGLE),
    }


def _without(loose: Mapping[str, Place], *letters: str) -> dict[str, Place]:
    return {v: at for v, at in loose.items() if v not in letters}


# vehicles


def _place(state: State, plan: Plan, given: Given) -> State:
    """Put a vehicle at a place, at the impact or at rest; the impact point stays."""
    car, place = given.car(plan), given.place()
    if given.word("at", ("impact", "rest")) == "rest":
        changes = _place_at(plan, f"{car.key}.rest.position", place)
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
        changes = changes | _hit(plan, car, lever)
        loose = _without(loose, car.letter)
    elif car.hit is not None and plan.point is not None:
        raise refused(
            f"{car.letter} would be {abs(lever):.1f} m from the impact point, which lies on it: move "
            "the impact point with the vehicles (Shift), or leave the vehicle where it touches"
        )
    else:
        loose[car.letter] = (round(place[0], 3), round(place[1], 3))
    return written(state, plan, changes, said, loose=loose)


def _turn(state: State, plan: Plan, given: Given) -> State:
    """Turn a vehicle about its centre of gravity by some degrees, counter-clockwise; turns count."""
    car, by = given.car(plan), math.radians(given.number("by", 3600))
    key, of_rotation = car.key, f"{car.key}.rest.rotation"
    if given.word("at", ("impact", "rest")) == "rest":
        if car.rest is None:
            raise refused(f"{car.letter} is not placed at rest yet: place it first")
        heading = car.rest_heading if car.rest_heading is not None else car.heading or 0.0
        changes = {
            f"{key}.rest.heading": _new(
                plan, f"{key}.rest.heading", wrapped(heading + by), DIRECTION
            )
        }
        rotation = (
            car.rotation
            if car.rotation is not None
            else math.remainder(heading - (car.heading or 0.0), math.tau)
        ) + by
        if car.rotation is not None or abs(rotation) > math.pi:  # it was counted
            changes[of_rotation] = _new(plan, of_rotation, rotation, ANGLE, whole_turns=True)
        return written(state, plan, changes, f"{car.letter} turned at rest")
    if car.heading is None:
        raise refused(f"{car.letter} is not placed at the impact yet: place it first")
    heading = wrapped(car.heading + by)
    changes = {f"{key}.impact.heading": _new(plan, f"{key}.impact.heading", heading, DIRECTION)}
    if car.rotation is not None:  # the heading at rest stays
        changes[of_rotation] = _new(plan, of_rotation, car.rotation - by, ANGLE, whole_turns=True)
    if car.touches and car.hit is not None:
        changes |= _hit(plan, car, complex(*car.hit) * cmath.rect(1, -by))
    return written(state, plan, changes, f"{car.letter} turned at the impact")


def _struck(state: State, plan: Plan, given: Given) -> State:
    """Say which place of a vehicle was hit; the vehicle moves so that it lies at the impact point."""
    car = given.car(plan)
    lever = complex(given.number("ahead", 30), given.number("left", 30))
    changes = _hit(plan, car, lever)
    if plan.point is None and car.at is not None and car.heading is not None:
        there = complex(*car.at) + lever * cmath.rect(1, car.heading)
        changes |= _place_at(plan, "impact.point", (there.real, there.imag))
    said = f"the place that was hit on {car.letter}"
    loose = state.loose
    if plan.point is not None or car.at is not None:
        loose = _without(loose, car.letter)
    return written(state, plan, changes, said, loose=loose)


def _point(state: State, plan: Plan, given: Given) -> State:
    """Put the impact point; vehicles stay, unless they are to move along."""
    place = given.place()
    changes = _place_at(plan, "impact.point", place)
    loose = dict(state.loose)
    for car in plan.cars.values():
        if car.at is None or car.heading is None or (car.touches and given.values.get("along")):
            continue
        lever = (complex(*place) - complex(*car.at)) * cmath.rect(1, -car.heading)
        if abs(lever) <= car.reach:
            changes |= _hit(plan, car, lever)
            loose.pop(car.letter, None)
        elif car.touches:
            raise refused(
                f"the impact point would be {abs(lever):.1f} m from {car.letter}, which touches it: "
                "move it with the vehicles (Shift), or choose a place on both"
            )
    return written(state, plan, changes, "the impact point", loose=loose)


def _nudge(state: State, plan: Plan, given: Given) -> State:
    """Move a thing by a step: a vehicle, the impact point, or a mark."""
    by = given.place("dx", "dy")
    thing = given.word("thing", ("car", "point", "mark"))
    if thing == "point":
        if plan.point is None:
            raise refused("there is no impact point yet: click it first")
        x, y = plan.point
        moved = {"x": x + by[0], "y": y + by[1], "along": bool(given.values.get("along"))}
        return _point(state, plan, Given(moved))
    car = given.car(plan)
    if thing == "mark":
        number = _numbered(car, given)
        x, y = next(each[1:3] for each in car.marks if each[0] == number)
    else:
        at = car.rest if given.word("at", ("impact", "rest")) == "rest" else car.at
        if at is None:
            raise refused(f"{car.letter} is not placed there yet: place it first")
        x, y = at
    moved = dict(given.values) | {"x": x + by[0], "y": y + by[1]}
    return (_move_mark if thing == "mark" else _place)(state, plan, Given(moved))


def _wheel(state: State, plan: Plan, given: Given) -> State:
    """Go on from locked to rolling to damaged, of one wheel after the impact."""
    car, wheel = given.car(plan), given.word("wheel", WHEELS)
    wheels = dict(car.wheels or dict.fromkeys(WHEELS, "locked"))
    wheels[wheel] = _NEXT_WHEEL.get(wheels[wheel], "locked")
    key, said = f"{car.key}.wheels", f"{car.letter}: {wheel.replace('_', ' ')} {wheels[wheel]}"
    if car.wheels is not None:
        changes: dict[str, Any] = {f"{key}.{wheel}": wheels[wheel]}
    else:
        changes = {key: wheels}
    return written(state, plan, changes, said)


def _mark(state: State, plan: Plan, given: Given) -> State:
    """Add a mark that a vehicle left on its way to rest."""
    car, of = given.car(plan), given.word("of", ("centre", *WHEELS))
    x, y = (rewritten(None, each, LENGTH) for each in given.place())
    marks = value_at(plan.document, f"{car.key}.marks")
    kept = list(marks) if isinstance(marks, list) else []
    changes = {f"{car.key}.marks": [*kept, {"point": [x, y], "of": of}]}
    return written(state, plan, changes, f"a mark of {car.letter}")


def _move_mark(state: State, plan: Plan, given: Given) -> State:
    """Put a mark elsewhere."""
    car = given.car(plan)
    number = _numbered(car, given)
    key = f"{car.key}.marks[{number}].point"
    changes = _place_at(plan, key, given.place())
    return written(state, plan, changes, f"a mark of {car.letter} moved")


def _remove_mark(state: State, plan: Plan, given: Given) -> State:
    """Take a mark away."""
    car = given.car(plan)
    number, marks = _numbered(car, given), value_at(plan.document, f"{car.key}.marks")
    left = [each for i, each in enumerate(marks) if i != number]
    return written(
        state, plan, {f"{car.key}.marks": left or None}, f"a mark of {car.letter} taken away"
    )


def _numbered(car: Car, given: Given) -> int:
    number = int(given.number("number"))
    if number not in [each[0] for each in car.marks]:
        raise refused(f"{car.letter} has no mark {number + 1}")
    return number


def _end_of_rotation(state: State, plan: Plan, given: Given) -> State:
    """Say where a vehicle stopped sliding sideways and began to roll."""
    car, place = given.car(plan), given.place()
    key = f"{car.key}.end_of_rotation"
    changes = {}
    for axis, value in zip("xy", place, strict=True):
        raw = value_at(plan.document, f"{key}.{axis}")
        changes[f"{key}.{axis}"] = rewritten(raw, value, LENGTH, None if raw else 0.5)
    return written(state, plan, changes, f"the end of {car.letter}'s rotation")


# the impact and its surroundings


def _corners(state: State, plan: Plan, given: Given) -> State:
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
        changes = _place_at(plan, f"{key}.position", (pose.x, pose.y))
        changes[f"{key}.heading"] = _new(plan, f"{key}.heading", pose.heading, DIRECTION)
        return written(state, plan, changes, said)
    key = f"{car.key}.impact.heading"
    changes = {key: _new(plan, key, pose.heading, DIRECTION)}
    return _stand(state, plan, car, (pose.x, pose.y), pose.heading, changes, said)


def _line(state: State, plan: Plan, given: Given) -> State:
    """Turn the contact line to an angle from the y axis, degrees counter-clockwise."""
    angle = math.radians(given.number("angle", 360))
    angle = math.remainder(angle, math.pi)  # a line has no sense
    raw = value_at(plan.document, "impact.contact_line")
    sd = math.radians(given.number("sd", 60)) if "sd" in given.values else None
    sd = sd or (None if raw is not None else _LINE_SD)
    changes = {"impact.contact_line": rewritten(raw, angle, ANGLE, sd)}
    return written(state, plan, changes, "the contact line")


def _course(state: State, plan: Plan, given: Given) -> State:
    """Turn a vehicle's direction of travel before the impact, degrees counter-clockwise from x."""
    car, angle = given.car(plan), math.radians(given.number("angle", 360))
    key = f"{car.key}.approach.direction"
    changes = {key: _new(plan, key, wrapped(angle), DIRECTION)}
    return written(state, plan, changes, f"the course of {car.letter}")


def _barrier(state: State, plan: Plan, given: Given) -> State:
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
            others["loose"] = _without(state.loose, "B")
    said = "B in place of the barrier" if kind == "vehicle" else f"A struck a {kind}"
    return written(state, plan, changes, said, **others)


def _edge(state: State, plan: Plan, given: Given) -> State:
    """Draw the straight edge of a surface, beyond which it lies to one side."""
    name, key = _surface(given)
    changes = _of_kind(plan, given, key) | _place_at(plan, f"{key}.edge.point", given.place())
    changes |= {
        f"{key}.edge.direction": _new(
            plan,
            f"{key}.edge.direction",
            wrapped(math.radians(given.number("angle", 360))),
            DIRECTION,
        ),
        f"{key}.edge.side": given.word("side", ("left", "right")),
        f"{key}.outline": None,
    }
    return written(state, plan, changes, f"the edge of the {name}")


def _outline(state: State, plan: Plan, given: Given) -> State:
    """Draw the corners of a surface."""
    name, key = _surface(given)
    places = given.places("corners", 3, _ITEMS)
    before = value_at(plan.document, f"{key}.outline.corners")
    changes: dict[str, Any] = {}
    if isinstance(before, list) and len(before) == len(places):
        for i, place in enumerate(places):
            changes |= _place_at(plan, f"{key}.outline.corners[{i}]", place)
    else:
        drawn = [[rewritten(None, each, LENGTH) for each in place] for place in places]
        changes = {f"{key}.outline.corners": drawn}
    changes |= _of_kind(plan, given, key) | {f"{key}.edge": None}
    return written(state, plan, changes, f"the outline of the {name}")


def _surface(given: Given) -> tuple[str, str]:
    name = given.text("name")
    plain = name.isascii() and name.replace("_", "a").isalnum() and name.islower()
    if not plain or not name[0].isalpha():
        raise refused("name: write a surface's name in lower case: letters, digits and _")
    return name, f"surfaces.{name}"


def _of_kind(plan: Plan, given: Given, key: str) -> dict[str, Any]:
    """The kind of a surface that is new."""
    if value_at(plan.document, key) is not None:
        return {}
    return {f"{key}.kind": given.text("kind")}


# what is known


def _write(state: State, plan: Plan, given: Given) -> State:
    """Write what is known at a key, as it was typed; an empty text takes the key away."""
    key = _spelled(plan, given.text("key"))
    if not _KEY.fullmatch(key):
        raise refused(f"{shown(key)}: not a key of a scene file")
    value = given.values.get("value")
    match value:
        case str() if len(value) <= _WORDS:
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
            changes[at] = _new(plan, at, turned, ANGLE, whole_turns=True)
        if car.touches and car.hit is not None:
            changes |= _hit(plan, car, complex(*car.hit) * cmath.rect(1, -by))
        return changes
    return {}


# keys of one table of which the one that was written last holds
_IN_PLACE_OF = {"speed": ("speed_record",), "friction": ("kind",), "kind": ("friction",)}


def _spelled(plan: Plan, key: str) -> str:
    """A key with the vehicle's letter as the file has it."""
    for car in plan.cars.values():
        if key.startswith(f"vehicles.{car.letter}."):
            return f"{car.key}{key.removeprefix(f'vehicles.{car.letter}')}"
    return key


# the photograph


def _scale(state: State, plan: Plan, given: Given) -> State:
    """Scale the photograph so that two of its points are as far apart as was measured."""
    one, other = complex(*given.place("x1", "y1")), complex(*given.place("x2", "y2"))
    distance = given.length("distance")
    if state.backdrop is None or distance <= 0 or abs(other - one) < 1e-6:
        raise refused("click two points of the photograph, and write how far apart they are")
    by = distance / abs(other - one)
    corner = one + (complex(state.backdrop.x, state.backdrop.y) - one) * by
    metres = state.backdrop.metres * by
    if not 1e-5 <= metres <= 10 or max(abs(corner.real), abs(corner.imag)) > 1e5:
        raise refused("that is no scale of a photograph: look at the distance and its unit")
    scaled = replace(state.backdrop, metres=metres, x=corner.real, y=corner.imag, scaled=True)
    return replace(state, backdrop=scaled, said="the scale of the photograph")


def _north(state: State, plan: Plan, given: Given) -> State:
    """Turn the photograph about a point so that a direction in it is +y, north."""
    one, other = complex(*given.place("x1", "y1")), complex(*given.place("x2", "y2"))
    if state.backdrop is None or abs(other - one) < 1e-6:
        raise refused("click two points of the photograph, the second north of the first")
    by = 1j / ((other - one) / abs(other - one))
    corner = one + (complex(state.backdrop.x, state.backdrop.y) - one) * by
    turn = wrapped(state.backdrop.turn + cmath.phase(by))
    turned = replace(state.backdrop, x=corner.real, y=corner.imag, turn=turn)
    return replace(state, backdrop=turned, said="north in the photograph")


def _origin(state: State, plan: Plan, given: Given) -> State:
    """Move the photograph so that a point of it is the origin of the scene."""
    if state.backdrop is None:
        raise refused("there is no photograph")
    x, y = given.place()
    moved = replace(state.backdrop, x=state.backdrop.x - x, y=state.backdrop.y - y)
    return replace(state, backdrop=moved, said="the photograph's origin")


def _no_backdrop(state: State, plan: Plan, given: Given) -> State:
    """Take the photograph away."""
    if state.backdrop is None:
        return state
    return replace(state, backdrop=None, said="the photograph taken away")


def wrapped(angle: float) -> float:
    """An angle from -180 deg (without) to 180 deg (with), rad."""
    return -math.remainder(-angle, math.tau) if angle else 0.0


ACTIONS: dict[str, Action] = {
    "place": _place,
    "nudge": _nudge,
    "turn": _turn,
    "struck": _struck,
    "point": _point,
    "wheel": _wheel,
    "mark": _mark,
    "move_mark": _move_mark,
    "remove_mark": _remove_mark,
    "end_of_rotation": _end_of_rotation,
    "corners": _corners,
    "line": _line,
    "course": _course,
    "barrier": _barrier,
    "edge": _edge,
    "outline": _outline,
    "write": _write,
    "scale": _scale,
    "north": _north,
    "origin": _origin,
    "no_backdrop": _no_backdrop,
}
