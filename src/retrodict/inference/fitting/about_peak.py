"""The posterior of a scene and a model, in coordinates about each peak that may count.

Standard normal deviates (`transforms.standard`) cover all that the model allows. Several peaks share the
posterior, each a part of its own. Where rest poses pin the motion, they are coordinates too
(`transforms.rest_pose`): there the posterior is flattest, which chains need. They cut the support where
a divisor of e_m or of the share of the sliding changes sign, and are unsuitable where the posterior
extends across such a change.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby
from typing import NamedTuple

import numpy as np

from retrodict.inference.density.compiled import Programs, programs_for
from retrodict.inference.density.kernels import BATCH, CHUNK, SIMULATE
from retrodict.inference.errors import Unanswerable
from retrodict.inference.fitting import regression, whitening
from retrodict.inference.fitting.basins import Basin, Basins
from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.flattening import flattened, straight
from retrodict.inference.fitting.optimise import spread
from retrodict.inference.fitting.posterior import Posterior, run_outs_of
from retrodict.inference.fitting.search import SUFFICIENT, Counted, Peak, counted, peaks
from retrodict.inference.fitting.steps import in_enough_steps
from retrodict.inference.transforms import layout
from retrodict.inference.transforms.choice import Coordinates
from retrodict.inference.transforms.parameters import Regressions
from retrodict.inference.transforms.rest_pose import example_regressions
from retrodict.inference.transforms.standard import Deviates
from retrodict.models import RUNGS
from retrodict.models.arrays import Data, Structure, in_steps, steps_of
from retrodict.models.impact import E_M, SLIDING
from retrodict.models.standard_normal import sizes
from retrodict.scene.names import parsed
from retrodict.scene.records import VEHICLES, Scene

# most whitenings about a mode, and the move of the mode (norm of w) at which they end
_WHITENINGS, _STILL = 12, 0.05
# Least curvature that whitening uses, with response surfaces and without. Inputs have a prior of
# curvature 1, and a direction that is much wider than that is a ridge that bends away.
_RIDGE, _FLAT = 0.3, 1e-2
_RUN_OUTS, _WIDE = 2048, 1.2  # run-outs that response surfaces are fitted to, and their spread in w
# Number of crashes about a peak by which a divisor's sign is judged, and the distance of its mean from
# zero, in standard deviations, above which the other sign is negligible: 2 in 10 000 of a normal.
_ABOUT, _CLEAR = 256, 3.5
_RESOLVING = 64  # crashes by which integration steps are judged


@dataclass(frozen=True)
class Prepared:
    """A posterior in coordinates about a peak.

    Args:
        posterior: density and coordinates.
        peak: peak that the coordinates are about.
        scene: scene as the model sees it, with whole turns added to the rest headings.
    """

    posterior: Posterior
    peak: Peak
    scene: Scene


def crashes_of(scene: Scene, rung: str) -> Crashes:
    """The crashes that a model allows of a scene, whole turns of unknown rotations not counted.

    Args:
        scene: measured scene.
        rung: name in `retrodict.models.RUNGS`.
    """
    structure, data = RUNGS[rung].of_scene(scene)
    names = (name for name in structure.evidence if parsed(name).kind == "rest_heading")
    modulo = tuple(name for name in names if not scene.rest[parsed(name).vehicle].turns_known)
    return Crashes(programs_for(structure.without_transform), data, modulo)


def turned(scene: Scene, turns: dict[str, int]) -> Scene:
    """The scene with whole turns added to rest headings.

    Args:
        scene: measured scene.
        turns: number of whole turns by vehicle.
    """
    rest = dict(scene.rest)
    for v, count in turns.items():
        heading = rest[v].heading
        assert heading is not None, "only measured headings hide turns"
        heading = replace(heading, value=heading.value + 2 * np.pi * count)
        rest[v] = replace(rest[v], heading=heading)
    return replace(scene, rest=rest)


def prepare(
    scene: Scene,
    rung: str,
    coordinates: Coordinates = Coordinates.PINNED,
    seed: int = 0,
) -> Posterior:
    """The posterior of the likeliest part of `prepared`.

    Args:
        scene: measured scene.
        rung: name in `retrodict.models.RUNGS`.
        coordinates: preferred coordinates; deviates where `PINNED` ones do not cover the posterior.
        seed: integer seed of the search.

    Raises:
        Unanswerable: in the same cases as `prepared`.
    """
    crashes = crashes_of(scene, rung)
    return prepared(crashes, scene, peaks(crashes, seed), coordinates, seed)[0].posterior


def prepared(
    crashes: Crashes, scene: Scene, sought: list[Peak], coordinates: Coordinates, seed: int
) -> list[Prepared]:
    """A scene's posterior under a model: the parts that make it up, the likeliest first.

    Args:
        crashes: crashes that the model allows of the scene.
        scene: measured scene.
        sought: peaks of the posterior.
        coordinates: preferred coordinates; deviates where `PINNED` ones do not cover the posterior.
        seed: integer seed of the crashes that coordinates are fitted to.

    Raises:
        Unanswerable: no run-out reaches a measured rest pose.
    """
    rung = crashes.programs.structure.rung
    found: list[Prepared] = []
    refusals: list[Unanswerable] = []
    for some in _by_turns(sought):
        at = turned(scene, some[0].turns)
        structure, data = RUNGS[rung].of_scene(at)
        try:
            found += _of_turns(crashes, structure, data, at, some, coordinates, seed)
        except Unanswerable as refusal:
            refusals.append(refusal)
    if not found:
        raise refusals[0]
    return sorted(found, key=lambda each: -each.peak.log_evidence)


def plainest(
    crashes: Crashes, scene: Scene, sought: list[Peak], coordinates: Coordinates, seed: int
) -> Coordinates:
    """The coordinates that `prepared` will use: deviates where rest poses cover none of the posterior.

    Arguments as of `prepared`.
    """
    if coordinates is not Coordinates.PINNED:
        return coordinates
    structure, _ = RUNGS[crashes.programs.structure.rung].of_scene(scene)
    pinned = structure.transform == "rest-pose" and any(
        _rest_poses_cover(crashes, some, seed) for some in _by_turns(sought)
    )
    return coordinates if pinned else Coordinates.DEVIATES


def _by_turns(sought: list[Peak]) -> list[list[Peak]]:
    """Peaks in groups of the same numbers of turns."""

    def order(peak: Peak) -> Counted:
        return counted(peak.turns)

    return [list(own) for _, own in groupby(sorted(sought, key=order), order)]


def _rest_poses_cover(crashes: Crashes, some: list[Peak], seed: int) -> bool:
    """Whether rest poses, one branch for each peak, cover the posterior of one number of turns."""
    sides = [_sides(crashes, peak, seed) for peak in some]
    apart = len({tuple(own.items()) for own, _ in sides}) == len(some)
    return apart and all(clear for _, clear in sides)


def _of_turns(
    crashes: Crashes,
    structure: Structure,
    data: Data,
    scene: Scene,
    some: list[Peak],
    coordinates: Coordinates,
    seed: int,
) -> list[Prepared]:
    """The parts of one number of turns, whose peaks are given, the likeliest first."""
    scene = RUNGS[structure.rung].with_approximations(scene)
    if structure.transform == "rest-pose":
        if coordinates is Coordinates.SOLVED_BACK:
            return [Prepared(_by_rest_pose(structure, data, some[0]), some[0], scene)]
        if coordinates is Coordinates.PINNED and _rest_poses_cover(crashes, some, seed):
            return [Prepared(_by_rest_pose(structure, data, peak), peak, scene) for peak in some]
    structure = replace(structure, transform="standard")
    bent = coordinates is not Coordinates.UNBENT
    parts = [_by_deviates(structure, data, peak, seed, bent=bent) for peak in some]
    if len(parts) > 1:
        basins = tuple(
            Basin(peak, part.in_deviates.flattening) for peak, part in zip(some, parts, strict=True)
        )
        parts = [replace(part, basins=Basins(basins, i)) for i, part in enumerate(parts)]
    return [Prepared(part, peak, scene) for part, peak in zip(parts, some, strict=True)]


def divisor_signs(peak: Peak) -> dict[str, float]:
    """Signs of the denominators of e_m and of the share of the sliding at a peak, by level name."""
    at = {level.name: peak.quantities.get(f"divisor/{level.name}") for level in (E_M, SLIDING)}
    return {name: float(np.sign(divisor)) for name, divisor in at.items() if divisor is not None}


def _sides(crashes: Crashes, peak: Peak, seed: int) -> tuple[dict[str, float], bool]:
    """`divisor_signs`, and whether the divisors are clear of zero in the posterior about the peak."""
    signs = divisor_signs(peak)
    if not signs:
        return signs, True
    z = np.random.default_rng([seed, 8]).standard_normal((_ABOUT, peak.u.size))
    root = np.linalg.inv(np.linalg.cholesky(peak.precision))
    quantities = crashes.at(peak.u + z @ root)[1]
    clear = True
    for name, sign in signs.items():
        divisor = sign * quantities[f"divisor/{name}"]
        divisor = divisor[np.isfinite(divisor)]
        clear &= bool(divisor.size and divisor.mean() > _CLEAR * divisor.std())
    return signs, clear


def unresolved(posterior: Posterior) -> float:
    """Change of the predictions of likely crashes by finer steps, in standard deviations."""
    programs, data, s = posterior.programs, posterior.data, posterior.programs.structure
    if not (s.integrated and (s.followed or s.rested)):
        return 0.0
    w = np.random.default_rng(0).standard_normal((BATCH, posterior.size))
    finer, finely = in_steps(s, data, 4 * steps_of(s, data))
    if s.in_deviates:
        u = posterior.deviates(w[:_RESOLVING])
        likely = posterior.crashes.at(u)[1]
        again = Crashes(programs_for(finer.without_transform), finely).at(u)[1]
    else:
        quantities = posterior.evaluate(w)[1]
        if not s.followed:
            return regression.unresolved(programs, data, run_outs_of(quantities))
        likely = {k: np.asarray(v)[:CHUNK] for k, v in quantities.items()}
        unknowns = {k: likely[k] for k in sizes(programs.target.rung.impact, s, data)}
        found = programs_for(finer)(SIMULATE, finely, unknowns)
        again = {k: np.asarray(v) for k, v in found.items()}
    moved = [
        (again[f"predicted/{k}"] - likely[f"predicted/{k}"]) / data.evidence[k][1]
        for k in s.evidence
        if parsed(k).at_rest or parsed(k).on_way
    ]
    return float(np.nanquantile(np.abs(moved), 0.9))  # some of them lie beyond the bounds


def _by_deviates(
    structure: Structure, data: Data, peak: Peak, seed: int, *, bent: bool
) -> Posterior:
    """The posterior in standard normal deviates about a peak, with enough integration steps."""

    def attempt(structure: Structure, data: Data) -> tuple[Posterior, float, int]:
        crashes = Crashes(programs_for(structure.without_transform), data).in_steps(SUFFICIENT)
        flattening = flattened(crashes, peak, seed) if bent else straight(crashes, peak)
        programs, transform = programs_for(structure), Deviates.unwhitened(flattening)
        found = Posterior(programs, data, transform, np.zeros(2), peak.log_evidence, 0.0, peak=peak)
        found = replace(found, unresolved=unresolved(found))
        return found, found.unresolved, steps_of(structure, data)

    return in_enough_steps(structure, data, attempt)


class _Fitted(NamedTuple):
    """Regressions of a scene, with the integration steps of these programs and data."""

    programs: Programs
    data: Data
    regressions: Regressions
    error: np.ndarray
    unresolved: float


def _by_rest_pose(structure: Structure, data: Data, peak: Peak) -> Posterior:
    """The posterior in rest-pose coordinates about a peak, with enough integration steps."""
    likely = run_outs_of({k: np.asarray(v)[None] for k, v in peak.quantities.items()})[0][0]

    def fitted(structure: Structure, data: Data) -> tuple[_Fitted, float, int]:
        programs, steps = programs_for(structure), steps_of(structure, data)
        if structure.inverted == VEHICLES:
            nothing = example_regressions(structure)
            return _Fitted(programs, data, nothing, np.zeros(2), 0.0), 0.0, steps
        separation = regression.shoot(programs, data, likely)
        regressions, error, run_outs = regression.fit(programs, data, separation)
        unresolved = regression.unresolved(programs, data, run_outs)
        return _Fitted(programs, data, regressions, error, unresolved), unresolved, steps

    def attempt(structure: Structure, data: Data) -> tuple[Posterior, float, int]:
        found = in_enough_steps(structure, data, fitted)
        q = _coordinates(found, peak)
        transform = whitening.whitened_about(
            found.programs, found.data, found.regressions, q, np.eye(q.size)
        )
        start = Posterior(
            found.programs, found.data, transform, found.error, -np.inf, found.unresolved
        )
        posterior = _about_mode(start)
        # regressions were judged by rest poses alone
        worst = unresolved(posterior) if structure.followed else 0.0
        posterior = replace(posterior, unresolved=max(posterior.unresolved, worst))
        return posterior, posterior.unresolved, steps_of(found.programs.structure, found.data)

    return in_enough_steps(structure, data, attempt)


def _coordinates(fitted: _Fitted, peak: Peak) -> np.ndarray:
    """Approximate rest-pose coordinates of a peak, shape (q,)."""
    structure, data = fitted.programs.structure, fitted.data
    z = []
    for name in structure.rest_components:
        value, sd = data.evidence.get(name, (0.0, np.inf))
        z.append((float(peak.quantities.get(f"predicted/{name}", 0.0)) - value) / sd)
    deviates = np.asarray(peak.quantities.get("measured", np.zeros(0)))
    sampled = np.zeros(int(layout.samples_sliding(structure)))
    q = np.concatenate([z, deviates, sampled])
    return whitening.sliding(fitted.programs, data, fitted.regressions, q)


def _about_mode(posterior: Posterior) -> Posterior:
    """The posterior in coordinates about the mode near their centre.

    Raises:
        Unanswerable: there is none.
    """
    programs, data = posterior.programs, posterior.data
    responding = bool(layout.with_response_surface(programs.structure))
    # constraints and whitening depend on the mode, and it on them: 3 rounds suffice without responses
    for _ in range(_WHITENINGS if responding else 3):
        posterior = _with_responses(posterior)
        transform = posterior.in_rest_poses
        mode, value = posterior.potential.minimise(np.zeros(posterior.size))
        if not np.isfinite(value):
            raise _no_mode("density")
        centre, per_w = (
            np.asarray(transform.whitening.centre),
            np.asarray(transform.whitening.spread),
        )
        constrained, centre = posterior.constrained(mode), centre + per_w @ mode
        axes = per_w @ spread(posterior.potential.curvature(mode), _RIDGE if responding else _FLAT)
        if not (np.isfinite(axes).all() and np.isfinite(constrained).all()):
            raise _no_mode("curvature")
        side, kept = np.asarray(transform.constraints.side), float(transform.constraints.kept)
        if layout.samples_sliding(programs.structure):
            kept, (centre, constrained, axes) = whitening.softened(
                transform, centre, constrained, axes
            )
        about = whitening.whitened_about(
            programs, data, transform.regressions, centre, axes, constrained, side, kept
        )
        posterior = replace(posterior, transform=about, log_evidence=-value)
        if np.linalg.norm(mode) < _STILL:
            break
    return _with_responses(posterior)


def _no_mode(lacks: str) -> Unanswerable:
    """The error that no mode was found."""
    return Unanswerable(
        f"the posterior has no finite {lacks} near the measured scene; check headings and the contact "
        "line, and that the vehicles came together at all"
    )


def _with_responses(posterior: Posterior) -> Posterior:
    """The same posterior, with response surfaces fitted about its centre."""
    if not layout.with_response_surface(posterior.programs.structure):
        return posterior
    rng = np.random.default_rng(0)
    return posterior.with_responses(_WIDE * rng.standard_normal((_RUN_OUTS, posterior.size)))
