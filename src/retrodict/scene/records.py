"""What was measured at a scene, as frozen records in SI units and radians: no files, no units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

from retrodict.scene import discrepancy
from retrodict.scene.asked import Questions
from retrodict.scene.departure import ITEMS
from retrodict.scene.energy import ENERGY
from retrodict.scene.measured import Law as Law
from retrodict.scene.measured import Measured as Measured
from retrodict.scene.names import vehicle_of
from retrodict.scene.priors import Prior, default_priors
from retrodict.scene.quantities import REPORTED, UNKNOWNS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from retrodict.scene.quantities import Units

VEHICLES = ("a", "b")
FREEDOM = 4.0
UNKNOWN = "unknown"  # how a scene file says that a motion before impact is
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


@dataclass(frozen=True, slots=True)
class Wheels:
    """How a vehicle's wheels turn after the impact.

    Args:
        front_left: braking force over the available friction: 1 locked, 0 free.
        front_right: likewise, and so the other two.
        rear_left: likewise.
        rear_right: likewise.
        steer: angle of the front wheels from the heading, counter-clockwise, rad.
        factor: of drag / (1 - drag) of every wheel, for what their drags have in common, so that a
            share stays one and a locked wheel locked; None for 1.
    """

    front_left: Measured
    front_right: Measured
    rear_left: Measured
    rear_right: Measured
    steer: Measured
    factor: Measured | None = None


@dataclass(frozen=True, slots=True)
class RunOutError:
    """How far a run-out model misses where a vehicle went, beyond what its inputs' errors explain.

    Args:
        position: standard deviation of each coordinate over the length of the way from the impact.
        heading: that of the heading, rad, after a way on which it settles.
    """

    position: Measured = Measured(0.0)
    heading: Measured = Measured(0.0)

    def of_position(self, way: float) -> float:
        """Standard deviation of each coordinate after a way (m), m."""
        return self.position.value * way

    def of_heading(self, way: float) -> float:
        """Standard deviation of the heading after a way (m), rad."""
        return self.heading.value * discrepancy.settled(way)


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle's measured properties and how it stood at impact (kg, kg m², m, rad).

    The impact centre is given by its distance from the centre of gravity and its angle, counted
    counter-clockwise from straight ahead. `heading` is the heading at impact, counter-clockwise
    from the x axis. `grip` is a factor of the surfaces' friction for this vehicle's tyres. `wheels`
    is None where all were locked after the impact. `kind` names the entry of the library of vehicles
    whose figures stand where the scene file has none; it is empty where the file names no class.
    `cg_height` is the height of the centre of gravity above the road; None where loads are static.
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


@dataclass(frozen=True, slots=True)
class SpeedRecord:
    """Speeds that a recorder kept up to the impact, whose moment on its clock is uncertain.

    The speed at the impact is the one on straight lines between those recorded, at a moment of which
    all from `low` to `high` are equally probable, with a normal error.

    Args:
        times: increasing, s; the window lies within them.
        speeds: at these, m/s.
        low: earliest moment of the impact, s.
        high: latest, s.
        sd: of a recorded speed, m/s.
    """

    times: tuple[float, ...]
    speeds: tuple[float, ...]
    low: float
    high: float
    sd: float

    @property
    def within(self) -> tuple[tuple[float, float], ...]:
        """Time and speed where the window begins and ends, and of what was recorded within."""
        inner = [
            (t, v) for t, v in zip(self.times, self.speeds, strict=True) if self.low < t < self.high
        ]
        return ((self.low, self._at(self.low)), *inner, (self.high, self._at(self.high)))

    @property
    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation of the speed at the impact, m/s."""
        mean = square = 0.0
        for (t, v), (t_next, v_next) in pairwise(self.within):
            share = (t_next - t) / (self.high - self.low)
            mean += share * (v + v_next) / 2
            square += share * (v * v + v * v_next + v_next * v_next) / 3
        return mean, math.sqrt(max(square - mean * mean, 0.0) + self.sd**2)

    def _at(self, time: float) -> float:
        for (t, v), (t_next, v_next) in pairwise(zip(self.times, self.speeds, strict=True)):
            if time <= t_next:
                return v + (v_next - v) * (time - t) / (t_next - t)
        return self.speeds[-1]


