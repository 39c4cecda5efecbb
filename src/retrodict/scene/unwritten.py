"""What only some models need and a scene file may leave out, and what stands in for it."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import replace

from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.entries.vehicle import VehicleEntry
from retrodict.scene.estimates import Complain
from retrodict.scene.measured import Measured
from retrodict.scene.schema import SceneEntry
from retrodict.scene.vehicle_library import find

STANDS_IN = "stands in for drawing; no model that applies uses it"
# what slides is drawn as large as a motorcycle, m: that and what lies around it
_OF_SLIDING, AROUND_SLIDING = {"wheelbase": 1.4, "track": 0.5}, (0.8, 0.3)
_LIKE = "intermediate car"  # of which wheelbase and track stand in
_ALIKE = 0.3  # length of the difference of two unit vectors along nearly the same way
_POINT = 'point = ["0 ± 0.3 m", "0 ± 0.3 m"]'
_CENTRE = 'impact_centre = {{ distance = "2.09 ± 0.05 m", angle = "10 ± 2 deg" }}'
_LINE = 'contact_line = "-8.9 ± 3 deg"'
# keys without which the contact is not known, and examples of them
OF_CONTACT = {"contact_line": _LINE, "impact_centre": _CENTRE}


def unwritten_keys(entry: SceneEntry, complain: Complain) -> tuple[str, ...]:
    """Paths of the keys that only some models need and the file does not have.

    Args:
        entry: the file's entries.
        complain: called for keys that this scene cannot do without.
    """
    entries, impact = entry.vehicles.by_letter, entry.impact
    found = [f"vehicles.{v}.{key}" for v, each in entries.items() for key in each.unwritten]
    if impact.contact_line is None:
        found.append("impact.contact_line")
    if impact.point is None:
        found.append("impact.point")
        placed = any(s.edge or s.outline for s in entry.surfaces.values()) or any(
            v.on_way or (v.rest and v.rest.position) for v in entries.values()
        )
        if (placed and not entry.alone) or entry.barrier:
            complain("impact.point", f"missing; write {_POINT}")
    if entry.barrier and impact.together:
        complain("impact.together", "a barrier does not go on with the vehicle; leave it out")
    for path in found if entry.barrier else ():
        fix = OF_CONTACT.get(path.rpartition(".")[2])
        if fix:
            complain(path, f"missing; write {fix}: a crash into a barrier cannot do without")
    return tuple(found)


def other_side(letter: str, entries: Mapping[str, VehicleEntry]) -> complex | None:
    """Direction of a vehicle as the other one sees it move; None where there is none to see it.

    Args:
        letter: letter of the vehicle.
        entries: entries of the vehicles by letter.
    """
    other = next((each for v, each in entries.items() if v != letter), None)
    if other is None:
        return None
    own, its = (cmath.rect(1, each.heading.value) for each in (entries[letter], other))
    return own - its


def impact_centre(
    letter: str, entry: VehicleEntry, size: float, towards: complex | None, complain: Complain
) -> tuple[Measured, Measured]:
    """Distance and angle of the impact centre: as written, or on the side from which the other came.

    Args:
        letter: letter of the vehicle.
        entry: entry of the vehicle.
        size: length and width of the vehicle together, m.
        towards: direction as from `other_side`.
        complain: called where both vehicles head the same way.
    """
    if entry.impact_centre:
        return entry.impact_centre.distance, entry.impact_centre.angle
    if towards is None:  # it struck no vehicle: places are counted from where its marks begin
        nowhere = Measured(0.0, source=STANDS_IN, assumed="stand-in")
        return nowhere, nowhere
    reach, side = DEFAULTS["impact_reach"], DEFAULTS["impact_side"]
    if abs(towards) < _ALIKE:
        who = "both vehicles head the same way, so that it tells which was in front"
        complain(f"vehicles.{letter}.impact_centre", f"missing; write {_CENTRE}: {who}")
    angle = math.remainder(cmath.phase(towards) - entry.heading.value, math.tau)
    distance = size / 4
    return (
        Measured(distance, reach.amount(distance), "lognormal", f"assumed: ± {reach}", "value"),
        Measured(angle, side.amount(angle), source=f"assumed: ± {side}", assumed="value"),
    )


def with_stand_ins(entry: VehicleEntry) -> VehicleEntry:
    """The entry of a vehicle with a wheelbase and track, exact, where the file has none.

    Args:
        entry: entry of the vehicle.
    """
    like = find(_LIKE)
    assert like is not None, "the library has it"
    sizes = {key: getattr(like, key).value for key in _OF_SLIDING}
    size = {
        key: Measured(value, source=STANDS_IN, assumed="stand-in")
        for key, value in (_OF_SLIDING if entry.slides else sizes).items()
        if key in entry.unwritten
    }
    if "wheelbase" not in size:
        return entry.model_copy(update=size)
    base = size["wheelbase"].value
    share = DEFAULTS["cg_to_front_axle"].amount(base)
    axles = {
        "cg_to_front_axle": replace(size["wheelbase"], value=share),
        "cg_to_rear_axle": replace(size["wheelbase"], value=base - share),
    }
    inertia = entry.mass.value * DEFAULTS["yaw_radius"].amount(base) ** 2
    stand_in = replace(size["wheelbase"], value=inertia)
    return entry.model_copy(update={"yaw_inertia": entry.yaw_inertia or stand_in} | axles | size)
