"""Conversion of the entries of a scene file into the records of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from retrodict.scene.build_motion import approach_of, contradicts, kept_values, mark_of, rest_of
from retrodict.scene.defaults import DEFAULTS, FRICTION
from retrodict.scene.energy import ENERGY
from retrodict.scene.entries.impact import (
    BarrierEntry,
    EdgeEntry,
    ImpactEntry,
    OutlineEntry,
    SurfaceEntry,
)
from retrodict.scene.entries.vehicle import VehicleEntry
from retrodict.scene.estimates import (
    Complain,
    axle_distances,
    estimated_yaw_inertia,
    mean_drag,
    run_out_error,
    wheels_of,
)
from retrodict.scene.fields import (
    AFTER,
    IMPACT,
    SLOPE,
    SURFACE,
    VEHICLE,
    Evidence,
)
from retrodict.scene.questions import questions_of
from retrodict.scene.records import (
    Barrier,
    Contact,
    Edge,
    Items,
    Measured,
    Outline,
    Scene,
    Slope,
    Surface,
    Vehicle,
)
from retrodict.scene.schema import SceneEntry
from retrodict.scene.units import GRADE
from retrodict.scene.unknowns import coefficients_of, priors_of, question_of
from retrodict.scene.unwritten import (
    AROUND_SLIDING,
    STANDS_IN,
    impact_centre,
    other_side,
    unwritten_keys,
    with_stand_ins,
)
from retrodict.scene.vehicle_library import find

_SURE = 2  # standard deviations by which friction has to exceed a slope


def scene_of(entry: SceneEntry, name: str, text: str, complain: Complain) -> Scene:
    """The scene that a scene file describes.

    Args:
        entry: the file's entries, each plausible by itself.
        name: short identifier.
        text: the file as it was written.
        complain: called for entries that contradict one another; the scene is then of no use.

    Returns:
        The scene, with every default filled in.
    """
    entries = entry.vehicles.by_letter
    _not_exchanged(entries, complain)
    surfaces, nowhere = _surfaces(entry)
    road = surfaces[0]
    priors = priors_of(entry, complain)
    unwritten = unwritten_keys(entry, complain)
    after: dict[str, Any] = {
        name: _by_vehicle(entries, partial(_items, own)) for name, own in AFTER.items()
    }
    scene = Scene(
        title=entry.title,
        name=name,
        text=text,
        vehicles=_by_vehicle(
            entries, lambda v, own: _vehicle(v, own, other_side(v, entries), road, complain)
        ),
        approach=_by_vehicle(
            entries, lambda _, own: approach_of(own.approach, own.heading, road.name)
        ),
        rest=_by_vehicle(entries, lambda v, own: rest_of(v, own.rest, own.heading.value, complain)),
        contact=_contact(entry.impact),
        surfaces=surfaces,
        skidded_on=nowhere,
        notes=tuple(entry.notes),
        question=question_of(entry, priors, unwritten, complain),
        unwritten=unwritten,
        priors=priors,
        marks=_by_vehicle(entries, lambda _, own: tuple(map(mark_of, own.marks))),
        robust=entry.errors == "robust",
        questions=questions_of(entry.questions),
        barrier=_barrier(entry.barrier),
        energy_lost={k: stated for k in ENERGY if (stated := getattr(entry.impact, k))},
        slope=Slope(**kept_values(entry.slope, SLOPE)) if entry.slope else None,
        coefficients={k: m for k, m in coefficients_of(entry.impact).items() if m.sd},
        **after,
    )
    for v in scene.vehicles:
        _stops(scene, v, complain)
    _slid_on_known(entry, complain)
    return scene


def _by_vehicle[T](
    entries: Mapping[str, VehicleEntry], read: Callable[[str, VehicleEntry], T | None]
) -> dict[str, T]:
    """What a function reads of each vehicle's entry, by vehicle, without those with nothing to read."""
    found = {letter.lower(): read(letter, entry) for letter, entry in entries.items()}
    return {v: each for v, each in found.items() if each}


