"""A scene's posterior as a function in good coordinates: density, mode, and the way back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import jax
import numpy as np

from retrodict.inference.density.compiled import Programs, in_chunks, programs_for
from retrodict.inference.density.kernels import (
    BATCH,
    CHUNK,
    EVALUATE,
    EVALUATE_WITH_SLOPES,
    POTENTIAL,
    ROWS,
    SIMULATE,
)
from retrodict.inference.density.log_density import Evaluated
from retrodict.inference.errors import Unanswerable
from retrodict.inference.fitting import regression, whitening
from retrodict.inference.fitting.optimise import Differenced, Differentiated, Potential, spread
from retrodict.inference.fitting.pilot import prior_pilot
from retrodict.inference.fitting.steps import in_enough_steps
from retrodict.inference.transforms import rest_pose, velocity
from retrodict.inference.transforms.choice import transform_of
from retrodict.inference.transforms.parameters import Quadratic, TransformParameters, plain
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure, in_steps, steps_of
from retrodict.models.impact import E_M
from retrodict.scene.names import parsed
from retrodict.scene.records import VEHICLES, Scene

LEAST_WEIGHT = 1e-3  # weight from which on another mode counts
_AS_DRAWS = 10  # what the whitening at the mode counts for beside that by draws
# crashes to start the mode finding from; whitenings; how little a mode moves
_STARTS, _WHITENINGS, _STILL = 3, 12, 0.05
# Least curvature that whitening takes for real. Where rest poses do not pin the motion: inputs have a
# prior of curvature 1, and a direction that is much wider than that is a ridge that bends away.
_RIDGE, FLAT = 0.3, 1e-2
IMPROBABLE = 20.0  # log density by which another mode may be lower and count
_FAR = 1.5  # standard deviations at the mode: what tempering starts from
_RUN_OUTS, _WIDE = 2048, 1.2  # that responses are fitted to, over how much of what is whitened
_SLOW = 5.0  # m/s: speeds of B over which its spike is levelled
_SPEEDS = np.linspace(-2.0, 2.0, 17)  # deviates of A's speed where it is unknown: 1 to 68 m/s


@dataclass(frozen=True)
class Posterior:
    """A posterior ready to be sampled: near w = 0 it is close to a standard normal.

    Args:
        programs: compiled functions, among them the density and its gradient.
        data: the scene's numbers.
        transform: the coordinates, centred and whitened at the mode.
        regression_error: of the fitted regressions for A and B, in standard deviations of the rest pose.
        log_evidence: Laplace's approximation at the mode.
        unresolved: how far the rest poses may be out for want of steps, in standard deviations.
        spread: standard deviations of w from which tempering starts; None for `_FAR` in all.
    """

    programs: Programs
    data: Data
    transform: TransformParameters
    regression_error: np.ndarray
    log_evidence: float
    unresolved: float
    spread: np.ndarray | None = None

    @property
    def reach(self) -> np.ndarray:
        """Standard deviations of w from which tempering starts, about zero."""
        return np.full(self.size, _FAR) if self.spread is None else self.spread

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.transform.spread.shape[1]

    @property
    def branch(self) -> dict[str, float]:
        """The signs of what bounded levels are quotients by, by the level's name.

        Of e_m: 1 where the force alone would turn B to the left of A.
        """
        levels = rest_pose.levels_of(self.programs.structure)
        sides = zip(levels, self.transform.constraints.side, strict=False)
        return {level.name: float(side) for level, side in sides if not level.held}

    @cached_property
    def potential(self) -> Potential:
        """Minus the log density."""
        if not transform_of(self.programs.structure).exact_gradient:
            sloped = self.programs.has(EVALUATE_WITH_SLOPES)
            return Differenced(self._exact, self._alike, self._sloped if sloped else None)

        def at(w: np.ndarray) -> tuple[float, np.ndarray]:
            value, slope = self.programs(POTENTIAL, w, *self._numbers)
            return float(value), np.nan_to_num(slope)

        return Differentiated(at)

    def _exact(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The potential at points, and by what surrogates miss the rest poses there."""
        there = self._located(w)
        return self._sought(there), there.missed

    def _alike(self, w: np.ndarray, missed: np.ndarray) -> np.ndarray:
        """The potential at points if surrogates missed by so much: no run-out is asked."""
        return self._sought(self._located(w, missed))

    def _sloped(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The potential at one point more than there are coordinates at most, and its slopes."""
        there, slopes = self._few(w)
        return -there.log_density, slopes

    def _sought(self, there: Evaluated[np.ndarray]) -> np.ndarray:
        """What a mode is sought by: the potential, but for the spike where B stands.

        A speed with a course as likely any way has a density of one over the speed in the plane of
        velocities, which matters where these are known so little that they may vanish: by ways.
        """
        structure = self.programs.structure
        if structure.barrier or not structure.inverted:
            return -there.log_density
        speed = there.quantities["speed_b"]
        return -there.log_density + np.log(np.hypot(speed, _SLOW) / speed)

    def log_density(self, w: np.ndarray) -> np.ndarray:
        """The log density at many points at once; w has shape (any, q)."""
        return self.evaluate(w)[0]

    @property
    def refits(self) -> bool:
        """Whether draws make its coordinates or its surrogates better."""
        structure = self.programs.structure
        return transform_of(structure).refit_to_draws or bool(
            rest_pose.with_response_surface(structure)
        )

    def refit(self, w: np.ndarray) -> Posterior:
        """The same posterior, whitened by draws or with response surfaces fitted to them.

        Args:
            w: the draws, shape (any, q).
        """
        whitens = transform_of(self.programs.structure).refit_to_draws
        return self.whitened_by(w) if whitens else self.with_responses(w)

    def whitened_by(self, w: np.ndarray) -> Posterior:
        """The same in coordinates whitened by draws of it, where those at the mode may move.

        Args:
            w: the draws, shape (any, q).
        """
        if not transform_of(self.programs.structure).refit_to_draws:
            return self
        spread = np.asarray(self.transform.spread)
        # a little of the spread as it was, lest few draws should make it flat
        covariance = (w.shape[0] * np.cov(w.T) + _AS_DRAWS * np.eye(self.size)) / (
            w.shape[0] + _AS_DRAWS
        )
        centre = np.asarray(self.transform.centre) + spread @ w.mean(axis=0)
        return replace(self, transform=plain(centre, spread @ np.linalg.cholesky(covariance)))

    def with_responses(self, w: np.ndarray) -> Posterior:
        """The same posterior with responses fitted to the run-outs at points; w has shape (any, q)."""
        structure, quantities = self.programs.structure, self.evaluate(w)[1]
        on_way = transform_of(structure).surrogates(structure)[len(structure.rest_components) :]
        predicted = {k: quantities[f"predicted/{k}"] for k in on_way}
        responses = regression.responses(structure, self.data, run_outs_of(quantities), predicted)
        return replace(self, transform=self.transform._replace(responses=responses))

    def converted_to(self, other: Posterior, w: np.ndarray) -> np.ndarray:
        """Points in the coordinates of the same posterior, whitened by draws or as it was before.

        Args:
            other: whose coordinates are asked for.
            w: points in these coordinates, shape (any, q).
        """
        if not transform_of(self.programs.structure).refit_to_draws:
            return w
        q = np.asarray(self.transform.centre) + w @ np.asarray(self.transform.spread).T
        off = q - np.asarray(other.transform.centre)
        return np.linalg.solve(np.asarray(other.transform.spread), off.T).T

    def evaluate(self, w: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """`log_density`; and the model's unknowns and what follows from them, at the same points."""
        there = self._located(w)
        return there.log_density, there.quantities

    def constrained(self, w: np.ndarray) -> np.ndarray:
        """q at w, where constraints have moved it to."""
        return np.asarray(self._located(w[None]).q[0])

    def _located(self, w: np.ndarray, missed: np.ndarray | None = None) -> Evaluated[np.ndarray]:
        """What points are known by; rest poses by their surrogate if `missed` is given."""
        data, transform = self._numbers
        structure = self.programs.structure
        if missed is None:
            if len(w) <= self.size + 1 and self.programs.has(EVALUATE_WITH_SLOPES):
                return self._few(w)[0]
            missed = self._unknown(w)
        elif structure.steps is None:
            data = data._replace(steps=data.steps._replace(number=np.array(0)))
        return in_chunks(
            lambda at: self.programs(EVALUATE, data, transform, *at), (w, missed), ROWS
        )

    def _few(self, w: np.ndarray) -> tuple[Evaluated[np.ndarray], np.ndarray]:
        """What a few points are known by, with the slopes of the potential."""
        return in_chunks(
            lambda at: self.programs(EVALUATE_WITH_SLOPES, *self._numbers, *at),
            (w, self._unknown(w)),
            self.size + 1,
        )

    def _unknown(self, w: np.ndarray) -> np.ndarray:
        """What surrogates miss at points, where run-outs are to say it."""
        structure = self.programs.structure
        return np.full((len(w), len(transform_of(structure).surrogates(structure))), np.nan)

    @cached_property
    def _numbers(self) -> tuple[Data, TransformParameters]:
        """What programs take besides w, handed over to JAX once: it takes as long as a call does."""
        return jax.device_put((self.data, self.transform))


def prepare(scene: Scene, rung: str) -> Posterior:
    """The first of `branches`: all of a posterior that has one, and else the likeliest part.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`.

    Raises:
        Unanswerable: a measured rest pose cannot be reached, or the density has no finite mode.
    """
    return branches(scene, rung)[0]


def branches(scene: Scene, rung: str) -> list[Posterior]:
    """A scene's posterior under a rung, in coordinates made for it: the parts that make it up.

    e_m is the relative spin after the impact over that which the force alone would have made, and lies
    between -1 and 1. The second is therefore larger than the first, and has either sign: two branches,
    which touch only where both vanish. Rest poses as coordinates reach one.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`.

    Returns:
        A posterior for each branch that may count, the likeliest first by Laplace's approximation.

    Raises:
        Unanswerable: a measured rest pose cannot be reached, or the density has no finite mode.
    """
    structure, data = RUNGS[rung].of_scene(scene)
    if not transform_of(structure).by_regressions:
        return [_by_velocity(structure, data)]
    if not structure.followed:
        return _whitened(structure, data)

    def attempt(structure: Structure, data: Data) -> tuple[list[Posterior], float, int]:
        # regressions were judged by rest poses alone
        found = [
            replace(at, unresolved=max(at.unresolved, unresolved(at)))
            for at in _whitened(structure, data)
        ]
        return found, found[0].unresolved, steps_of(found[0].programs.structure, found[0].data)

    return in_enough_steps(structure, data, attempt)


def _by_velocity(structure: Structure, data: Data) -> Posterior:
    """The posterior about its mode in the velocity transform, sought from several crashes."""
    score, quantities = prior_pilot(programs_for(structure), data)
    starts = [
        velocity.coordinates_near(
            structure, data, {name: values[i] for name, values in quantities.items()}
        )
        for i in np.argsort(-score)[:_STARTS]
    ]

    def attempt(structure: Structure, data: Data) -> tuple[Posterior, float, int]:
        programs = programs_for(structure)
        refined = (_refined(programs, data, q) for q in starts)
        posterior = max(refined, key=lambda found: found.log_evidence)
        posterior = replace(posterior, unresolved=unresolved(posterior))
        starts[:] = [np.asarray(posterior.transform.centre)]
        return posterior, posterior.unresolved, steps_of(structure, data)

    return in_enough_steps(structure, data, attempt)


def _refined(programs: Programs, data: Data, q: np.ndarray) -> Posterior:
    """The posterior in coordinates whitened about the mode above q."""
    axes = np.eye(q.size)
    for _ in range(_WHITENINGS):
        at = Posterior(programs, data, plain(q, axes), np.zeros(2), -np.inf, 0.0)
        axes = axes @ spread(at.potential.curvature(np.zeros(q.size)), _RIDGE)
        at = replace(at, transform=plain(q, axes))
        mode, value = _mode(at)
        q = q + axes @ mode
        if not (np.isfinite(axes).all() and np.isfinite(q).all()):
            raise _no_mode("curvature")
        if np.linalg.norm(mode) < _STILL:
            break
    return replace(at, transform=plain(q, axes), log_evidence=-value)


def _no_mode(lacks: str) -> Unanswerable:
    """That a mode was sought and there is none to be found."""
    return Unanswerable(
        f"the posterior has no finite {lacks} near the measured scene; check headings and the contact "
        "line, and that the vehicles came together at all"
    )


def _mode(posterior: Posterior, most: float = np.inf) -> tuple[np.ndarray, float]:
    found = posterior.potential.minimise(np.zeros(posterior.size), most=most)
    if not np.isfinite(found.value):
        raise _no_mode("density")
    return found.w, found.value


def unresolved(posterior: Posterior) -> float:
    """How far finer steps would move what is predicted of likely crashes, in standard deviations."""
    programs, data, s = posterior.programs, posterior.data, posterior.programs.structure

    def likely(count: int) -> dict[str, np.ndarray]:
        w = np.random.default_rng(0).standard_normal((count, posterior.size))
        return posterior.evaluate(w)[1]

    if not s.integrated:
        return 0.0
    if not s.followed:
        return (
            regression.unresolved(programs, data, run_outs_of(likely(BATCH))) if s.rested else 0.0
        )
    quantities = likely(CHUNK)
    finer, finely = in_steps(s, data, 4 * steps_of(s, data))
    nowhere = np.zeros(posterior.size)
    names = jax.eval_shape(
        partial(transform_of(s).forward_and_log_det, s), data, posterior.transform, nowhere
    )[0]
    again = programs_for(finer)(SIMULATE, finely, {k: quantities[k] for k in names})
    moved = [
        (again[f"predicted/{k}"] - quantities[f"predicted/{k}"]) / data.evidence[k][1]
        for k in s.evidence
        if parsed(k).at_rest or parsed(k).on_way
    ]
    return float(np.nanquantile(np.abs(moved), 0.9))  # some of them lie beyond the bounds


def run_outs_of(quantities: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Velocities after the impact, and deviates of the inputs, of crashes; a row for each."""
    V = np.stack(
        [quantities[k] for of_one in parts.AFTER for k in of_one if k in quantities], axis=1
    )
    return V, quantities.get("measured", np.zeros((len(V), 0)))


class _Fitted(NamedTuple):
    """Regressions of a scene, in so many steps as its programs and data have."""

    programs: Programs
    data: Data
    regressions: tuple[Quadratic, Quadratic]
    error: np.ndarray
    unresolved: float


def _fitted(structure: Structure, data: Data) -> tuple[_Fitted, float, int]:
    programs, steps = programs_for(structure), steps_of(structure, data)
    if structure.inverted == VEHICLES:
        nothing = transform_of(structure).example(structure).regressions
        return _Fitted(programs, data, nothing, np.zeros(2), 0.0), 0.0, steps
    separation = regression.shoot(programs, data)
    regressions, error, run_outs = regression.fit(programs, data, separation)
    unresolved = regression.unresolved(programs, data, run_outs)
    return _Fitted(programs, data, regressions, error, unresolved), unresolved, steps


def _whitened(structure: Structure, data: Data) -> list[Posterior]:
    """The posterior on each branch that may count, the likeliest first, in as many steps as it takes."""
    fitted = in_enough_steps(structure, data, _fitted)
    programs, data, regressions = fitted.programs, fitted.data, fitted.regressions
    structure = programs.structure
    n = transform_of(structure).length(structure)
    starts = [whitening.sliding(programs, data, regressions, q) for q in _starts(structure)]
    tried = [whitening.whitened_about(programs, data, regressions, q, np.eye(n)) for q in starts]
    transform = _likeliest(programs, data, tried)
    first = Posterior(programs, data, transform, fitted.error, -np.inf, fitted.unresolved)
    found: list[Posterior] = []
    refusals = []
    for start in _starts_on_branches(first):
        if any(start.branch == other.branch for other in found):
            continue
        # the potential at a mode, whatever the volume that its coordinates count in
        peaks = [float(at.transform.log_volume) - at.log_evidence for at in found]
        try:
            mode = _about_mode(start, min(peaks, default=np.inf) + IMPROBABLE)
        except Unanswerable as refusal:
            refusals.append(refusal)
            continue
        if all(mode.branch != other.branch for other in found):
            found.append(mode)
    if not found:
        raise refusals[0]
    return sorted(found, key=lambda posterior: -posterior.log_evidence)


def _starts_on_branches(posterior: Posterior) -> Iterator[Posterior]:
    """As it is, then about where e_m is within its bounds on the other branch, if it is left open."""
    yield posterior
    programs, data, transform = posterior.programs, posterior.data, posterior.transform
    levels = rest_pose.levels_of(programs.structure)
    if E_M not in levels:
        return
    other = np.where([level == E_M for level in levels], -1, 1) * np.asarray(
        transform.constraints.side
    )
    centre, anyhow = np.asarray(transform.centre), np.eye(transform.centre.size)
    constraints = whitening.whitened_about(
        programs, data, transform.regressions, centre, anyhow, side=other
    ).constraints
    # to where each margin is at least as far above zero as it is soft
    move = np.linalg.pinv(constraints.slope) @ np.maximum(
        constraints.softness - constraints.margin, 0
    )
    about = whitening.whitened_about(
        programs, data, transform.regressions, centre + move, anyhow, side=other
    )
    yield replace(posterior, transform=about)


def _about_mode(posterior: Posterior, most: float) -> Posterior:
    """The posterior in coordinates about the mode near their centre.

    Raises:
        Unanswerable: there is none, or its potential is above `most`.
    """
    programs, data = posterior.programs, posterior.data
    responding = bool(rest_pose.with_response_surface(programs.structure))
    # constraints and whitening depend on the mode and it on them: thrice is enough, but for responses
    for _ in range(_WHITENINGS if responding else 3):
        posterior = _with_responses(posterior)
        transform = posterior.transform
        volume = float(transform.log_volume)
        mode, value = _mode(posterior, most - volume)
        if value + volume > most:
            raise Unanswerable("this mode is too improbable to count")
        constrained, centre = (
            posterior.constrained(mode),
            transform.centre + np.asarray(transform.spread) @ mode,
        )
        axes = np.asarray(transform.spread) @ spread(
            posterior.potential.curvature(mode), _RIDGE if responding else FLAT
        )
        if not (np.isfinite(axes).all() and np.isfinite(constrained).all()):
            raise _no_mode("curvature")
        side, kept = np.asarray(transform.constraints.side), float(transform.constraints.kept)
        if rest_pose.samples_sliding(programs.structure):
            kept, (centre, constrained, axes) = whitening.softened(
                transform, centre, constrained, axes
            )
        about = whitening.whitened_about(
            programs, data, transform.regressions, centre, axes, constrained, side, kept
        )
        posterior = replace(posterior, transform=about, log_evidence=-value)
        if responding and np.linalg.norm(mode) < _STILL:
            break
    return _with_responses(posterior)


def _with_responses(posterior: Posterior) -> Posterior:
    """The same, with responses for about where it is whitened."""
    if not rest_pose.with_response_surface(posterior.programs.structure):
        return posterior
    rng = np.random.default_rng(0)
    return posterior.with_responses(_WIDE * rng.standard_normal((_RUN_OUTS, posterior.size)))


def _starts(structure: Structure) -> list[np.ndarray]:
    """Where a mode may be sought from: all as measured, and A's speed anywhere if it was not."""
    middle = np.zeros(transform_of(structure).length(structure))
    if ("speed_a", "halfnormal") not in structure.uncertain:
        return [middle]
    unknown = len(structure.rest_components) + structure.names.index("speed_a")
    return [middle + deviate * (np.arange(middle.size) == unknown) for deviate in _SPEEDS]


def _likeliest(
    programs: Programs, data: Data, tried: list[TransformParameters]
) -> TransformParameters:
    """The transform at whose centre the density is the highest."""
    if len(tried) == 1:
        return tried[0]
    nowhere = np.zeros(transform_of(programs.structure).size(programs.structure))
    at = [Posterior(programs, data, transform, np.zeros(2), -np.inf, 0.0) for transform in tried]
    heights = [posterior.log_density(nowhere[None])[0] for posterior in at]
    return tried[int(np.argmax(np.nan_to_num(heights, nan=-np.inf)))]
