"""What is compiled of a scene, its static structure, and the numbers that are passed to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Array, Float

import retrodict._precision  # noqa: F401
from retrodict.mechanics import Zone
from retrodict.mechanics.runout import Steps, fixed_steps
from retrodict.mechanics.surface import Polygon
from retrodict.scene.names import parsed
from retrodict.scene.records import VEHICLES

# measured velocities of B before impact: evidence on the inverse of the impact, not inputs
OF_B = ("direction_b", "omega_b", "speed_b")

TransformName = Literal["rest-pose", "standard"]

STEPS = 48  # of a run-out; `inference` takes as many as the scene needs
ROLLING_STEPS = 192  # of a rolling vehicle's, differentiated in reverse mode: its time is stiff


@dataclass(frozen=True, slots=True)
class Structure:
    """The static part of a scene: one compiled program serves all scenes of one structure.

    Args:
        rung: a name in `retrodict.models.RUNGS`.
        uncertain: measured inputs that carry an uncertainty, with their error laws.
        surfaces: names: the one that lies everywhere, those with edges, those with outlines.
        known_of_b: which of `OF_B` was measured.
        constant_friction: whether no surface's friction depends on speed.
        rolling: vehicles of which some wheel is not locked.
        integrated: vehicles whose motion the rung integrates.
        rests: components of the rest pose that the model predicts.
        evidence: names of the items of evidence that the model predicts.
        marks: name of each item at a mark, and the wheel or centre of gravity that passed there.
        robust: whether errors of the evidence have heavy tails.
        interlocked: whether parts of the vehicles may interlock, so that sliding may be reversed.
        transform: name of the transform that the program is compiled with.
        ways: vehicles that follow their measured way, and its number of points.
        recorded: vehicles of which a recorder kept the speed up to the impact, and its number of points.
        steps: number of integration steps of each run-out; None where it is an argument, for run-outs
            that are not differentiated in reverse mode.
        vehicles: A and B; A alone where it struck a barrier.
        outlines: number of corners of each surface that has some, in the order of `surfaces`.
        deviates: number of standard normal deviates that all unknowns have.
    """

    rung: str
    uncertain: tuple[tuple[str, str], ...]
    surfaces: tuple[str, ...]
    known_of_b: tuple[str, ...]
    constant_friction: bool
    rolling: tuple[str, ...]
    integrated: tuple[str, ...]
    rests: tuple[str, ...]
    evidence: tuple[str, ...]
    marks: tuple[tuple[str, str], ...] = ()
    robust: bool = False
    interlocked: bool = False
    transform: TransformName = "rest-pose"
    ways: tuple[tuple[str, int], ...] = ()
    recorded: tuple[tuple[str, int], ...] = ()
    steps: int | None = None
    vehicles: tuple[str, ...] = VEHICLES
    outlines: tuple[int, ...] = ()
    deviates: int = 0

    @property
    def barrier(self) -> bool:
        """Whether A struck a barrier, which neither moves nor runs out."""
        return "b" not in self.vehicles

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the uncertain inputs, in their order."""
        return tuple(name for name, _ in self.uncertain)

    @property
    def rest_components(self) -> tuple[str, ...]:
        """Measurable components of the rest poses, A's first, by name of evidence."""
        return tuple(f"rest_{part}_{v}" for v in self.vehicles for part in self.rests)

    @property
    def unmeasured(self) -> tuple[str, ...]:
        """Those of `rest_components` that were not measured."""
        return tuple(name for name in self.rest_components if name not in self.evidence)

    @property
    def paced(self) -> bool:
        """Whether the motion of a vehicle that rolls is integrated."""
        return not set(self.rolling).isdisjoint(self.integrated)

    @property
    def inverted(self) -> tuple[str, ...]:
        """Rolling vehicles whose rest pose gives the velocity after the impact in closed form."""
        measured = (v for v in self.rolling if f"rest_x_{v}" in self.evidence)
        return tuple(v for v in measured if v not in self.integrated)

    @property
    def in_deviates(self) -> bool:
        """Whether standard normal deviates are coordinates: slopes are exact, without surrogates."""
        return self.transform == "standard"

    @property
    def without_transform(self) -> Structure:
        """The structure by which programs that need no transform are compiled, whatever its own."""
        return replace(self, transform="rest-pose")

    @property
    def differentiable(self) -> Structure:
        """The structure with a fixed number of steps, which have derivatives in reverse mode."""
        return replace(self, steps=self.steps or (ROLLING_STEPS if self.paced else STEPS))

    def on_way_of(self, vehicle: str) -> tuple[str, ...]:
        """Names of what was measured on a vehicle's way to rest."""
        own = (name for name in self.evidence if parsed(name).vehicle == vehicle)
        return tuple(name for name in own if parsed(name).on_way)

    @property
    def followed(self) -> bool:
        """Whether something was measured on the way to rest."""
        return any(self.on_way_of(v) for v in self.vehicles)

    @property
    def rested(self) -> bool:
        """Whether any component of a rest pose was measured."""
        return any(parsed(name).at_rest for name in self.evidence)


class Data(NamedTuple):
    """The numbers of a scene, as arguments of the compiled programs.

    NumPy arrays, because JAX would compile a small program for each operation that makes them.

    Args:
        inputs: (location, scale) of every measured input: of the quantity itself, or of its
            logarithm where the law is lognormal and the input uncertain.
        evidence: (value, sd) of every item of evidence.
        marks: x and y of the mark of every item there, m.
        priors: numbers of each prior, as `Scene.priors` has them.
        edges: of the surfaces: a point (m) and the unit normal into the zone.
        outlines: of the surfaces that have some: their corners, m.
        steps: of each run-out's integration, where the structure does not say.
        ways: x, y (m) and heading (rad) of each point of a measured way, by vehicle.
        records: time (s) and speed (m/s) of each point of a recorder's record, by vehicle.
    """

    inputs: dict[str, Float[Array | np.ndarray, "2"]]
    evidence: dict[str, Float[Array | np.ndarray, "2"]]
    marks: dict[str, Float[Array | np.ndarray, "2"]]
    priors: dict[str, Float[Array | np.ndarray, " numbers"]]
    edges: Zone
    outlines: tuple[Polygon, ...]
    steps: Steps
    ways: dict[str, Float[Array | np.ndarray, "points 3"]]
    records: dict[str, Float[Array | np.ndarray, "points 2"]]


def steps_of(structure: Structure, data: Data) -> int:
    """Number of integration steps of each run-out."""
    return structure.steps or int(data.steps.number)


def in_steps(structure: Structure, data: Data, count: int) -> tuple[Structure, Data]:
    """The same with `count` integration steps of each run-out."""
    if structure.steps:
        return replace(structure, steps=count), data
    return structure, data._replace(steps=fixed_steps(count))