def _slid_on_known(entry: SceneEntry, complain: Complain) -> None:
    """Refuse skids on surfaces that the file does not have, and critical speeds on a slope."""
    for v, each in entry.vehicles.by_letter.items():
        approach, names = each.approach, ", ".join(entry.surfaces)
        parts = [(f"skids[{i}]", piece.surface) for i, piece in enumerate(approach.skids)]
        if yaw := approach.yaw_mark:
            parts.append(("yaw_mark", yaw.surface))
            if entry.slope:
                complain(
                    f"vehicles.{v}.approach.yaw_mark",
                    "the critical speed on a slope is not modelled; leave it out, or slope",
                )
        for key, name in parts:
            if name is not None and name not in entry.surfaces:
                complain(
                    f"vehicles.{v}.approach.{key}.surface",
                    f"no such surface; write one of {names}, or [surfaces.{name}]",
                )


def _stops(scene: Scene, v: str, complain: Complain) -> None:
    """Refuse a slope that may drive a vehicle on: the run-out ends where friction ends the motion."""
    if scene.slope is None:
        return
    vehicle, surface = scene.vehicles[v], min(scene.surfaces, key=lambda s: s.friction.value)
    factors = surface.friction, vehicle.grip, mean_drag(vehicle)
    held = math.prod(m.value for m in factors)
    less = math.hypot(*(m.sd / m.value for m in factors)) if held else 0.0
    least, grade = held * math.exp(-_SURE * less), scene.slope.grade
    steepest = grade.value + _SURE * grade.sd
    if least > steepest:
        return
    holds = f"its wheels hold {100 * held:.3g} % of its weight on the {surface.name}"
    if vehicle.wheels is None:
        fix = "look at that friction, or leave the slope out"
    else:
        fix = "write the drag of wheels that held more, or leave the slope out"
    complain(
        "slope.grade",
        f"it may drive vehicle {v.upper()} on instead of letting it stop: {holds}, less "
        f"{_SURE} standard deviations {100 * least:.3g} %, and the slope adds up to "
        f"{100 * steepest:.3g} %; {fix}",
        dimension=GRADE,
    )


def _barrier(entry: BarrierEntry | None) -> Barrier | None:
    if entry is None:
        return None
    diameter = entry.diameter.value if entry.diameter else 0.0
    return Barrier(entry.kind, entry.name or entry.kind, diameter)


def _vehicle(
    letter: str,
    entry: VehicleEntry,
    towards: complex | None,
    road: Surface,
    complain: Complain,
) -> Vehicle:
    known = find(entry.kind) if entry.kind else None
    entry = with_stand_ins(entry)
    assert entry.track is not None, "it stands in where it is missing"
    front, rear = axle_distances(letter, entry, known, complain)
    base = entry.wheelbase or Measured(front.value + rear.value, math.hypot(front.sd, rear.sd))
    length, width = _size(letter, entry, front.value + rear.value, base.value, complain)
    reach = math.hypot(length, width) / 2 + 0.5
    distance, angle = impact_centre(letter, entry, length + width, towards, complain)
    if entry.impact_centre and distance.value > reach:
        complain(
            f"vehicles.{letter}.impact_centre.distance",
            "outside the vehicle; write a distance from its centre of gravity of at most {amount} "
            "(half its diagonal and half a metre), or correct its length and width",
            reach,
        )
    wheels = wheels_of(entry, road.friction.value)
    return Vehicle(
        name=entry.name or entry.kind or f"vehicle {letter}",
        kind=entry.kind or "",
        mass=entry.mass,
        yaw_inertia=entry.yaw_inertia or estimated_yaw_inertia(entry.mass, base, known),
        front_axle=front,
        rear_axle=rear,
        track=entry.track,
        impact_distance=distance,
        impact_angle=angle,
        heading=entry.heading,
        length=length,
        width=width,
        wheels=wheels,
        articulated=entry.articulation == "locked" or bool(known and known.articulated),
        run_out_error=run_out_error(entry, front.value, rear.value, wheels),
        **kept_values(entry, VEHICLE),
    )


