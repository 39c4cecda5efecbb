"""Frozen records of what was measured after the impact, in SI units and radians."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from retrodict.scene.measured import Measured

# motion of a vehicle just after the impact, by name in `fields.DEPARTURE`
Departure = dict[str, Measured]
# where a vehicle came to rest as seen from the impact, by name in `fields.FROM_IMPACT`
FromImpact = dict[str, Measured]


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


@dataclass(frozen=True, slots=True)
class EndOfRotation:
    """Pose in which a vehicle stopped sliding sideways and began to roll (m, rad); None: not measured.

    x and y are the position of its centre of gravity. Whole turns of `heading` mean nothing.
    """

    x: Measured | None = None
    y: Measured | None = None
    heading: Measured | None = None
