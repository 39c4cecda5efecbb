"""Flat names of quantities of a vehicle, and of evidence, taken apart in this one place."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from retrodict.scene.energy import ENERGY
from retrodict.scene.fields import AFTER, COEFFICIENTS

_OF_BOTH = tuple(f"impact_{key}" for key in (*ENERGY, *COEFFICIENTS))


class Name(NamedTuple):
    """Parts of a flat name such as `rest_x_a` or `mark_2_speed_b`.

    Args:
        kind: kind of quantity, such as `rest_x` or `mark_speed`.
        vehicle: `a` or `b`; empty for a quantity of the impact, which concerns both.
        mark: number of the mark, from 1; None for a quantity that is not at a mark.
    """

    kind: str
    vehicle: str
    mark: int | None = None

    @property
    def on_way(self) -> bool:
        """Whether the quantity is measured on the way to rest: at a mark, or at the end of rotation."""
        return self.kind in ("mark", "mark_speed", "mark_course", *_kinds("on the way"))

    @property
    def at_rest(self) -> bool:
        """Whether the quantity is measured at rest: a component of a rest pose, or how far off it is."""
        return self.kind in ("rest_x", "rest_y", "rest_heading", *_kinds("at rest"))


def _kinds(where: str) -> tuple[str, ...]:
    """Kinds of the items of evidence of the tables that were measured at a place."""
    return tuple(kind for own in AFTER.values() if own.where == where for kind in own.kinds)


_VELOCITIES = {f"{V}{v}{axis}": v for V in "vV" for v in "ab" for axis in "xy"}


def vehicle_of(name: str) -> str | None:
    """The vehicle that a reported quantity belongs to: "a" or "b"; None for one of the impact.

    Args:
        name: flat name in `quantities.REPORTED` or `quantities.DERIVED`.
    """
    last = name.rpartition("_")[2]
    return _VELOCITIES.get(name) or (last if last in ("a", "b") else None)


@cache
def parsed(name: str) -> Name:
    """The parts of a flat name.

    Args:
        name: flat name of a vehicle's quantity in `Scene.inputs`, or of one in `Scene.evidence`.

    Raises:
        ValueError: the name is of no vehicle's quantity.
    """
    if name in _OF_BOTH:
        return Name(name, "")
    kind, _, vehicle = name.rpartition("_")
    if vehicle not in ("a", "b"):
        raise ValueError(f"{name!r} is the name of no vehicle's quantity")
    if not kind.startswith("mark_"):
        return Name(kind, vehicle)
    _, number, *item = kind.split("_")
    return Name("_".join(["mark", *item]), vehicle, int(number))
