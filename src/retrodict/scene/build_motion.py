"""Conversion of what a scene file says of a vehicle's motion into records."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.entries.motion import ApproachEntry, MarkEntry, RestEntry
from retrodict.scene.entries.table import Table
from retrodict.scene.estimates import Complain
from retrodict.scene.fields import APPROACH, SKID, YAW_MARK, Field
from retrodict.scene.records import Approach, Mark, Measured, Rest, Skid, YawMark
from retrodict.scene.speed_record import SpeedRecord
from retrodict.scene.units import ANGLE

_SLIDES = math.radians(15)  # off its heading a vehicle slides: tyres that roll slip by some 10 deg


def kept_values(entry: Table, fields: Mapping[str, Field]) -> dict[str, Any]:
    """Values of a table that a record keeps as written, or the assumed ones, by attribute.

    Args:
        entry: the table.
        fields: quantities of the table by key.
    """
    return {
        field.name or key: getattr(entry, key) or field.where_unwritten
        for key, field in fields.items()
        if not field.computed
    }


def approach_of(entry: ApproachEntry, heading: Measured, road: str) -> Approach:
    """Motion before impact: along the heading and without yaw, unless the file states a slide.

    Args:
        entry: the file's entry.
        heading: heading at impact.
        road: name of the road, for skids that name no surface.
    """
    speed, record = _speed(entry)
    direction = _known(entry.direction, lambda: along(heading))
    # a vehicle that slides sideways has begun to yaw
    slides = (
        direction is None
        or abs(math.remainder(direction.value - heading.value, math.tau)) > _SLIDES
    )
    yaw_rate = _known(entry.yaw_rate, lambda: None if slides else without_yaw())
    pieces = [(kept_values(piece, SKID), piece.surface or road) for piece in entry.skids]
    skids = tuple(Skid(**k, surface="" if k["drag_factor"] else on_it) for k, on_it in pieces)
    yaw = entry.yaw_mark
    mark = None
    if yaw is not None and yaw.error is not None:
        mark = YawMark(**kept_values(yaw, YAW_MARK), error=yaw.error, surface=yaw.surface or road)
    return Approach(
        speed,
        direction,
        yaw_rate,
        record=record,
        skids=skids,
        yaw_mark=mark,
        **kept_values(entry, APPROACH),
    )


def _known(
    written: Measured | str | None, assumed: Callable[[], Measured | None]
) -> Measured | None:
    """The written value, None where it is "unknown", or the assumed one where nothing is written."""
    if written is None:
        return assumed()
    return None if isinstance(written, str) else written


def along(heading: Measured) -> Measured:
    """The assumed direction of travel of a vehicle that did not slide, by its heading.

    Args:
        heading: heading at impact.
    """
    spread = DEFAULTS["course"]
    return Measured(
        heading.value,
        math.hypot(heading.sd, spread.amount(heading.value)),
        source=f"assumed: along the heading at impact, whose error is added to ± {spread}",
        assumed="value",
    )


def without_yaw() -> Measured:
    """The assumed yaw rate of a vehicle that neither slid nor turned."""
    spread = DEFAULTS["yaw_rate"]
    return Measured(0.0, spread.amount(0.0), source=f"assumed: 0 ± {spread}", assumed="value")


def _speed(entry: ApproachEntry) -> tuple[Measured | None, SpeedRecord | None]:
    """The speed as measured, or the mean and standard deviation by a speed record, and that record."""
    if (kept := entry.speed_record) is None:
        return entry.speed, None
    low, high = (moment.value for moment in kept.impact)
    record = SpeedRecord(
        times=tuple(t.value for t in kept.times),
        speeds=tuple(v.value for v in kept.speeds),
        low=low,
        high=high,
        sd=kept.uncertainty.value,
    )
    every = (kept.uncertainty, *kept.speeds, *kept.times)
    source = "; ".join(dict.fromkeys(m.source for m in every if m.source))  # each once
    return Measured(*record.moments, source=source), record


def mark_of(entry: MarkEntry) -> Mark:
    """A point that a vehicle passed.

    Args:
        entry: the file's entry.
    """
    x, y = entry.point
    default = DEFAULTS["mark"]
    across = entry.uncertainty or Measured(
        default.amount(0.0), source=f"uncertainty assumed: {default}", assumed="sd"
    )
    sources = dict.fromkeys(m.source for m in (x, y, across) if m.source)  # each once
    return Mark(
        *(x.value, y.value, across.value, entry.of, "; ".join(sources), across.assumed),
        speed=entry.speed,
        course=entry.course,
    )


def rest_of(
    letter: str, entry: RestEntry | None, at_impact: float, complain: Complain
) -> Rest | None:
    """A rest pose, with the turns that the rotation counts; None where no position is written.

    Args:
        letter: letter of the vehicle.
        entry: the file's entry, if there is one.
        at_impact: heading at impact, rad.
        complain: called where rotation and headings contradict one another.
    """
    if entry is None or entry.position is None:
        return None
    x, y = entry.position
    if entry.heading is None:
        return Rest(x, y, None, turns_known=False)
    turned = entry.heading.value - at_impact  # but for whole turns
    expected = entry.rotation.value if entry.rotation else 0.0
    rotation = turned + math.tau * round((expected - turned) / math.tau)
    if contradicts(entry, at_impact):
        complain(
            f"vehicles.{letter}.rest.rotation",
            "the two headings differ by {amount} and whole turns; write a rotation (positive "
            "counter-clockwise) within 45 deg of that, or correct a heading",
            math.remainder(turned, math.tau),
            ANGLE,
        )
    heading = replace(entry.heading, value=at_impact + rotation)
    return Rest(x, y, heading, turns_known=entry.rotation is not None)


def contradicts(entry: RestEntry, at_impact: float) -> bool:
    """Whether a rotation is off the one by the headings by over 1/8 turn, whole turns aside.

    Args:
        entry: entry of a rest.
        at_impact: heading at impact, rad.
    """
    if not (entry.heading and entry.rotation):
        return False
    off = entry.heading.value - at_impact - entry.rotation.value
    return abs(math.remainder(off, math.tau)) > math.pi / 4
