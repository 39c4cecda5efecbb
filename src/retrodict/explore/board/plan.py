"""What a scene file has to draw, read leniently: a file that is being made lacks most of it."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from retrodict.explore.board.state import Place, State
from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.load import toml_of, value_at
from retrodict.scene.units import ANGLE, DIRECTION, LENGTH, Dimension, QuantityError, read_quantity
from retrodict.scene.vehicle_library import find

FILE = "the scene"  # in messages
SPARE = 0.5  # m: how far outside a vehicle an impact centre may lie, as `scene.build` has it
_LENGTH, _WIDTH = 4.6, 1.8  # m: of a vehicle of which nothing is known
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


@dataclass(frozen=True, slots=True)
class Car:
    """A vehicle as it is drawn.

    Args:
        letter: "A" or "B".
        key: key of its table in the file, where it may be written in lower case.
        name: name of the vehicle, or its class.
        front_axle: centre of gravity to front axle, m.
        rear_axle: centre of gravity to rear axle, m.
        track: track, m.
        length: length, m.
        width: width, m.
        sized: whether the file says how large it is; else a common car is drawn.
        heading: heading at impact, rad; None where the file has none.
        hit: place of the impact centre from the centre of gravity, ahead and to the left, m.
        at: position at impact, m; None where it is not placed.
        touches: whether that position follows from the impact point.
        rest: position at rest, m.
        rest_heading: heading at rest, rad.
        rotation: rotation from the impact to rest as written, rad.
        course: direction of travel before the impact, rad, as written; None for along the heading.
        marks: number, place and part of the vehicle of each mark.
        wheels: state of each wheel after the impact, as written.
    """

    letter: str
    key: str
    name: str
    front_axle: float
    rear_axle: float
    track: float
    length: float
    width: float
    sized: bool
    heading: float | None = None
    hit: Place | None = None
    at: Place | None = None
    touches: bool = False
    rest: Place | None = None
    rest_heading: float | None = None
    rotation: float | None = None
    course: float | None = None
    marks: tuple[tuple[int, float, float, str], ...] = ()
    wheels: Mapping[str, str] | None = None

    @property
    def middle(self) -> float:
        """How far the body's middle lies ahead of the centre of gravity, m."""
        return (self.front_axle - self.rear_axle) / 2

    @property
    def reach(self) -> float:
        """The farthest from the centre of gravity that an impact centre may lie, m."""
        return math.hypot(self.length, self.width) / 2 + SPARE


@dataclass(frozen=True, slots=True)
class Ground:
    """A surface that has an edge or an outline.

    Args:
        name: name of the surface.
        point: point on its edge, m; None where it has an outline.
        direction: direction of the edge, rad.
        side: side of the edge on which the surface lies, "left" or "right".
        corners: corners of the outline, m.
    """

    name: str
    point: Place | None = None
    direction: float = 0.0
    side: str = "left"
    corners: tuple[Place, ...] = ()


@dataclass(frozen=True, slots=True)
class Plan:
    """Everything of a state that is drawn.

    Args:
        document: tables and keys of the file.
        cars: vehicles by letter.
        point: the impact point, m.
        line: angle of the contact line from the y axis, rad.
        grounds: surfaces with an end, in the order of the file.
        barrier: "wall", "pole", or empty for none.
        diameter: diameter of a pole, m.
    """

    document: Mapping[str, Any]
    cars: Mapping[str, Car]
    point: Place | None
    line: float | None
    grounds: tuple[Ground, ...]
    barrier: str = ""
    diameter: float = 0.3


@lru_cache(maxsize=8)
def _document(text: str) -> dict[str, Any]:
    return toml_of(text.removeprefix("\ufeff"), FILE)


def plan_of(state: State) -> Plan:
    """What a state has to draw.

    Args:
        state: state of the board.

    Raises:
        SceneError: its text is not TOML.
    """
    document = _document(state.text)
    point = _pair(value_at(document, "impact.point"))
    vehicles = document.get("vehicles")
    cars = {}
    for key, table in vehicles.items() if isinstance(vehicles, dict) else ():
        if key.upper() in ("A", "B") and isinstance(table, dict):
            cars[key.upper()] = _car(key, table, point, state.loose.get(key.upper()))
    barrier = value_at(document, "barrier.kind")
    surfaces = document.get("surfaces")
    return Plan(
        document=document,
        cars=cars,
        point=point,
        line=si(value_at(document, "impact.contact_line"), ANGLE),
        grounds=tuple(
            ground
            for name, table in (surfaces.items() if isinstance(surfaces, dict) else ())
            if (ground := _ground(name, table))
        ),
        barrier=barrier if barrier in ("wall", "pole") else "",
        diameter=si(value_at(document, "barrier.diameter"), LENGTH) or 0.3,
    )


