"""The NumPyro models: rungs from the simplest to the fullest, each an impact and a run-out.

A new impact or run-out is a file and a name below.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
from retrodict.models import (
    evidence,
    momentum,
    parts,
    planar,
    planar_common,
    planar_moment,
    planar_moment_common,
    roll,
    slide,
    spin,
    wheels,
)
from retrodict.models.arrays import Data, Structure, of_scene
from retrodict.models.card import Card
from retrodict.models.impact import Impact
from retrodict.models.run_out import RunOut

from retrodict.scene.quantities import describe
from retrodict.scene.records import Scene


@dataclass(frozen=True)
class Rung:
    """A model: an impact followed by two run-outs."""

    impact: Impact
    run_out: RunOut

    @property
    def name(self) -> str:
        """As in `RUNGS`."""
        return f"{self.impact.card.name}+{self.run_out.card.name}"

    @property
    def answers(self) -> tuple[str, ...]:
        """Which of the quantities asked for it infers."""
        return self.impact.answers

    def above(self, other: Rung) -> bool:
        """Whether it holds all that another does, and more."""
        mine = (self.impact.fullness, self.run_out.fullness)
        theirs = (other.impact.fullness, other.run_out.fullness)
        return mine != theirs and all(a >= b for a, b in zip(mine, theirs, strict=True))

    def card(self, scene: Scene) -> Card:
        """What it is, in words, with the priors of a scene."""
        one, two = self.impact.card, self.run_out.card
        known = scene.inputs()
        priors = [
            (describe(name)[0], p.text, f"{p.reason} ({p.source})")
            for name in self.impact.priors
            if name not in known
            for p in [scene.priors[name]]
        ]
        if "direction_b" not in known:
            priors.append(_NO_DIRECTION)
        return Card(
            name=self.name,
            title=f"{one.title[0].upper()}{one.title[1:]}, then {two.title}",
            equations=one.equations + two.equations,
            assumptions=one.assumptions + two.assumptions,
            left_out=one.left_out + two.left_out,
            priors=tuple(priors),
        )

    def of_scene(self, scene: Scene) -> tuple[Structure, Data]:
        """A scene, as this rung sees it, as a program's structure and its arguments."""
        seen = self.with_approximations(self.run_out.seen(scene))
        ways = self.run_out.ways(seen)

        def explained(name: str) -> bool:
            on_way = name.startswith(("mark_", "end_")) and name[-1] in ways
            return self.explains(name) and not on_way  # what makes a way is not evidence on it too

        # along a way yaw rates err by so much that the bounds of a spin's quotient, e_m, are no
        # small bend of rest poses: importance sampling had no finite weight in two scenes of five
        loose = bool(ways and self.impact.levels)
        return of_scene(seen, self.name, self.run_out, explained, loose)

    def with_approximations(self, scene: Scene) -> Scene:
        """A scene, with what this rung misses of a fuller one among its inputs."""
        return replace(scene, approximations=self.run_out.approximations(scene))

    def explains(self, name: str) -> bool:
        """Whether it predicts an item of evidence, by its flat name."""
        return evidence.explained(name, turns="heading" in self.run_out.rests)

    def model(
        self,
        structure: Structure,
        data: Data,
        surrogate: evidence.Surrogate | None = None,
    ) -> None:
        """The forward story: what was measured, the impact, two run-outs, what was found.

        Args:
            structure: which inputs are uncertain and which surfaces there are.
            data: the scene's numbers.
            surrogate: derivatives of what run-outs end at or pass; None to differentiate run-outs.
        """
        x = parts.measured(structure, data)
        after = self.impact.story(structure, data, x)
        rests, paths = jnp.full((2, len(structure.rests)), jnp.nan), None
        at = (x, after)
        if surrogate and not structure.steps:
            at = jax.lax.stop_gradient(at)
        if structure.followed:
            paths = self.run_out.paths(structure, data, *at)
            rests = paths.pose[:, -1, : len(structure.rests)]
        elif structure.rested:
            rests = self.run_out.rest_poses(structure, data, *at)
        evidence.observe(structure, data, x, after, rests, paths, surrogate)
        parts.tell_skids(structure, x, after)


_NO_DIRECTION = (
    describe("direction_b")[0],
    "uniform over the circle",
    "none is favoured unless measured",
)
_IMPACTS = (momentum, planar_common, planar, planar_moment_common, planar_moment)
_RUN_OUTS = (slide, spin, roll, wheels)

# a straight slide tells nothing of yaw, without which an impact's moments cannot be told
RUNGS: dict[str, Rung] = {
    rung.name: rung
    for impact in _IMPACTS
    for run_out in _RUN_OUTS
    if run_out is not slide or impact is momentum
    for rung in [Rung(impact.IMPACT, run_out.RUN_OUT)]
}
