"""Flat names of quantities of a vehicle, and of evidence, taken apart in this one place."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from retrodict.scene.energy import ENERGY

_ON_WAY = ("mark", "mark_speed", "mark_course", "end_x", "end_y", "end_heading")
_AT_REST = ("rest_x", "rest_y", "rest_heading")
_OF_BOTH = tuple(f"impact_{key}" for key in ENERGY)


class Name(NamedTuple):
    """What a flat name such as `rest_x_a` or `mark_2_speed_b` says.

    Args:
        kind: of quantity: `rest_x`, `mark_speed`.
        vehicle: `a` or `b`; empty of the energy lost in the impact, which is of both.
        mark: number of the mark, from 1; None of what is at none.
    """

    kind: str
    vehicle: str
    mark: int | None = None

    @property
    def on_way(self) -> bool:
        """Whether it is measured on the way to rest: at a mark, or at the end of rotation."""
        return self.kind in _ON_WAY

    @property
    def at_rest(self) -> bool:
        """Whether it is a component of a rest pose."""
        return self.kind in _AT_REST


_VELOCITIES = {f"{V}{v}{axis}": v for V in "vV" for v in "ab" for axis in "xy"}


def vehicle_of(name: str) -> str | None:
    """Which vehicle a reported quantity is of: "a" or "b"; None where it is of the impact.

    Args:
        name: in `quantities.REPORTED` or `quantities.DERIVED`.
    """
    last = name.rpartition("_")[2]
    return _VELOCITIES.get(name) or (last if last in ("a", "b") else None)


@cache
def parsed(name: str) -> Name:
    """A flat name taken apart.

    Args:
        name: of a quantity of one vehicle, as in `Scene.inputs`, or as in `Scene.evidence`.

    Raises:
        ValueError: it is of no vehicle.
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
