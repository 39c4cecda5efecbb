"""Frozen records of a vehicle's measured motion, before the impact and after it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from retrodict.scene.fields import SKID, YAW_MARK
from retrodict.scene.measured import Measured
from retrodict.scene.speed_record import SpeedRecord


@dataclass(frozen=True, slots=True)
class Skid:
    """A piece of a skid up to the impact.

    Args:
        length: length of the piece, m.
        surface: name of the surface; empty where a drag factor is given.
        braking: braking force over the available friction; None where all wheels were locked.
        drag_factor: deceleration over g; None where the surface and the braking give it.
    """

    length: Measured
    surface: str = ""
    braking: Measured | None = None
    drag_factor: Measured | None = None


@dataclass(frozen=True, slots=True)
class YawMark:
    """Arc of a critical-speed yaw mark.

    Args:
        chord: chord of the arc, m.
        middle_ordinate: height of the arc above the middle of its chord, m.
        error: standard deviation of the method's speed over that speed.
        surface: name of the surface.
    """

    chord: Measured
    middle_ordinate: Measured
    error: Measured
    surface: str


@dataclass(frozen=True, slots=True)
class Approach:
    """Motion just before impact (m/s, rad, rad/s, m); None stands for unknown.

    `direction` is the direction of travel, counter-clockwise from the x axis; it need not be the
    heading, but is assumed to be along it where a scene file says nothing. `skid` is how far the vehicle
    skidded on the road up to the impact, `skid_braking` the braking force over the available friction
    there; None where all wheels were locked. `record` is the speed record that `speed` comes from, if
    any; `speed` then holds the mean and standard deviation of the speed at impact by that record.
    `skids` are the pieces of a skid that is not one, in the order in which they were driven, and
    `yaw_mark` is the mark that it left before them.
    """

    speed: Measured | None
    direction: Measured | None
    yaw_rate: Measured | None
    skid: Measured | None = None
    skid_braking: Measured | None = None
    record: SpeedRecord | None = None
    skids: tuple[Skid, ...] = ()
    yaw_mark: YawMark | None = None

    @property
    def skid_length(self) -> float:
        """Length of the whole skid up to the impact, m; 0 where there was none."""
        return self.skid.value if self.skid else sum(piece.length.value for piece in self.skids)


# what was measured of a vehicle after the impact in a table of `fields.AFTER`, by key
Items = dict[str, Measured]


@dataclass(frozen=True, slots=True)
class Rest:
    """Rest pose of a vehicle (m, rad): its centre of gravity and its heading, if measured.

    `heading` is unwrapped: it is the heading at impact plus the total rotation when
    `turns_known`, else the representative within half a turn of the heading at impact.
    """

    x: Measured
    y: Measured
    heading: Measured | None
    turns_known: bool


@dataclass(frozen=True, slots=True)
class Mark:
    """A point that a vehicle passed on its way to rest (m).

    `of` is the part of the vehicle that passed there: "centre" (of gravity) or a wheel
    ("front_left", …). `sd` is the uncertainty of the point across the path; `source` and `assumed`
    are as in `Measured`. `speed` (m/s) and `course` (rad), the direction of travel, are those of the
    centre of gravity at that moment, None where not measured.
    """

    x: float
    y: float
    sd: float
    of: str
    source: str = ""
    assumed: Literal["", "sd", "value", "stand-in"] = ""
    speed: Measured | None = None
    course: Measured | None = None


def marks_before(approach: Approach) -> Iterator[tuple[str, Measured]]:
    """Flat name, without the vehicle, and value of what was measured of skids and a yaw mark.

    Args:
        approach: motion of a vehicle before the impact; a skid in one piece is left out.
    """
    for number, piece in enumerate(approach.skids, start=1):
        for key, field in SKID.items():
            if (measured := getattr(piece, key)) is not None:
                yield field.flat.replace("skid", f"skid_{number}", 1), measured
    if approach.yaw_mark is not None:
        for key, field in YAW_MARK.items():
            yield field.flat, getattr(approach.yaw_mark, key)
