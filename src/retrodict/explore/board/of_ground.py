"""Actions on the ground: surfaces with an edge or an outline, and the photograph under the drawing."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from typing import Any

from retrodict.explore.board.arguments import Given, refused
from retrodict.explore.board.changes import place_changes, rewritten_at, wrapped, written
from retrodict.explore.board.plan import Plan
from retrodict.explore.board.state import State
from retrodict.scene.load import value_at
from retrodict.scene.text_edit import rewritten
from retrodict.scene.units import DIRECTION, LENGTH

_CORNERS = 100  # of an outline


def edge(state: State, plan: Plan, given: Given) -> State:
    """Draw the straight edge of a surface, beyond which it lies to one side."""
    name, key = _surface(plan, given)
    changes = _of_kind(plan, given, key) | place_changes(plan, f"{key}.edge.point", given.place())
    changes |= {
        f"{key}.edge.direction": rewritten_at(
            plan,
            f"{key}.edge.direction",
            wrapped(math.radians(given.number("angle", 360))),
            DIRECTION,
        ),
        f"{key}.edge.side": given.word("side", ("left", "right")),
        f"{key}.outline": None,
    }
    return written(state, plan, changes, f"the edge of the {name}")


def outline(state: State, plan: Plan, given: Given) -> State:
    """Draw the corners of a surface."""
    name, key = _surface(plan, given)
    places = given.places("corners", 3, _CORNERS)
    before = value_at(plan.document, f"{key}.outline.corners")
    changes: dict[str, Any] = {}
    if isinstance(before, list) and len(before) == len(places):
        for i, place in enumerate(places):
            changes |= place_changes(plan, f"{key}.outline.corners[{i}]", place)
    else:
        drawn = [[rewritten(None, each, LENGTH) for each in place] for place in places]
        changes = {f"{key}.outline.corners": drawn}
    changes |= _of_kind(plan, given, key) | {f"{key}.edge": None}
    return written(state, plan, changes, f"the outline of the {name}")


def _surface(plan: Plan, given: Given) -> tuple[str, str]:
    """Name and key of a surface: of that name, or a new one whose name begins with a stem."""
    name = given.text("stem" if "stem" in given.values else "name")
    plain = name.isascii() and name.replace("_", "a").isalnum() and name.islower()
    if not plain or not name[0].isalpha():
        raise refused("name: write a surface's name in lower case: letters, digits and _")
    if "stem" in given.values:
        known, stem, number = plan.document.get("surfaces"), name, 1
        while isinstance(known, dict) and name in known:
            number += 1
            name = f"{stem}_{number}"
    return name, f"surfaces.{name}"


def _of_kind(plan: Plan, given: Given, key: str) -> dict[str, Any]:
    """The kind of a surface that is new."""
    if value_at(plan.document, key) is not None:
        return {}
    return {f"{key}.kind": given.text("kind")}


# the photograph


def scale(state: State, plan: Plan, given: Given) -> State:
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


def north(state: State, plan: Plan, given: Given) -> State:
    """Turn the photograph about a point so that a direction in it is +y, north."""
    one, other = complex(*given.place("x1", "y1")), complex(*given.place("x2", "y2"))
    if state.backdrop is None or abs(other - one) < 1e-6:
        raise refused("click two points of the photograph, the second north of the first")
    by = 1j / ((other - one) / abs(other - one))
    corner = one + (complex(state.backdrop.x, state.backdrop.y) - one) * by
    turn = wrapped(state.backdrop.turn + cmath.phase(by))
    turned = replace(state.backdrop, x=corner.real, y=corner.imag, turn=turn)
    return replace(state, backdrop=turned, said="north in the photograph")


def origin(state: State, plan: Plan, given: Given) -> State:
    """Move the photograph so that a point of it is the origin of the scene."""
    if state.backdrop is None:
        raise refused("there is no photograph")
    x, y = given.place()
    moved = replace(state.backdrop, x=state.backdrop.x - x, y=state.backdrop.y - y)
    return replace(state, backdrop=moved, said="the photograph's origin")


def no_backdrop(state: State, plan: Plan, given: Given) -> State:
    """Take the photograph away."""
    if state.backdrop is None:
        return state
    return replace(state, backdrop=None, said="the photograph taken away")
