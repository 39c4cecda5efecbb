"""From the entries of a scene file to the records of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Protocol

from retrodict.scene import discrepancy
from retrodict.scene.defaults import DEFAULTS, FRICTION, MOST_ROLLING
from retrodict.scene.energy import ENERGY
from retrodict.scene.priors import Prior, default_priors, overridden
from retrodict.scene.quantities import UNKNOWNS
from retrodict.scene.questions import questions_of
from retrodict.scene.records import (
    WHEELS,
    Approach,
    Barrier,
    Contact,
    Edge,
    EndOfRotation,
    Mark,
    Measured,
    Outline,
    Rest,
    RunOutError,
    Scene,
    Slope,
    SpeedRecord,
    Surface,
    Vehicle,
    Wheels,
)
from retrodict.scene.schema import (
    ApproachEntry,
    BarrierEntry,
    EdgeEntry,
    MarkEntry,
    OutlineEntry,
    PriorsEntry,
    RestEntry,
    SceneEntry,
    SurfaceEntry,
    VehicleEntry,
)
from retrodict.scene.units import ANGLE, GRADE, LENGTH, Dimension
from retrodict.scene.vehicle_library import VehicleClass, find

_SLIDES = math.radians(15)  # off its heading a vehicle slides: tyres that roll slip by some 10 deg
_SURE = 2  # standard deviations by which friction has to exceed a slope


class Complain(Protocol):
    """Called with a problem of a scene file."""

    def __call__(
        self, key: str, fix: str, amount: float = 0.0, dimension: Dimension = LENGTH
    ) -> None:
        """Note it.

        Args:
            key: dotted.
            fix: what to write instead; `{amount}` in it is given in the unit that the file has there.
            amount: in SI units or radians.
            dimension: of it.
        """


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
    if _exchanged(entries):
        complain(
            "vehicles.A.rest.position",
            "the rest poses of A and B seem exchanged: as written a rotation contradicts the headings, "
            "the other way round none does; exchange vehicles.A.rest and vehicles.B.rest",
        )
    # the schema sees to it that nothing slides where none is written; still a scene has a road
    written = entry.surfaces or {"road": SurfaceEntry(kind="dry asphalt")}
    # surfaces keep their order, but for the road and outlines, which are what covers last
    in_order = sorted(
        written.items(), key=lambda item: 2 if item[1].outline else 1 if item[1].edge else 0
    )
    surfaces = tuple(_surface(*item) for item in in_order)
    friction = surfaces[0].friction.value
    of_a = entry.vehicles.A.approach
    speed_is_known = bool(of_a.speed or of_a.speed_record)
    not_asked = {"speed_a" if speed_is_known else "", "speed_b" if entry.barrier else ""}
    scene = Scene(
        title=entry.title,
        name=name,
        text=text,
        vehicles={v.lower(): _vehicle(v, entries[v], friction, complain) for v in entries},
        approach={
            v.lower(): _approach(each.approach, each.impact.heading) for v, each in entries.items()
        },
        rest={
            v.lower(): _rest(v, each.rest, each.impact.heading.value, complain)
            for v, each in entries.items()
            if each.rest
        },
        contact=Contact(*entry.impact.point, entry.impact.contact_line, entry.impact.interlocked),
        surfaces=surfaces,
        notes=tuple(entry.notes),
        question=entry.question or tuple(name for name in UNKNOWNS if name not in not_asked),
        priors=_priors(entry.priors),
        departure={
            v.lower(): {name: measured for name, measured in each.departure if measured}
            for v, each in entries.items()
            if each.departure
        },
        marks={
            v.lower(): tuple(map(_mark, each.marks)) for v, each in entries.items() if each.marks
        },
        end_of_rotation={
            v.lower(): EndOfRotation(**dict(each.end_of_rotation))
            for v, each in entries.items()
            if each.end_of_rotation
        },
        robust=entry.errors == "robust",
        questions=questions_of(entry.questions),
        barrier=_barrier(entry.barrier) if entry.barrier else None,
        energy_lost={k: stated for k in ENERGY if (stated := getattr(entry.impact, k))},
        slope=Slope(entry.slope.grade, entry.slope.uphill) if entry.slope else None,
    )
    for v in scene.vehicles:
        _stops(scene, v, complain)
    return scene


def _stops(scene: Scene, v: str, complain: Complain) -> None:
    """Refuse a slope that may drive a vehicle on: the run-out ends where friction ends the motion."""
    if scene.slope is None:
        return
    vehicle, surface = scene.vehicles[v], min(scene.surfaces, key=lambda s: s.friction.value)
    factors = surface.friction, vehicle.grip, _mean_drag(vehicle)
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


def _mean_drag(vehicle: Vehicle) -> Measured:
    """The drag of a vehicle's wheels over friction, weighted by their static loads."""
    if (wheels := vehicle.wheels) is None:
        return Measured(1.0)
    front = vehicle.rear_axle.value / (vehicle.front_axle.value + vehicle.rear_axle.value) / 2
    loads = (front, front, 0.5 - front, 0.5 - front)
    factor = wheels.factor or Measured(1.0)
    drags, sds = [], []
    for wheel, load in zip(WHEELS, loads, strict=True):
        own: Measured = getattr(wheels, wheel)
        drag = factor.value * own.value / (1 - own.value + factor.value * own.value)
        drags.append(load * drag)
        sds.append(load * own.sd)
    common = factor.sd * sum(
        drag * (1 - drag / load) for drag, load in zip(drags, loads, strict=True)
    )
    return Measured(sum(drags), math.hypot(common, *sds))