def _size(
    letter: str, entry: VehicleEntry, axles: float, wheelbase: float, complain: Complain
) -> tuple[float, float]:
    """Length and width of a vehicle, m, as written, or by the distances of its axles and its wheels."""
    assert entry.track is not None, "it stands in where it is missing"
    overhang, margin = DEFAULTS["length"].value, DEFAULTS["width"].value
    if entry.slides:
        overhang, margin = AROUND_SLIDING
    length = entry.length.value if entry.length else axles + overhang
    if length < wheelbase:
        complain(
            f"vehicles.{letter}.length",
            "shorter than the wheelbase of {amount}; correct one of them",
            wheelbase,
        )
    return length, entry.width.value if entry.width else entry.track.value + margin


def _items(table: Evidence, letter: str, entry: VehicleEntry) -> Items:
    """What a vehicle's table of evidence holds, by key, in the order of the table's declaration."""
    written = getattr(entry, table.table)
    return {key: m for key in table.fields if (m := getattr(written, key, None))}


def _contact(entry: ImpactEntry) -> Contact:
    stand_in = Measured(0.0, source=STANDS_IN, assumed="stand-in")
    x, y = entry.point or (stand_in, stand_in)
    kept = kept_values(entry, IMPACT)
    kept["Gamma"] = kept["Gamma"] or stand_in
    return Contact(
        x=x,
        y=y,
        interlocked=entry.interlocked,
        together=entry.together is True,
        perhaps_together=entry.together == "perhaps",
        **kept,
    )


def _not_exchanged(entries: Mapping[str, VehicleEntry], complain: Complain) -> None:
    """Refuse rest poses that fit the headings and rotations of the other vehicle alone."""
    if _exchanged(entries):
        complain(
            "vehicles.A.rest.position",
            "the rest poses of A and B seem exchanged: as written a rotation contradicts the headings, "
            "the other way round none does; exchange vehicles.A.rest and vehicles.B.rest",
        )


def _exchanged(entries: Mapping[str, VehicleEntry]) -> bool:
    """Whether rotations contradict headings, but would not if the rest poses were exchanged."""
    if len(entries) < 2:
        return False

    def contradiction(vehicle: str, rest_of: str) -> bool:
        rest = entries[rest_of].rest
        return rest is None or contradicts(rest, entries[vehicle].heading.value)

    a, b = entries
    as_written = contradiction(a, a) or contradiction(b, b)
    return as_written and not (contradiction(a, b) or contradiction(b, a))


def _surfaces(entry: SceneEntry) -> tuple[tuple[Surface, ...], tuple[Surface, ...]]:
    """Surfaces of the scene, the road first; and those of skids and yaw marks that lie nowhere in it."""
    # the schema sees to it that nothing slides where none is written; still a scene has a road
    written = entry.surfaces or {"road": SurfaceEntry(kind="dry asphalt")}
    slid_on = set[str]().union(
        *(each.approach.slid_on for each in entry.vehicles.by_letter.values())
    )

    def place(item: tuple[str, SurfaceEntry]) -> int:
        name, surface = item
        return 3 if surface.outline else 2 if surface.edge else 1 if name in slid_on else 0

    # surfaces keep their order, but for the road and outlines, which are what covers last
    road, *others = (_surface(*item) for item in sorted(written.items(), key=place))
    nowhere = tuple(s for s in others if s.edge is None and s.outline is None)
    return (road, *(s for s in others if s not in nowhere)), nowhere


def _surface(name: str, entry: SurfaceEntry) -> Surface:
    friction = entry.friction or _friction_of(entry.kind or "")
    edge = _edge(entry.edge) if entry.edge else None
    outline = _outline(entry.outline) if entry.outline else None
    return Surface(name, friction, edge=edge, outline=outline, **kept_values(entry, SURFACE))


def _friction_of(kind: str) -> Measured:
    table = FRICTION[kind]
    return Measured(table.value, table.sd, "lognormal", f"assumed of {kind}: {table}", "value")


def _edge(entry: EdgeEntry) -> Edge:
    x, y = entry.point
    return Edge(
        x=x.value,
        y=y.value,
        direction=entry.direction.value,
        side=entry.side,
        offset=_offset(entry.uncertainty),
    )


def _outline(entry: OutlineEntry) -> Outline:
    corners = tuple((x.value, y.value) for x, y in entry.corners)
    return Outline(corners, _offset(entry.uncertainty))


def _offset(sd: Measured | None) -> Measured:
    return Measured(0.0, sd.value, source=sd.source) if sd else Measured(0.0)
