"""What a scene that is being made still lacks for an answer, in the words of the trade."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from retrodict.explore.board.plan import FILE, Plan, plan_of
from retrodict.explore.board.state import State
from retrodict.scene.errors import Problem, SceneError
from retrodict.scene.load import scene_from, value_at
from retrodict.scene.records import Scene

_MISSING = "missing"  # how the schema begins to say so


@dataclass(frozen=True, slots=True)
class Need:
    """Something that stands between a scene and its answer.

    Args:
        words: advice on it, in words.
        thing: subject: "A", "B", "impact", "ground" or "scene".
        key: key of the scene file; empty where there are several.
        wrong: whether something is written and wrong; else it is missing.
        more: whether an answer comes without it, and it would only tell more: momentum answers
            without the contact, but not by how much the vehicles rebounded and slid.
    """

    words: str
    thing: str
    key: str = ""
    wrong: bool = False
    more: bool = False


def needs_of(state: State) -> tuple[Need, ...]:
    """What is missing for an answer, in the order in which a scene is usually drawn.

    Args:
        state: state of the board.

    Returns:
        Those that an answer waits for; among them, and alone where the scene is complete, those that
        would tell more.
    """
    plan = plan_of(state)
    # of these kinds of scene the board draws no more than the file says
    plain = plan.document.get("alone") is True or value_at(plan.document, "impact.together") is True
    found = [] if plain else [*_missing(plan)]
    problems = [each for each in faults(state.text) if not is_missing(each)]
    found += [
        Need(f"{each.key}: {each.fix}", thing_of(each.key), each.key, wrong=True)
        for each in problems
    ]
    left = faults(state.text)
    if not left:
        return tuple(need for need in found if need.more)
    if all(need.more for need in found):
        found += [Need(f"{each.key}: {each.fix}", thing_of(each.key), each.key) for each in left]
    return tuple(found)


def scene_of(state: State, name: str) -> Scene | None:
    """The scene of a state; None while something is missing.

    Args:
        state: state of the board.
        name: short identifier of the scene.
    """
    text = state.text.removeprefix("\ufeff")
    try:
        return scene_from(dict(plan_of(state).document), name, text, name)
    except SceneError:
        return None


@lru_cache(maxsize=16)
def faults(text: str) -> tuple[Problem, ...]:
    """The problems of a scene file's text, as `retrodict check` has them."""
    plan = plan_of(State(text))
    try:
        scene_from(dict(plan.document), "scene", text, FILE)
    except SceneError as error:
        return error.problems
    return ()


def is_missing(problem: Problem) -> bool:
    """Whether a problem is that something has not been written yet."""
    return problem.fix.startswith((_MISSING, "nothing is known of"))


def _missing(plan: Plan) -> Iterator[Need]:
    document = plan.document
    if not isinstance(value_at(document, "title"), str):
        yield Need("a title of the scene", "scene", "title")
    letters = ("A",) if "barrier" in document else ("A", "B")
    for v in letters:
        yield from _of_vehicle(plan, v)
    yield from _of_contact(plan, letters)
    after = ("rest", "departure", "marks", "end_of_rotation")
    if not any(value_at(document, f"vehicles.{v}.{key}") for v in letters for key in after):
        whose = "the vehicle" if len(letters) == 1 else "a vehicle"
        yield Need(
            f"where {whose} came to rest, or its delta-v or speed after the impact by a recorder",
            "scene",
        )
    slid = ("rest", "marks", "end_of_rotation", "approach.skid")
    if not document.get("surfaces") and any(
        value_at(document, f"vehicles.{v}.{key}") for v in letters for key in slid
    ):
        yield Need("the road's surface, or its friction from skid tests", "ground", "surfaces")


def _of_contact(plan: Plan, letters: tuple[str, ...]) -> Iterator[Need]:
    """Point, place and line of the contact, which only a barrier or places on the ground require."""
    document = plan.document
    without = "barrier" not in document
    places = ("rest.position", "marks", "end_of_rotation")
    placed = bool(plan.grounds) or any(
        value_at(document, f"vehicles.{v}.{key}") for v in letters for key in places
    )
    if plan.point is None:
        words = "the impact point: click it, or the place that was hit on an outline"
        yield Need(words, "impact", "impact.point", more=without and not placed)
    for v in letters:
        car = plan.cars.get(v)
        if car and car.heading is not None and car.hit is None and plan.point is not None:
            words = f"{v} does not reach the impact point: drag it there"
            yield Need(words, v, f"vehicles.{v}.impact_centre", more=without)
    if plan.line is None:
        words = "the contact line: take the proposal, or turn it by its handle"
        yield Need(words, "impact", "impact.contact_line", more=without)


def _of_vehicle(plan: Plan, v: str) -> Iterator[Need]:
    car = plan.cars.get(v)
    if car is None:
        yield Need(
            "vehicle A" if v == "A" else "vehicle B, or the barrier that A struck",
            v,
            f"vehicles.{v}",
        )
        return
    table: Mapping[str, Any] = value_at(plan.document, f"vehicles.{v}") or {}
    if "class" not in table:
        sized = "wheelbase" in table or {"cg_to_front_axle", "cg_to_rear_axle"} <= table.keys()
        lacks = [each for each in ("mass", "track") if each not in table]
        lacks += [] if sized else ["wheelbase"]
        if lacks:
            yield Need(
                f"the class or model of {v}, or its {' and '.join(lacks)}", v, f"vehicles.{v}.class"
            )
    if car.heading is None:
        yield Need(f"{v} at the impact: place it on the board", v, f"vehicles.{v}.impact")


def thing_of(key: str) -> str:
    """What a line or a key is about: "A", "B", "impact", "ground" or "scene".

    Args:
        key: key of the scene file, or a line that begins with one.
    """
    first, _, rest = key.partition(".")
    if first == "vehicles" and rest[:1].upper() in ("A", "B"):
        return rest[:1].upper()
    if first in ("surfaces", "slope"):
        return "ground"
    return "impact" if first in ("impact", "barrier") else "scene"