def _barrier(entry: BarrierEntry) -> Barrier:
    diameter = entry.diameter.value if entry.diameter else 0.0
    return Barrier(entry.kind, entry.name or entry.kind, diameter)


def _vehicle(letter: str, entry: VehicleEntry, friction: float, complain: Complain) -> Vehicle:
    known = find(entry.kind) if entry.kind else None
    front, rear = _axle_distances(letter, entry, known, complain)
    base = entry.wheelbase or Measured(front.value + rear.value, math.hypot(front.sd, rear.sd))
    wheelbase = base.value
    overhang, margin = DEFAULTS["length"].value, DEFAULTS["width"].value
    length = entry.length.value if entry.length else front.value + rear.value + overhang
    width = entry.width.value if entry.width else entry.track.value + margin
    if length < wheelbase:
        complain(
            f"vehicles.{letter}.length",
            "shorter than the wheelbase of {amount}; correct one of them",
            wheelbase,
        )
    reach = math.hypot(length, width) / 2 + 0.5
    if entry.impact_centre.distance.value > reach:
        complain(
            f"vehicles.{letter}.impact_centre.distance",
            "outside the vehicle; write a distance from its centre of gravity of at most {amount} "
            "(half its diagonal and half a metre), or correct its length and width",
            reach,
        )
    wheels = _wheels(entry, friction)
    return Vehicle(
        name=entry.name or entry.kind or f"vehicle {letter}",
        kind=entry.kind or "",
        mass=entry.mass,
        yaw_inertia=entry.yaw_inertia or _estimated_yaw_inertia(entry.mass, base, known),
        front_axle=front,
        rear_axle=rear,
        track=entry.track,
        cg_height=entry.cg_height,
        impact_distance=entry.impact_centre.distance,
        impact_angle=entry.impact_centre.angle,
        heading=entry.impact.heading,
        length=length,
        width=width,
        grip=entry.grip or _assumed_grip(),
        wheels=wheels,
        run_out_error=_run_out_error(entry, front.value, rear.value, wheels),
    )


def _assumed_grip() -> Measured:
    spread = DEFAULTS["grip"]
    return Measured(1.0, spread.amount(1.0), "lognormal", f"assumed: 1 ± {spread}", "value")


def _wheels(entry: VehicleEntry, friction: float) -> Wheels | None:
    if entry.wheels is None:
        return None
    written = dict(entry.wheels)
    drags = {
        wheel: _drag_of_word(drag, friction) if isinstance(drag, str) else drag
        for wheel, drag in written.items()
    }
    ahead = Measured(0.0, source="assumed: the front wheels point straight ahead", assumed="value")
    factor = entry.drag_factor
    if factor is None and any(drag.assumed for drag in drags.values()):
        spread = DEFAULTS["drag_factor"]
        factor = Measured(1.0, spread.amount(1.0), "lognormal", f"assumed: 1 ± {spread}", "value")
    return Wheels(**drags, steer=entry.steer or ahead, factor=factor)