def si(raw: object, dimension: Dimension) -> float | None:
    """The value of a quantity in SI units or radians; None where it is none."""
    if raw is None:
        return None
    try:
        return read_quantity(raw, dimension, "").value
    except QuantityError:
        return None


def sds_at(plan: Plan, key: str, default: str) -> list[float] | None:
    """Standard deviations of a pair of coordinates, m: as written, or assumed.

    Args:
        plan: plan of the present state.
        key: key of the pair.
        default: name in `DEFAULTS` of what is assumed.

    Returns:
        Both; None where there is no such pair.
    """
    pair = value_at(plan.document, key)
    if not isinstance(pair, list) or len(pair) != 2:
        return None
    found = []
    for raw in pair:
        try:
            sd = read_quantity(raw, LENGTH, "").sd
        except QuantityError:
            return None
        found.append(sd if sd is not None else DEFAULTS[default].amount(0.0))
    return found


def _pair(raw: object) -> Place | None:
    if not isinstance(raw, list) or len(raw) != 2:
        return None
    x, y = (si(each, LENGTH) for each in raw)
    return None if x is None or y is None else (x, y)


def _car(key: str, table: Mapping[str, Any], point: Place | None, loose: Place | None) -> Car:
    kind = table.get("class")
    known = find(kind) if isinstance(kind, str) else None
    base = si(table.get("wheelbase"), LENGTH)
    axles = [si(table.get(f"cg_to_{end}_axle"), LENGTH) for end in ("front", "rear")]
    share = known.cg_share.value if known else DEFAULTS["cg_to_front_axle"].value
    if base is None and None in axles:
        base = _of(known, "wheelbase")
    base = base or sum(each or 1.35 for each in axles)
    front = axles[0] or (base - axles[1] if axles[1] else share * base)
    rear = axles[1] or base - front
    track = si(table.get("track"), LENGTH) or _of(known, "track")
    length = si(table.get("length"), LENGTH) or _of(known, "length")
    width = si(table.get("width"), LENGTH) or _of(known, "width")
    sized = known is not None or any(each in table for each in ("wheelbase", "cg_to_front_axle"))
    if length is None:
        length = front + rear + DEFAULTS["length"].value if sized else _LENGTH
    if width is None:
        width = track + DEFAULTS["width"].value if track else _WIDTH
    heading = si(value_at(table, "impact.heading"), DIRECTION)
    distance = si(value_at(table, "impact_centre.distance"), LENGTH)
    angle = si(value_at(table, "impact_centre.angle"), ANGLE)
    hit = at = None
    if distance is not None and angle is not None:
        lever = cmath.rect(distance, angle)
        hit = (lever.real, lever.imag)
        if point and heading is not None:
            centre = complex(*point) - lever * cmath.rect(1, heading)
            at = (centre.real, centre.imag)
    rest = _pair(value_at(table, "rest.position"))
    marks = table.get("marks")
    wheels = table.get("wheels")
    name = table.get("name")
    return Car(
        letter=key.upper(),
        key=f"vehicles.{key}",
        name=name if isinstance(name, str) else known.name if known else f"vehicle {key.upper()}",
        front_axle=front,
        rear_axle=rear,
        track=track or width - DEFAULTS["width"].value,
        length=length,
        width=width,
        sized=sized,
        heading=heading,
        hit=hit,
        at=at or loose,
        touches=at is not None,
        rest=rest,
        rest_heading=si(value_at(table, "rest.heading"), DIRECTION) if rest else None,
        rotation=si(value_at(table, "rest.rotation"), ANGLE) if rest else None,
        course=si(value_at(table, "approach.direction"), DIRECTION),
        marks=tuple(
            (number, *at, str(mark.get("of", "centre")))
            for number, mark in enumerate(marks if isinstance(marks, list) else ())
            if isinstance(mark, dict) and (at := _pair(mark.get("point")))
        ),
        wheels={w: str(wheels.get(w, "locked")) for w in WHEELS}
        if isinstance(wheels, dict)
        else None,
    )


def _of(known: Any, key: str) -> float | None:
    measured = getattr(known, key, None)
    return measured.value if measured else None


def _ground(name: str, table: object) -> Ground | None:
    if not isinstance(table, dict):
        return None
    if (point := _pair(value_at(table, "edge.point"))) is not None:
        direction = si(value_at(table, "edge.direction"), DIRECTION) or 0.0
        side = value_at(table, "edge.side")
        return Ground(name, point, direction, "right" if side == "right" else "left")
    corners = value_at(table, "outline.corners")
    if isinstance(corners, list):
        places = tuple(place for each in corners if (place := _pair(each)))
        return Ground(name, corners=places) if len(places) > 2 else None
    return None