@dataclass(frozen=True, slots=True)
class Approach:
    """Motion just before impact (m/s, rad, rad/s, m); what is None is unknown.

    `direction` is that of travel, counter-clockwise from the x axis; it need not be the heading, but is
    assumed to be along it where a scene file says nothing.
    `skid` is how far the vehicle skidded on the road, all wheels locked, up to the impact.
    `record` is the law of `speed` where a recorder kept it: `speed` has its mean and deviation.
    """

    speed: Measured | None
    direction: Measured | None
    yaw_rate: Measured | None
    skid: Measured | None = None
    record: SpeedRecord | None = None


Departure = dict[str, Measured]  # motion of a vehicle just after the impact, by name in `ITEMS`


@dataclass(frozen=True, slots=True)
class Rest:
    """Where a vehicle came to rest (m, rad): its centre of gravity and its heading, if measured.

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

    `of` is what of it passed there: "centre" of gravity or a wheel ("front_left", …). `sd` is the
    uncertainty of the point across the path; `source` and `assumed` are as of a `Measured`. `speed`
    (m/s) and `course` (rad), the direction of travel, are of the centre of gravity at that moment;
    None is not measured.
    """

    x: float
    y: float
    sd: float
    of: str
    source: str = ""
    assumed: Literal["", "sd", "value"] = ""
    speed: Measured | None = None
    course: Measured | None = None


@dataclass(frozen=True, slots=True)
class EndOfRotation:
    """Where a vehicle stopped sliding sideways and began to roll (m, rad); None is not measured.

    x and y are of its centre of gravity. Whole turns of `heading` mean nothing.
    """

    x: Measured | None = None
    y: Measured | None = None
    heading: Measured | None = None


@dataclass(frozen=True, slots=True)
class Contact:
    """Impact centre in the road plane (m) and Gamma (rad), the contact line's angle from the y axis.

    `interlocked` says that parts of the vehicles hooked into each other, so that sliding may have been
    reversed.
    """

    x: Measured
    y: Measured
    Gamma: Measured
    interlocked: bool = False


@dataclass(frozen=True, slots=True)
class Edge:
    """A straight edge (m, rad) beyond which a surface lies.

    The surface lies to the `side` of someone who stands at (x, y) and looks along `direction`.
    `offset` shifts the edge towards the surface; its sd is the edge's uncertainty.
    """

    x: float
    y: float
    direction: float
    side: Literal["left", "right"]
    offset: Measured


@dataclass(frozen=True, slots=True)
class Outline:
    """The corners (m) of a surface in the order in which straight sides join them, either way round.

    `offset` shifts the whole outline inwards; its sd is the outline's uncertainty.
    """

    corners: tuple[tuple[float, float], ...]
    offset: Measured


@dataclass(frozen=True, slots=True)
class Surface:
    """A surface: sliding friction f at low speed, f exp(-speed_dependence v) at speed v (s/m).

    It has an edge, or an outline. The first surface of a scene has neither: it lies everywhere that
    no later one covers.
    """

    name: str
    friction: Measured
    speed_dependence: Measured
    edge: Edge | None
    outline: Outline | None = None


@dataclass(frozen=True, slots=True)
class Slope:
    """How the whole ground rises: places and angles of a scene are counted in its plane.

    Args:
        grade: rise over run.
        uphill: direction in which it rises, counter-clockwise from the x axis, rad.
    """

    grade: Measured
    uphill: Measured


@dataclass(frozen=True, slots=True)
class Barrier:
    """What vehicle A struck in the place of a vehicle B: rigid, and immovable.

    Args:
        kind: "wall", whose face is the contact line, or "pole", which touches that from beyond.
        name: in words.
        diameter: of a pole, m; it is for drawing.
    """

    kind: Literal["wall", "pole"]
    name: str
    diameter: float = 0.0