def _drag_of_word(word: str, friction: float) -> Measured:
    """The drag of a wheel described by a word: some of its force does not grow with the friction."""
    if word == "locked":
        return Measured(1.0, 0.0, "logitnormal", word)
    key = word.replace(", ", "_").replace(" ", "_")
    drag, spread = DEFAULTS[key], DEFAULTS[f"{key}_sd"]
    value, sd = drag.amount(friction), spread.amount(friction)
    if value > MOST_ROLLING:
        value, sd = MOST_ROLLING, MOST_ROLLING * (1 - MOST_ROLLING)
    source = f"{word}; assumed: {drag}; uncertainty assumed: {spread}"
    return Measured(value, sd, "logitnormal", source, "value")


def _run_out_error(
    entry: VehicleEntry, front: float, rear: float, wheels: Wheels | None
) -> RunOutError:
    """How far a run-out model misses a vehicle: as written, or by how freely it rolled."""
    drags = [getattr(wheels, wheel).value for wheel in WHEELS] if wheels else [1.0] * 4
    free = discrepancy.freedom(front, rear, drags)

    def assumed(key: str) -> Measured:
        most = DEFAULTS[key]
        source = f"assumed: {free:.2g} (1 less the mean drag of its wheels) times {most}"
        return Measured(free * most.amount(1.0), source=source, assumed="value")

    return RunOutError(
        position=entry.run_out_error.position or assumed("run_out_position"),
        heading=entry.run_out_error.heading or assumed("run_out_heading"),
    )


def _axle_distances(
    letter: str, entry: VehicleEntry, known_class: VehicleClass | None, complain: Complain
) -> tuple[Measured, Measured]:
    front, rear, wheelbase = entry.cg_to_front_axle, entry.cg_to_rear_axle, entry.wheelbase
    key = f"vehicles.{letter}.wheelbase"
    if front and rear:
        total = front.value + rear.value
        if wheelbase and abs(total - wheelbase.value) > 0.05 * wheelbase.value:
            complain(
                key,
                "the two axle distances add up to {amount}; write a wheelbase within 5 % of that, or "
                "leave it out",
                total,
            )
        return front, rear
    assert wheelbase is not None, "the schema sees to it"
    if front is None and rear is None:
        share, spread = DEFAULTS["cg_to_front_axle"], DEFAULTS["cg_position"]
        ahead, sd = share.amount(wheelbase.value), spread.amount(wheelbase.value)
        source = f"assumed from the wheelbase: {share}; uncertainty assumed: {spread}"
        if known_class:
            of_class = known_class.assumed(known_class.cg_share)
            ahead, sd = of_class.value * wheelbase.value, of_class.sd * wheelbase.value
            source = f"{of_class.value:g} ± {of_class.sd:g} wheelbases, {of_class.source}"
            source += f"; wheelbase {wheelbase.source}" if wheelbase.assumed else ""
        sd = math.hypot(sd, wheelbase.sd / 2)
        front, rear = (
            Measured(value, sd, "lognormal", source, "value")
            for value in (ahead, wheelbase.value - ahead)
        )
        return front, rear
    known = front or rear
    assert known is not None
    other = replace(
        known,
        value=wheelbase.value - known.value,
        sd=math.hypot(wheelbase.sd, known.sd),
        source="the wheelbase less the other axle's distance",
    )
    if other.value < max(0.05, other.sd):
        complain(key, "leaves no room for both axles; write one above {amount}", known.value)
    return (known, other) if front else (other, known)


def _estimated_yaw_inertia(
    mass: Measured, wheelbase: Measured, known: VehicleClass | None
) -> Measured:
    if known:  # whose mass may be so uncertain that it counts, as the wheelbase may
        of_class = known.assumed(known.yaw_radius)
        value = mass.value * (of_class.value * wheelbase.value) ** 2
        parts = (mass.sd / mass.value, *(2 * m.sd / m.value for m in (of_class, wheelbase)))
        source = (
            f"estimated as m k² with k = {of_class.value:g} ± {of_class.sd:.2g} wheelbases, "
            f"{of_class.source}; the uncertainties of mass and wheelbase added"
        )
        return Measured(value, math.hypot(*parts) * value, "lognormal", source, "value")
    radius, spread = DEFAULTS["yaw_radius"], DEFAULTS["yaw_inertia"]
    value = mass.value * radius.amount(wheelbase.value) ** 2
    source = f"estimated as m k² with k = {radius}; uncertainty assumed: {spread}"
    return Measured(value, spread.amount(value), "lognormal", source, "value")


