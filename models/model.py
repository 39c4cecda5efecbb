"""A model is an impact and a run-out; `RUNGS` has all, from the simplest to the most detailed.

A new impact or run-out is one file and one name in `_IMPACTS` or `_RUN_OUTS`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
from retrodict.models import evidence, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description
from retrodict.models.impact import Impact
from retrodict.models.impacts import alone, joined, momentum, planar
from retrodict.models.of_scene import of_scene
from retrodict.models.run_out import RunOut
from retrodict.models.runouts import joined as joined_run_outs
from retrodict.models.runouts import roll, slide, spin, wheels
from retrodict.models.standard_normal import sample_unknowns, sizes

from retrodict.scene.fields import COEFFICIENTS
from retrodict.scene.names import parsed, vehicle_of
from retrodict.scene.quantities import describe
from retrodict.scene.records import Scene


@dataclass(frozen=True)
class Rung:
    """A model: an impact, then the run-out of each vehicle."""

    impact: Impact
    run_out: RunOut

    @property
    def name(self) -> str:
        """Key of the rung in `RUNGS`."""
        return f"{self.impact.description.name}+{self.run_out.description.name}"

    @property
    def answers(self) -> tuple[str, ...]:
        """Names of the reported quantities that the rung infers."""
        return self.impact.answers

    def nests(self, other: Rung) -> bool:
        """Whether another model is nested in this one, which models all that the other does and more."""
        if self.impact.kind != other.impact.kind:
            return False
        mine = (self.impact.nesting, self.run_out.nesting)
        theirs = (other.impact.nesting, other.run_out.nesting)
        return mine != theirs and all(a >= b for a, b in zip(mine, theirs, strict=True))

    def refusal(self, scene: Scene) -> str:
        """Reason why the rung does not apply to a scene; empty where it does."""
        return self.lacks(scene) or self.run_out.refusal(scene)

    def lacks(self, scene: Scene) -> str:
        """What the rung cannot do without and a scene does not have; empty where it has all."""
        if scene.kind != self.impact.kind and "alone" in (scene.kind, self.impact.kind):
            return _ALONE if scene.alone else _STRUCK
        if scene.barrier and self.impact.against_barrier is None:
            return _NO_MOMENTUM
        needed = (*self.impact.needs, *self.run_out.needs)
        missing = scene.missing(needed)
        return f"needs {' and '.join(missing)}, which the scene does not have" if missing else ""

    def description(self, scene: Scene) -> Description:
        """The model in words, with the priors of a scene."""
        one, two = self.impact.description, self.run_out.description
        if scene.barrier:
            one = self.impact.against_barrier or one
        known = scene.inputs()
        priors = [
            (describe(name)[0], p.text, f"{p.reason} ({p.source})")
            for name in self.impact.priors
            if name not in known and not (scene.single and vehicle_of(name) == "b")
            for p in [scene.priors[name]]
        ]
        priors += [
            (describe(f"direction_{v}")[0], "uniform over the circle", "it may have slid any way")
            for v in scene.vehicles
            if f"direction_{v}" not in known
        ]
        return Description(
            name=self.name,
            title=f"{one.title[0].upper()}{one.title[1:]}, then {two.title}",
            equations=one.equations + two.equations,
            assumptions=(*one.assumptions, *two.assumptions, *_assumed(scene)),
            left_out=one.left_out + two.left_out,
            priors=tuple(priors),
            ignores=(*_ignored(scene, self.run_out.seen(scene)), *self._unused(scene)),
        )

    def _unused(self, scene: Scene) -> Iterator[str]:
        """Sentences on priors of the user's own for coefficients that the impact does not have."""
        for name in COEFFICIENTS:
            if scene.priors[name].overridden and name not in self.impact.priors:
                yield f"The model does not use the prior that is given of the {describe(name)[0]}."

    def of_scene(self, scene: Scene) -> tuple[Structure, Data]:
        """Structure and data of a scene for this model: what is compiled, and its arguments."""
        seen = self.with_approximations(self.run_out.seen(scene))
        ways = self.run_out.ways(seen)

        def explained(name: str) -> bool:
            defines_way = parsed(name).on_way and parsed(name).vehicle in ways
            return self.explains(name) and not defines_way

        # along a measured way yaw rates are so uncertain that the bounds on e_m distort the rest-pose
        # transform strongly: importance sampling had no finite weight in two scenes of five
        loose = bool(ways and self.impact.levels) or self.impact.unknowns is None
        structure, data = of_scene(seen, self.name, self.run_out, explained, loose)
        deviates = sum(sizes(self.impact, structure, data).values())
        return replace(structure, deviates=deviates), data

    def with_approximations(self, scene: Scene) -> Scene:
        """The scene with the approximation errors of this model added to its inputs."""
        return replace(scene, approximations=self.run_out.approximations(scene))

    def explains(self, name: str) -> bool:
        """Whether the model predicts an item of evidence, named as in `Scene.evidence`."""
        turns = "heading" in self.run_out.rests
        return name in self.impact.evidence or evidence.explained(name, turns)

    def model(
        self,
        structure: Structure,
        data: Data,
        surrogate: evidence.Surrogate | None = None,
    ) -> None:
        """The forward model: measured inputs, impact, run-outs, evidence.

        Args:
            structure: static structure of the scene: uncertain inputs, surfaces, items of evidence.
            data: measured values and priors.
            surrogate: surrogate of the run-out predictions and their derivatives, which returns the
                exact value of an item that it does not cover; None to differentiate the run-outs.
        """
        x, data, after = sample_unknowns(self.impact, structure, data)
        rests = jnp.full((len(structure.vehicles), len(structure.rests)), jnp.nan)
        paths = None
        at = (x, after)
        if surrogate and not structure.steps:
            at = jax.lax.stop_gradient(at)
        if structure.followed:
            paths = self.run_out.paths(structure, data, *at)
            rests = paths.pose[:, -1, : len(structure.rests)]
        elif structure.rested:
            rests = self.run_out.rest_poses(structure, data, *at)
        evidence.observe(structure, data, x, after, rests, paths, surrogate)
        parts.record_skids(structure, x, after, self.impact.kind == "alone")


