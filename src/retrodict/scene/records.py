"""Frozen records of the measurements at a scene, in SI units and radians: no files, no other units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, is_dataclass
from typing import TYPE_CHECKING, Any, Literal

from retrodict.scene import discrepancy
from retrodict.scene.asked import Questions
from retrodict.scene.energy import ENERGY
from retrodict.scene.fields import AFTER, APPROACH, COEFFICIENTS
from retrodict.scene.measured import Law as Law
from retrodict.scene.measured import Measured as Measured
from retrodict.scene.motion_records import Approach as Approach
from retrodict.scene.motion_records import Items as Items
from retrodict.scene.motion_records import Mark as Mark
from retrodict.scene.motion_records import Rest as Rest
from retrodict.scene.motion_records import Skid as Skid
from retrodict.scene.motion_records import YawMark as YawMark
from retrodict.scene.motion_records import marks_before
from retrodict.scene.names import vehicle_of
from retrodict.scene.place_records import Barrier as Barrier
from retrodict.scene.place_records import Contact as Contact
from retrodict.scene.place_records import Edge as Edge
from retrodict.scene.place_records import Outline as Outline
from retrodict.scene.place_records import Slope as Slope
from retrodict.scene.place_records import Surface as Surface
from retrodict.scene.priors import Prior, default_priors, fixed_of
from retrodict.scene.quantities import REPORTED, UNKNOWNS

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    from matplotlib.figure import Figure

    from retrodict.scene.quantities import Units

VEHICLES = ("a", "b")
# an impact after which vehicles part, or one with a barrier; going on together; striking nothing
SceneKind = Literal["impact", "together", "alone"]
FREEDOM = 4.0
_RUN_OUT = ("on the way", "at rest")  # places of `fields.Evidence` that a run-out predicts
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


@dataclass(frozen=True, slots=True)
class Wheels:
    """Braking and steering of a vehicle's wheels after the impact.

    Args:
        front_left: drag of the front left wheel, its braking force over the available friction: 1
            locked, 0 free.
        front_right: drag of the front right wheel.
        rear_left: drag of the rear left wheel.
        rear_right: drag of the rear right wheel.
        steer: angle of the front wheels from the heading, counter-clockwise, rad.
        factor: common factor of drag / (1 - drag) of all wheels, which keeps a drag between 0 and 1
            and a locked wheel locked; None for 1.
    """

    front_left: Measured
    front_right: Measured
    rear_left: Measured
    rear_right: Measured
    steer: Measured
    factor: Measured | None = None


@dataclass(frozen=True, slots=True)
class RunOutError:
    """Error of a run-out model's predicted motion, beyond what the errors of its inputs explain.

    Args:
        position: standard deviation of each coordinate over the length of the path from the impact.
        heading: standard deviation of the heading, rad, at the end of a path that is long enough for
            it to stop growing; see `discrepancy.settled`.
    """

    position: Measured = Measured(0.0)
    heading: Measured = Measured(0.0)

    def of_position(self, length: float) -> float:
        """Standard deviation of each coordinate after a path of this length (m), m."""
        return self.position.value * length

    def of_heading(self, length: float) -> float:
        """Standard deviation of the heading after a path of this length (m), rad."""
        return self.heading.value * discrepancy.settled(length)


@dataclass(frozen=True, slots=True)
class Vehicle:
    """Measured properties of a vehicle and its heading at impact (kg, kg m², m, rad).

    The impact centre is given by its distance from the centre of gravity and its angle, counted
    counter-clockwise from straight ahead. `heading` is the heading at impact, counter-clockwise
    from the x axis. `grip` is a factor of the surfaces' friction for this vehicle's tyres. `wheels`
    is None where all were locked after the impact. `kind` names the entry of the library of vehicles
    whose figures stand where the scene file has none; it is empty where the file names no class.
    `cg_height` is the height of the centre of gravity above the road; None where loads are static.
    `slides` is the drag factor of a body without wheels; None for a vehicle on its wheels.
    `articulated` says that it is a tractor with a trailer, taken as one rigid body.
    """

    name: str
    mass: Measured
    yaw_inertia: Measured
    front_axle: Measured
    rear_axle: Measured
    track: Measured
    impact_distance: Measured
    impact_angle: Measured
    heading: Measured
    length: float
    width: float
    grip: Measured = Measured(1.0, law="lognormal")
    wheels: Wheels | None = None
    run_out_error: RunOutError = RunOutError()
    kind: str = ""
    cg_height: Measured | None = None
    slides: Measured | None = None
    articulated: bool = False


@dataclass(frozen=True)
class Scene:
    """A whole measured scene: what a model needs and a report prints.

    Args:
        title: title of the scene, a single line.
        name: short identifier, used to name output.
        text: the scene file as it was written, for the record.
        vehicles: vehicles by the keys "a" and "b"; "a" alone where it struck a barrier or nothing.
        approach: motion of each vehicle before impact, by the same keys.
        rest: rest pose of each vehicle, by the same keys; without poses that were not measured.
        contact: impact centre and contact line.
        surfaces: road first, then those with edges, then those with outlines.
        notes: remarks of the scene's author, printed in the report.
        question: names of the unknowns that are asked for, in the order of `UNKNOWNS`.
        priors: prior of each unknown, by name; see `default_priors`.
        departure: measured motion of each vehicle after impact, keyed as `rest` is.
        marks: points that each vehicle passed on its way to rest, keyed as `rest` is.
        end_of_rotation: pose in which each vehicle stopped sliding sideways, keyed as `rest` is, then
            by key in `fields.END_OF_ROTATION`.
        robust: whether errors of the evidence have heavy tails, so that an item which contradicts
            the others gives way.
        approximations: errors of a model relative to a more detailed one, by flat name, which the
            model adds to the inputs of its scene.
        questions: questions asked of the reconstruction.
        barrier: barrier that A struck in place of a vehicle B; None where it struck B, or nothing.
        energy_lost: stated kinetic energy lost in the impact, J, by key in `ENERGY`.
        slope: slope of the whole ground; None where it is level.
        coefficients: measured coefficients of the impact, by key in `fields.COEFFICIENTS`.
        from_impact: distance and direction from impact to rest, where no rest pose was measured, keyed
            as `rest` is.
        unwritten: paths of the file's keys that some models need and the file does not have; the
            records hold stand-ins in their places.
        extra: log likelihood terms of the user's own, by name: functions, None once stored.
        skidded_on: surfaces of skids and yaw marks that lie nowhere in the scene, or that a run-out
            leaves out.
    """

    title: str
    name: str
    text: str
    vehicles: dict[str, Vehicle]
    approach: dict[str, Approach]
    rest: dict[str, Rest]
    contact: Contact
    surfaces: tuple[Surface, ...]
    notes: tuple[str, ...] = ()
    question: tuple[str, ...] = UNKNOWNS[1:]
    priors: dict[str, Prior] = field(default_factory=default_priors)
    departure: dict[str, Items] = field(default_factory=dict)
    marks: dict[str, tuple[Mark, ...]] = field(default_factory=dict)
    end_of_rotation: dict[str, Items] = field(default_factory=dict)
    robust: bool = False
    approximations: dict[str, Measured] = field(default_factory=dict)
    questions: Questions = field(default_factory=Questions)
    barrier: Barrier | None = None
    energy_lost: dict[str, Measured] = field(default_factory=dict)
    slope: Slope | None = None
    coefficients: dict[str, Measured] = field(default_factory=dict)
    from_impact: dict[str, Items] = field(default_factory=dict)
    unwritten: tuple[str, ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)
    skidded_on: tuple[Surface, ...] = ()

    if TYPE_CHECKING:
        # these need the schema or matplotlib, and import this module: `scene` and `notebook` attach
        # them to the class
        def change(self, changes: Mapping[str, object]) -> Scene:
            """A copy of the scene with other values at some keys of its scene file."""

        def to_toml(self) -> str:
            """The text of a scene file that describes the scene."""

        def plot(self, units: Units = "si") -> Figure:
            """Draw the measured scene from above, to scale."""

    @property
    def followed(self) -> bool:
        """Whether anything was measured of a vehicle's way from the impact to rest, or there."""
        tables = (getattr(self, name) for name, own in AFTER.items() if own.where in _RUN_OUT)
        return any((self.rest, self.marks, *tables))

    @property
    def rolling(self) -> tuple[str, ...]:
        """Vehicles with a wheel that was not locked after the impact."""
        return tuple(v for v, vehicle in self.vehicles.items() if vehicle.wheels is not None)

    @property
    def sought(self) -> Literal["speed_a", "speed_b"]:
        """The impact speed that studies follow: of those asked, one that was not measured; B's first."""
        fixed = fixed_of(self.priors)
        known = {v for v, own in self.approach.items() if own.speed or f"speed_{v}" in fixed}
        if self.single or ("speed_a" in self.question and "a" not in known and "b" in known):
            return "speed_a"
        return "speed_b"

    def inputs(self) -> dict[str, Measured]:
        """Every measured quantity but the rest poses, by its flat name (mass_a, friction_road, …)."""
        flat: dict[str, Measured] = {}
        for v, vehicle in self.vehicles.items():
            for part in (vehicle, vehicle.wheels, self.approach[v]):
                flat |= {f"{name}_{v}": measured for name, measured in _measured(part)}
            flat |= {f"{name}_{v}": measured for name, measured in marks_before(self.approach[v])}
        flat |= _measured(self.contact)
        for surface in (*self.surfaces, *self.skidded_on):
            flat |= {f"{name}_{surface.name}": measured for name, measured in _measured(surface)}
            if (end := surface.edge or surface.outline) is not None:
                flat[f"edge_{surface.name}"] = end.offset
        return flat | dict(_measured(self.slope)) | self.approximations

    def stated(self) -> dict[str, Measured]:
        """The inputs that were measured or assumed: without those that only stand in."""
        return {name: m for name, m in self.inputs().items() if m.assumed != "stand-in"}

    def missing(self, keys: Collection[str]) -> list[str]:
        """Paths of those of some keys, named without their tables, that the file does not have."""
        return [path for path in self.unwritten if path.rpartition(".")[2] in keys]

    def evidence(self) -> dict[str, Measured]:
        """Items of evidence for the likelihood, by flat name: rest_x_a, departure_speed_b, mark_1_a, …

        A mark's value is its distance from the path, 0. The standard deviations of positions and
        headings along a vehicle's path after the impact include its `run_out_error`.
        """
        flat: dict[str, Measured | None] = {}
        for v in self.vehicles:
            if (rest := self.rest.get(v)) is None:
                continue
            length = self.path_to(v, rest.x.value, rest.y.value)
            missed = self.vehicles[v].run_out_error
            flat[f"rest_x_{v}"] = rest.x.with_model_sd(missed.of_position(length))
            flat[f"rest_y_{v}"] = rest.y.with_model_sd(missed.of_position(length))
            if rest.heading is not None:
                flat[f"rest_heading_{v}"] = rest.heading.with_model_sd(missed.of_heading(length))
        for v in self.from_impact:
            flat |= self._items("at rest", v)
        for v in self.vehicles:
            missed = self.vehicles[v].run_out_error
            flat |= self._items("after the impact", v)
            for number, mark in enumerate(self.marks.get(v, ()), start=1):
                missed_by = missed.of_position(self.path_to(v, mark.x, mark.y))
                of_mark = Measured(0.0, mark.sd, source=mark.source, assumed=mark.assumed)
                flat[f"mark_{number}_{v}"] = of_mark.with_model_sd(missed_by)
                flat[f"mark_{number}_speed_{v}"] = mark.speed
                flat[f"mark_{number}_course_{v}"] = mark.course
            flat |= self._items("on the way", v)
            if (yaw := self.approach[v].yaw_mark) is not None:
                flat[f"yaw_mark_{v}"] = Measured(1.0, yaw.error.value, source=yaw.error.source)
        flat |= {f"impact_{key}": self.energy_lost.get(key) for key in ENERGY}
        flat |= {f"impact_{key}": self.coefficients.get(key) for key in COEFFICIENTS}
        return {name: measured for name, measured in flat.items() if measured is not None}

    def _items(self, where: str, v: str) -> Iterator[tuple[str, Measured]]:
        """Flat names and values of a vehicle's items in tables of `fields.AFTER`."""
        for name, table in AFTER.items():
            items: Items = getattr(self, name).get(v, {})
            if table.where != where or not items:
                continue
            off = self._missed(table.where, v, items)
            for key, own in table.fields.items():  # programs do not depend on the order written
                if key in items:
                    model_sd = off.get(own.dimension.name, 0.0)
                    yield f"{table.prefix}{key}_{v}", items[key].with_model_sd(model_sd)

    def _missed(self, where: str, v: str, items: Items) -> dict[str, float]:
        """What a run-out's predictions of a vehicle's items miss by, m and rad, by their dimension."""
        missed = self.vehicles[v].run_out_error
        if where == "after the impact":
            return {}
        if where == "at rest":  # seen from the impact
            far = items["distance"].value
            return {"length": missed.of_position(far), "angle": missed.of_position(far) / far}
        places = [(items.get("x"), items.get("y"))]
        places += [(rest.x, rest.y) for rest in (self.rest.get(v),) if rest is not None]
        far = next((self.path_to(v, x.value, y.value) for x, y in places if x and y), 0.0)
        return {"length": missed.of_position(far), "angle": missed.of_heading(far)}

    def path_to(self, v: str, x: float, y: float) -> float:
        """Length of a vehicle's path from the impact to a point on it, m.

        Args:
            v: "a" or "b".
            x: x coordinate of the point, m.
            y: y coordinate of the point, m.

        Returns:
            The length of straight lines from the centre of gravity at impact, through the marks of
            the centre of gravity, to the point; a path that bends between them was longer.
        """
        passed = [(mark.x, mark.y) for mark in self.marks.get(v, ()) if mark.of == "centre"]
        return discrepancy.path_length(self.at_impact(v), passed, (x, y))

    def at_impact(self, v: str) -> tuple[float, float]:
        """Position of the centre of gravity of vehicle `v` at impact, m."""
        vehicle = self.vehicles[v]
        angle = vehicle.heading.value + vehicle.impact_angle.value
        lever = vehicle.impact_distance.value
        return (
            self.contact.x.value - lever * math.cos(angle),
            self.contact.y.value - lever * math.sin(angle),
        )

    @property
    def single(self) -> bool:
        """Whether A is the only vehicle: it struck a barrier, or nothing."""
        return "b" not in self.vehicles

    @property
    def alone(self) -> bool:
        """Whether a vehicle skidded, or ran out, and struck nothing."""
        return self.single and self.barrier is None

    @property
    def kind(self) -> SceneKind:
        """What happened: each kind has models of its own."""
        return "alone" if self.alone else "together" if self.contact.together else "impact"

    @property
    def kinds(self) -> tuple[SceneKind, ...]:
        """What may have happened: where it is in doubt, that the vehicles went on together first."""
        return ("together", self.kind) if self.contact.perhaps_together else (self.kind,)

    @property
    def travelled(self) -> tuple[str, ...]:
        """Vehicles whose speed before their marks is asked first: those that skidded, or are alone."""
        return tuple(v for v in self.vehicles if self.alone or v in self.skidded)

    @property
    def skidded(self) -> tuple[str, ...]:
        """Vehicles with a measured skid up to the impact."""
        return tuple(v for v in self.vehicles if self.approach[v].skid_length)

    @property
    def slid_on(self) -> frozenset[str]:
        """Names of the surfaces of skids in several pieces and of yaw marks."""
        of_skids = {piece.surface for own in self.approach.values() for piece in own.skids}
        marks = (own.yaw_mark for own in self.approach.values())
        return frozenset(of_skids | {mark.surface for mark in marks if mark})

    def reported(self) -> tuple[str, ...]:
        """Names in `REPORTED` of the quantities in the scene's results, where the model knows them."""
        known = self.approach["a"].speed is not None and "speed_a" not in self.question
        left_out = fixed_of(self.priors) | ({"speed_a"} if known else set())
        left_out |= {f"travelling_speed_{v}" for v in self.vehicles if v not in self.travelled}
        left_out |= {"speed_a"} if self.alone else set()
        if self.single:
            left_out |= {name for name in REPORTED if vehicle_of(name) == "b"}
        return tuple(name for name in REPORTED if name not in left_out)

    def __repr__(self) -> str:
        counted = f"{len(self.stated())} inputs, {len(self.evidence())} items of evidence"
        return f"<Scene {self.name!r}: {self.title!r}, {counted}>"


def _measured(record: object) -> Iterator[tuple[str, Measured]]:
    """Flat name, without vehicle or surface, and value of each measured quantity in a record."""
    names = _FLAT.get(type(record), {})
    for each in fields(record) if is_dataclass(record) else ():
        if isinstance(value := getattr(record, each.name), Measured):
            yield names.get(each.name, each.name), value


_FLAT: dict[type, dict[str, str]] = {
    Approach: {key: own.flat for key, own in APPROACH.items() if own.flat},
    Wheels: {wheel: f"drag_{wheel}" for wheel in WHEELS} | {"factor": "drag_factor"},
    Contact: {"x": "impact_x", "y": "impact_y"},
}