def _approach(entry: ApproachEntry, heading: Measured) -> Approach:
    """Motion before impact: along the heading and without yaw, unless the file says that it slid."""
    speed, record = _speed(entry)
    direction = _known(entry.direction, lambda: along(heading))
    # a vehicle that slides sideways has begun to yaw
    slides = (
        direction is None
        or abs(math.remainder(direction.value - heading.value, math.tau)) > _SLIDES
    )
    yaw_rate = _known(entry.yaw_rate, lambda: None if slides else without_yaw())
    return Approach(speed, direction, yaw_rate, entry.skid, record)


def _known(
    written: Measured | str | None, assumed: Callable[[], Measured | None]
) -> Measured | None:
    """What was written, None where that is "unknown", and what is assumed where nothing is written."""
    if written is None:
        return assumed()
    return None if isinstance(written, str) else written


def along(heading: Measured) -> Measured:
    """The direction of travel of a vehicle that did not slide, whose heading was measured."""
    spread = DEFAULTS["course"]
    return Measured(
        heading.value,
        math.hypot(heading.sd, spread.amount(heading.value)),
        source=f"assumed: along the heading at impact, whose error is added to ± {spread}",
        assumed="value",
    )


def without_yaw() -> Measured:
    """The yaw rate of a vehicle that neither slid nor turned."""
    spread = DEFAULTS["yaw_rate"]
    return Measured(0.0, spread.amount(0.0), source=f"assumed: 0 ± {spread}", assumed="value")


def _speed(entry: ApproachEntry) -> tuple[Measured | None, SpeedRecord | None]:
    """The speed as measured, or mean and deviation of what a recorder kept, and that record."""
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


def _mark(entry: MarkEntry) -> Mark:
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


def _rest(letter: str, entry: RestEntry, at_impact: float, complain: Complain) -> Rest:
    x, y = entry.position
    if entry.heading is None:
        return Rest(x, y, None, turns_known=False)
    turned = entry.heading.value - at_impact  # but for whole turns
    expected = entry.rotation.value if entry.rotation else 0.0
    rotation = turned + math.tau * round((expected - turned) / math.tau)
    if _contradicts(entry, at_impact):
        complain(
            f"vehicles.{letter}.rest.rotation",
            "the two headings differ by {amount} and whole turns; write a rotation (positive "
            "counter-clockwise) within 45 deg of that, or correct a heading",
            math.remainder(turned, math.tau),
            ANGLE,
        )
    heading = replace(entry.heading, value=at_impact + rotation)
    return Rest(x, y, heading, turns_known=entry.rotation is not None)


def _contradicts(entry: RestEntry, at_impact: float) -> bool:
    """Whether a rotation is over an eighth of a turn off that by the headings, but for whole turns."""
    if not (entry.heading and entry.rotation):
        return False
    off = entry.heading.value - at_impact - entry.rotation.value
    return abs(math.remainder(off, math.tau)) > math.pi / 4


def _exchanged(entries: Mapping[str, VehicleEntry]) -> bool:
    """Whether rotations contradict headings, and would not if A had the rest pose of B and B A's."""
    if len(entries) < 2:
        return False

    def contradiction(of: str, rest_of: str) -> bool:
        rest = entries[rest_of].rest
        return rest is None or _contradicts(rest, entries[of].impact.heading.value)

    a, b = entries
    as_written = contradiction(a, a) or contradiction(b, b)
    return as_written and not (contradiction(a, b) or contradiction(b, a))


def _surface(name: str, entry: SurfaceEntry) -> Surface:
    dependence = entry.speed_dependence or Measured(
        0.0, source="assumed: friction does not depend on speed", assumed="value"
    )
    friction = entry.friction or _friction_of(entry.kind or "")
    edge = _edge(entry.edge) if entry.edge else None
    outline = _outline(entry.outline) if entry.outline else None
    return Surface(name, friction, dependence, edge, outline)


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


def _priors(entry: PriorsEntry) -> dict[str, Prior]:
    priors = default_priors()
    for name, written in entry:
        if written is not None:
            numbers = {key: m for key, m in written if isinstance(m, Measured)}
            sources = [written.source, *(m.source for m in numbers.values() if m.source)]
            values = {key: m.value for key, m in numbers.items()}
            priors[name] = overridden(name, values, "; ".join(sources))
    return priors