@dataclass(frozen=True)
class Scene:
    """A whole measured scene: what a model needs and a report prints.

    Args:
        title: one line.
        name: short identifier, used to name output.
        text: the scene file as it was written, for the record.
        vehicles: keyed "a" and "b"; "a" alone where it struck a barrier.
        approach: motion before impact, keyed likewise.
        rest: where each vehicle came to rest, keyed likewise; without those that were not measured.
        contact: where and along which line they touched.
        surfaces: road first, then those with edges, then those with outlines.
        notes: remarks of the scene's author, printed in the report.
        question: which of `UNKNOWNS` are asked, in their order.
        priors: of the unknowns, by name; see `default_priors`.
        departure: motion after impact, keyed as `rest` is.
        marks: points on each one's way to rest, keyed likewise.
        end_of_rotation: where each stopped sliding sideways, keyed likewise.
        robust: whether errors of the evidence have heavy tails, so that an item which contradicts
            the others gives way.
        approximations: what a model misses of a fuller one, by flat name: inputs that it adds to the
            scene it sees.
        questions: what is asked of the answer.
        barrier: what A struck in the place of a vehicle B; None where that was a vehicle.
        energy_lost: what is stated of the kinetic energy lost in the impact, J, by name in `ENERGY`.
        slope: of the whole ground; None where it is level.
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
    departure: dict[str, Departure] = field(default_factory=dict)
    marks: dict[str, tuple[Mark, ...]] = field(default_factory=dict)
    end_of_rotation: dict[str, EndOfRotation] = field(default_factory=dict)
    robust: bool = False
    approximations: dict[str, Measured] = field(default_factory=dict)
    questions: Questions = field(default_factory=Questions)
    barrier: Barrier | None = None
    energy_lost: dict[str, Measured] = field(default_factory=dict)
    slope: Slope | None = None

    if TYPE_CHECKING:
        # what needs the schema, or matplotlib, knows this module: it attaches itself (`scene.edit`,
        # `notebook`)
        def change(self, changes: Mapping[str, object]) -> Scene:
            """Another scene, in which some keys of the scene file say something else."""

        def to_toml(self) -> str:
            """A scene file that says what the scene holds."""

        def plot(self, units: Units = "si") -> Figure:
            """The scene from above, to scale: what was measured."""

    @property
    def rolling(self) -> tuple[str, ...]:
        """Vehicles of which some wheel was not locked after the impact."""
        return tuple(v for v, vehicle in self.vehicles.items() if vehicle.wheels is not None)

    @property
    def sought(self) -> Literal["speed_a", "speed_b"]:
        """The impact speed that studies follow: of those asked, one that was not measured; B's first."""
        if self.barrier:
            return "speed_a"
        unknown = {v for v in self.vehicles if self.approach[v].speed is None}
        if "speed_a" in self.question and "a" in unknown and "b" not in unknown:
            return "speed_a"
        return "speed_b"

    def inputs(self) -> dict[str, Measured]:
        """Every measured quantity but the rest poses, by its flat name (mass_a, friction_road, …)."""
        flat: dict[str, Measured] = {}
        for v, vehicle in self.vehicles.items():
            for part, names in (
                (vehicle, {}),
                (vehicle.wheels, _WHEEL_NAMES),
                (self.approach[v], _APPROACH_NAMES),
            ):
                for each in fields(part) if part is not None else ():
                    value = getattr(part, each.name)
                    if isinstance(value, Measured):
                        flat[f"{names.get(each.name, each.name)}_{v}"] = value
        flat |= {
            "impact_x": self.contact.x,
            "impact_y": self.contact.y,
            "Gamma": self.contact.Gamma,
        }
        for surface in self.surfaces:
            flat[f"friction_{surface.name}"] = surface.friction
            flat[f"speed_dependence_{surface.name}"] = surface.speed_dependence
            if (end := surface.edge or surface.outline) is not None:
                flat[f"edge_{surface.name}"] = end.offset
        if self.slope is not None:
            flat |= {"grade": self.slope.grade, "uphill": self.slope.uphill}
        return flat | self.approximations

    def evidence(self) -> dict[str, Measured]:
        """What the likelihood compares with, by flat name: rest_x_a, departure_speed_b, mark_1_a, …

        A mark's value is its distance from the path, 0. Errors of what lies on a vehicle's way hold
        its `run_out_error`.
        """
        flat: dict[str, Measured | None] = {}
        for v in self.vehicles:
            if (rest := self.rest.get(v)) is None:
                continue
            way = self.way_to(v, rest.x.value, rest.y.value)
            missed = self.vehicles[v].run_out_error
            flat[f"rest_x_{v}"] = rest.x.with_model_sd(missed.of_position(way))
            flat[f"rest_y_{v}"] = rest.y.with_model_sd(missed.of_position(way))
            if rest.heading is not None:
                flat[f"rest_heading_{v}"] = rest.heading.with_model_sd(missed.of_heading(way))
        for v in self.vehicles:
            departure, missed = self.departure.get(v, {}), self.vehicles[v].run_out_error
            # programs do not depend on the order written
            for name in sorted(departure, key=list(ITEMS).index):
                flat[f"departure_{name}_{v}"] = departure[name]
            for number, mark in enumerate(self.marks.get(v, ()), start=1):
                missed_by = missed.of_position(self.way_to(v, mark.x, mark.y))
                of_mark = Measured(0.0, mark.sd, source=mark.source, assumed=mark.assumed)
                flat[f"mark_{number}_{v}"] = of_mark.with_model_sd(missed_by)
                flat[f"mark_{number}_speed_{v}"] = mark.speed
                flat[f"mark_{number}_course_{v}"] = mark.course
            end = self.end_of_rotation.get(v, EndOfRotation())
            places = [(e.x, e.y) for e in (end, self.rest.get(v)) if e is not None]
            far = next((self.way_to(v, x.value, y.value) for x, y in places if x and y), 0.0)
            for part in ("x", "y", "heading"):
                measured = getattr(end, part)
                if measured is not None:
                    off = missed.of_heading(far) if part == "heading" else missed.of_position(far)
                    measured = measured.with_model_sd(off)
                flat[f"end_{part}_{v}"] = measured
        flat |= {f"impact_{key}": self.energy_lost.get(key) for key in ENERGY}
        return {name: measured for name, measured in flat.items() if measured is not None}

    def way_to(self, v: str, x: float, y: float) -> float:
        """How long a vehicle's way was from the impact to a point of it, m.

        Args:
            v: "a" or "b".
            x: of the point, m.
            y: likewise.

        Returns:
            The length of straight lines from where its centre of gravity was at impact, through the
            marks of that centre up to the point; a way that bends between them was longer.
        """
        passed = [(mark.x, mark.y) for mark in self.marks.get(v, ()) if mark.of == "centre"]
        return discrepancy.way(self.at_impact(v), passed, (x, y))

    def at_impact(self, v: str) -> tuple[float, float]:
        """Where the centre of gravity of vehicle `v` was at impact, m."""
        vehicle = self.vehicles[v]
        angle = vehicle.heading.value + vehicle.impact_angle.value
        lever = vehicle.impact_distance.value
        return (
            self.contact.x.value - lever * math.cos(angle),
            self.contact.y.value - lever * math.sin(angle),
        )

    @property
    def skidded(self) -> tuple[str, ...]:
        """Vehicles of which a skid up to the impact was measured."""
        return tuple(v for v in self.vehicles if self.approach[v].skid is not None)

    def reported(self) -> tuple[str, ...]:
        """Which of `REPORTED` its results contain, where the model knows them."""
        known = self.approach["a"].speed is not None and "speed_a" not in self.question
        left_out = {"speed_a"} if known else set()
        left_out |= {f"travelling_speed_{v}" for v in self.vehicles if v not in self.skidded}
        if self.barrier:
            left_out |= {name for name in REPORTED if vehicle_of(name) == "b"}
        return tuple(name for name in REPORTED if name not in left_out)

    def __repr__(self) -> str:
        counted = f"{len(self.inputs())} inputs, {len(self.evidence())} items of evidence"
        return f"<Scene {self.name!r}: {self.title!r}, {counted}>"


_APPROACH_NAMES = {"yaw_rate": "omega"}
_WHEEL_NAMES = {wheel: f"drag_{wheel}" for wheel in WHEELS} | {"factor": "drag_factor"}
