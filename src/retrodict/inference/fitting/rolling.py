"""A posterior ready to be tempered, of crashes whose vehicles roll above all: no mode is sought.

Coordinates of a vehicle are the standard deviations by which it misses its rest pose, by a
regression fitted to run-outs, as elsewhere. Where the regression does not fit, since the rest pose of a
freely rolling car bends or folds with its velocity, they are offsets from the velocity of the
measured path.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from retrodict.inference.density.compiled import Programs, programs_for
from retrodict.inference.density.kernels import BATCH
from retrodict.inference.fitting import regression
from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.posterior import Posterior, run_outs_of
from retrodict.inference.fitting.steps import in_enough_steps
from retrodict.inference.transforms import rest_pose
from retrodict.inference.transforms.choice import transform_of
from retrodict.inference.transforms.parameters import Guess
from retrodict.models import RUNGS
from retrodict.models.arrays import Data, Structure, steps_of
from retrodict.models.runouts import roll
from retrodict.scene.names import parsed
from retrodict.scene.records import VEHICLES, Scene

# standard deviations of the rest pose: a regression's error that makes good coordinates
_FITS = 0.5
# Of where particles start: coordinates beside inputs, in their own standard deviations. A velocity that
# nothing pins may be off that of a likely crash by so much, m/s and rad/s.
_WIDE, _OPEN = 1.5, np.array([10.0, 10.0, 3.0])
_TURNS = 2.4 * np.pi  # rad: of a rotation to rest whose turns were not counted
_CRASHES = 1024  # of the prior, among which a likely one is sought
_LEAST_OFF = 0.05  # of the logarithm of a speed, and rad


def tempered(scene: Scene, rung: str) -> bool:
    """Whether smc draws from a posterior in this way: if some vehicle rolled to a measured rest.

    Impacts that hold something (no moment, a common velocity) have fewer coordinates than this takes,
    and so have those with a barrier.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`.
    """
    structure = RUNGS[rung].of_scene(scene)[0]
    rested = any(name in structure.evidence for name in structure.rest_components)
    able = (
        bool(structure.rolling)
        and rested
        and not any(level.fixed for level in rest_pose.levels_of(structure))
    )
    return able and not structure.barrier


class Seen(NamedTuple):
    """A scene as it is tempered.

    Args:
        fitted: structure that regressions are fitted by.
        offset: structure that is tempered.
        data: the scene's numbers, with the ways from which velocities may be guessed.
        guess: how far off these may be.
    """

    fitted: Structure
    offset: Structure
    data: Data
    guess: Guess


def seen(scene: Scene, rung: str) -> Seen:
    """A scene under a rung.

    Guessed may be velocities of vehicles whose motion is integrated, if they roll or their turns to rest
    were not counted.
    """
    structure, data = RUNGS[rung].of_scene(scene)
    around = tuple(
        name
        for name in structure.evidence
        if parsed(name).kind == "rest_heading" and not scene.rest[parsed(name).vehicle].turns_known
    )
    ways, taken, off = dict(data.ways), np.zeros(2), np.ones((2, 3))
    for i, v in enumerate(VEHICLES):
        turns_open = f"rest_heading_{v}" in around
        if v not in structure.integrated or not (v in structure.rolling or turns_open):
            continue
        ways[v] = roll.way_of(scene, v)
        if v in scene.rest:
            taken[i] = 1.0
            missed = roll.missed(scene, v, _TURNS if turns_open else 0.0)
            off[i] = np.hypot(missed, [_LEAST_OFF, _LEAST_OFF, 0.0])
    lengths = tuple((v, len(way)) for v, way in ways.items())
    fitted = replace(structure, transform="rest-pose", steps=None, ways=lengths, around=around)
    guess = Guess(taken, off, np.zeros(()))
    return Seen(fitted, replace(fitted, transform="offset"), data._replace(ways=ways), guess)


def prepare(scene: Scene, rung: str) -> Posterior:
    """A scene's posterior under a rung, in coordinates of which zero is likely.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`, for which it is `tempered`.

    Raises:
        Unanswerable: a vehicle that does not roll cannot reach its rest pose.
    """
    fitted, offset, data, guess = seen(scene, rung)

    def attempt(fitted: Structure, data: Data) -> tuple[Posterior, float, int]:
        found = _about(programs_for(fitted), programs_for(offset), data, guess)
        return found, found.unresolved, steps_of(fitted, data)

    return in_enough_steps(fitted, data, attempt)


def _about(fitted: Programs, sampled: Programs, data: Data, guess: Guess) -> Posterior:
    """The posterior, each vehicle by its regression where that fits, and else by the guess."""
    structure = fitted.structure
    regressions, error = rest_pose.example_regressions(structure), np.zeros(2)
    if structure.inverted != VEHICLES:
        likely = likely_separation(
            Crashes(programs_for(structure.without_transform), data, structure.around)
        )
        shot = regression.nearest(fitted, data, likely, every=True)
        for i, v in enumerate(VEHICLES):
            if (
                shot.missed[i] > regression.REACHES
                and v not in structure.inverted
                and not guess.taken[i]
            ):
                raise regression.unreachable(v, shot.missed[i])
        regressions, error, _ = regression.fit(fitted, data, shot.separation)
        turns_open = [f"rest_heading_{v}" in structure.around for v in VEHICLES]
        astray = (shot.missed > regression.REACHES) | shot.folds(regressions) | turns_open
        error = np.where(astray, np.inf, error)
    taken = np.where(error > _FITS, guess.taken, 0.0)
    kind = transform_of(sampled.structure)
    n = kind.length(sampled.structure)
    spun = np.zeros(())
    if rest_pose.spins(structure):
        # where its rest pose does not pin the yaw rate after it, and if that is the sharper of both
        sharper = data.inputs["omega_b"][1] < guess.off[1, 2]
        spun = np.array(float(taken[1] > 0 and sharper))
    transform = kind.example(sampled.structure)._replace(
        regressions=regressions, guess=guess._replace(taken=taken, spun=spun)
    )
    found = Posterior(sampled, data, transform, error, -np.inf, 0.0, _reach(structure, data, n))
    w = np.random.default_rng(0).standard_normal((BATCH, n))
    quantities = found.evaluate(w)[1]
    return replace(found, unresolved=regression.unresolved(fitted, data, run_outs_of(quantities)))


def likely_separation(crashes: Crashes) -> Float[np.ndarray, " separation"]:
    """Velocities after the impact of the crash of the prior that fits the evidence best.

    Zero where nothing counts from them.
    """
    structure = crashes.programs.structure
    if not structure.unmeasured:
        return np.zeros(len(structure.rest_components))
    u = np.random.default_rng(0).standard_normal((_CRASHES, crashes.size))
    residuals, quantities = crashes.residuals(u)
    score = np.nan_to_num(-np.log1p(residuals**2).sum(axis=1), nan=-np.inf)
    return run_outs_of(quantities)[0][np.argmax(score)]


def _reach(structure: Structure, data: Data, n: int) -> Float[np.ndarray, " w"]:
    """How far off particles start."""
    reach = np.ones(n)
    for i, name in enumerate(structure.rest_components):
        reach[i] = _OPEN[i % len(structure.rests)] if name in structure.unmeasured else _WIDE
        if name in structure.around and parsed(name).vehicle in structure.inverted:
            reach[i] = _TURNS / data.evidence[name][1]
    return reach
