"""What is compiled of a scene, its static structure, and the numbers that are passed to it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Array, Float

import retrodict._precision  # noqa: F401
from retrodict.mechanics import Zone
from retrodict.mechanics.integration import Steps, fixed_steps
from retrodict.mechanics.surface import Polygon
from retrodict.scene.names import parsed
from retrodict.scene.records import VEHICLES

# measured velocities of B before impact: evidence on the inverse of the impact, not inputs
OF_B = ("direction_b", "omega_b", "speed_b")

# recorded quantities by name -> log likelihood
OwnTerm = Callable[[Mapping[str, Array]], Any]
TransformName = Literal["rest-pose", "standard"]

STEPS = 48  # steps of a run-out; `inference` takes as many as the scene needs
ROLLING_STEPS = 192  # steps of a rolling vehicle's run-out in reverse mode: it is stiff


@dataclass(frozen=True, slots=True)
class Structure:
    """The static part of a scene: one compiled program serves all scenes of one structure.

    Args:
        rung: a name in `retrodict.models.RUNGS`.
        uncertain: measured inputs that carry an uncertainty, with their error laws.
        surfaces: names of the surfaces: the one that lies everywhere, those with edges, those with
            outlines.
        known_of_b: measured velocities of B before the impact, a subset of `OF_B`.
        constant_friction: whether no surface's friction depends on speed.
        rolling: vehicles of which some wheel is not locked.
        integrated: vehicles whose motion the rung integrates.
        rests: components of the rest pose that the model predicts.
        evidence: names of the items of evidence that the model predicts.
        marks: name of each item at a mark, and the wheel or centre of gravity that passed there.
        robust: whether errors of the evidence have heavy tails.
        interlocked: whether parts of the vehicles may interlock, so that sliding may be reversed.
        transform: name of the transform that the program is compiled with.
        ways: vehicles that follow their measured path, and the number of points of each path.
        recorded: vehicles with recorded speeds up to the impact, and the number of points of each.
        steps: number of integration steps of each run-out; None where the number is an argument, for
            run-outs that are not differentiated in reverse mode.
        vehicles: A and B; A alone where it struck a barrier.
        outlines: number of corners of each surface with an outline, in the order of `surfaces`.
        deviates: number of standard normal deviates of all unknowns together.
        families: unknowns whose prior is the user's own, and its family; of a distribution given in
            Python its structure as a tree of JAX.
        skids: vehicles with a skid in several pieces, and the surface of each piece, empty where a drag
            factor is given.
        yaw_marks: vehicles with a yaw mark, and its surface.
        own: terms of the log likelihood that are the user's own, by name.
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
    families: tuple[tuple[str, Hashable], ...] = ()
    skids: tuple[tuple[str, tuple[str, ...]], ...] = ()
    yaw_marks: tuple[tuple[str, str], ...] = ()
    own: tuple[tuple[str, OwnTerm], ...] = ()

    def family(self, name: str) -> Hashable:
        """Family of the prior that the user gives of an unknown; None where it is the default's."""
        return dict(self.families).get(name)

    @property
    def of_python(self) -> bool:
        """Whether a part of the model is the user's own code, which no digest of ours tells apart."""
        return bool(self.own) or any(not isinstance(own, str) for _, own in self.families)

    @property
    def single(self) -> bool:
        """Whether A is the only vehicle: a barrier neither moves nor runs out."""
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
        """Components of the rest poses that were not measured, named as in `rest_components`."""
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
        """The structure by which programs that need no transform are compiled."""
        return replace(self, transform="rest-pose")

    @property
    def differentiable(self) -> Structure:
        """The structure with a fixed number of steps: its run-outs have derivatives in reverse mode."""
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
        inputs: (location, scale) of every measured input: of the quantity itself, or of its logarithm
            or logit where an uncertain input has a lognormal or logitnormal law.
        evidence: (value, sd) of every item of evidence.
        marks: x and y of the mark that each item at a mark belongs to, m.
        priors: numbers of each prior, as `Scene.priors` has them, or the distribution given in Python.
        edges: half-plane of each surface with an edge: a point of the edge (m) and the inward normal.
        outlines: corners of each surface with an outline, m.
        steps: integration steps of each run-out, where the structure does not set their number.
        ways: x, y (m) and heading (rad, NaN where unknown) of each point of a measured path, by vehicle.
        records: time (s) and speed (m/s) of each point of a recorder's record, by vehicle.
    """

    inputs: dict[str, Float[Array | np.ndarray, "2"]]
    evidence: dict[str, Float[Array | np.ndarray, "2"]]
    marks: dict[str, Float[Array | np.ndarray, "2"]]
    priors: dict[str, Any]
    edges: Zone
    outlines: tuple[Polygon, ...]
    steps: Steps
    ways: dict[str, Float[Array | np.ndarray, "points 3"]]
    records: dict[str, Float[Array | np.ndarray, "points 2"]]


def steps_of(structure: Structure, data: Data) -> int:
    """Number of integration steps of each run-out."""
    return structure.steps or int(data.steps.number)


def in_steps(structure: Structure, data: Data, count: int) -> tuple[Structure, Data]:
    """The structure and data with `count` integration steps of each run-out."""
    if structure.steps:
        return replace(structure, steps=count), data
    return structure, data._replace(steps=fixed_steps(count))