def _assumed(scene: Scene) -> Iterator[str]:
    """Assumptions that only some scenes need."""
    for v, vehicle in scene.vehicles.items():
        if vehicle.articulated:
            yield (
                f"{v.upper()} is a tractor with a trailer whose articulation is locked: one rigid body "
                "on four wheels, which stand for those of all axles"
            )
        if scene.approach[v].yaw_mark is not None:
            yield (
                f"{v.upper()} left its yaw mark at the critical speed √(f g r), and slowed down only "
                "after it; the stated error is that of this method"
            )


def _ignored(scene: Scene, seen: Scene) -> Iterator[str]:
    """Sentences on what a run-out leaves out of a scene."""
    kept = {surface.name for surface in seen.surfaces}
    if ignored := [surface.name for surface in scene.surfaces if surface.name not in kept]:
        yield (
            f"The model takes the friction of the {scene.surfaces[0].name} everywhere: it leaves out "
            f"the {' and the '.join(ignored)}."
        )
    if scene.slope is not None and seen.slope is None:
        yield "The model takes the ground as level: it leaves out the slope."


_ALONE = "is of an impact, and the vehicle struck nothing"
_STRUCK = "is of a vehicle that struck nothing"
_NO_MOMENTUM = "uses conservation of momentum only, which a fixed barrier does not obey"
_IMPACTS = (momentum.IMPACT, *planar.IMPACTS)
_RUN_OUTS = (slide.RUN_OUT, spin.RUN_OUT, roll.RUN_OUT, wheels.RUN_OUT)

# a straight slide has no yaw rates, without which the moments of an impact cannot be determined
_PARTING = [
    Rung(impact, run_out)
    for impact in _IMPACTS
    for run_out in _RUN_OUTS
    if run_out is not slide.RUN_OUT or impact is momentum.IMPACT
]
_JOINED = [
    Rung(joined.AS_POINTS, joined_run_outs.AS_POINTS), Rung(joined.AS_BODY, joined_run_outs.AS_BODY)
]  # fmt: skip
_ALONE_RUNGS = [
    Rung(alone.IMPACT, run_out) for run_out in (slide.RUN_OUT, spin.RUN_OUT, wheels.RUN_OUT)
]
RUNGS: dict[str, Rung] = {rung.name: rung for rung in (*_PARTING, *_JOINED, *_ALONE_RUNGS)}


def rungs_for(scene: Scene) -> dict[str, Rung]:
    """The models of what happened in a scene, from the simplest to the most detailed.

    Args:
        scene: measured scene.
    """
    return {
        name: rung
        for kind in scene.kinds
        for name, rung in RUNGS.items()
        if rung.impact.kind == kind
    }
