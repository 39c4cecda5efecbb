"""Scenes at the edges of inference, draws of them by one method, and what is wrong with those."""

from __future__ import annotations

import textwrap
from dataclasses import replace
from functools import partial
from typing import Any

import jax
import numpy as np
from arviz_stats.base import array_stats
from jax.flatten_util import ravel_pytree
from numpyro import handlers
from numpyro.infer.util import constrain_fn, potential_energy, unconstrain_fn
from retrodict.models import RUNGS
from retrodict.models.arrays import Data, Structure, steps_of

from retrodict.inference import Unanswerable
from retrodict.inference.density.compiled import programs_for
from retrodict.inference.diagnostics import MAX_RHAT, MIN_ESS
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.outcome import Outcome
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS, Draws, Task
from retrodict.inference.transforms.standard import Deviates
from retrodict.options import RunOptions
from retrodict.scene.records import Scene

ASKED = ("speed_b", "e", "e_m", "mu")
CHAINS, WARMUP = 4, 150  # as `reconstruct` has them

Array = np.ndarray[Any, np.dtype[Any]]


def from_the_prior(scene: Scene, rung: str) -> Posterior:
    """A scene's posterior in plain standard normal deviates, which know of no mode."""
    structure, data = RUNGS[rung].of_scene(scene)
    structure = replace(structure, transform="standard")
    transform = Deviates.example(structure)
    return Posterior(programs_for(structure), data, transform, np.zeros(2), -np.inf, 0.0)


def sites(posterior: Posterior, drawn: Draws) -> dict[str, Array]:
    """The asked unknowns at a method's draws, shape (chains, draws)."""
    found = drawn.known(posterior)
    return {name: np.asarray(found[name]).reshape(drawn.w.shape[:2]) for name in ASKED}


def draw(posterior: Posterior, method: str, draws: int | None = None, seed: int = 0) -> Draws:
    """A method's draws as `reconstruct` takes them, its second helping not counted."""
    task = Task(posterior, CHAINS, draws or METHODS[method].draws, WARMUP, seed, lambda *_: None)
    return METHODS[method].draw(task)


def faults(posterior: Posterior, drawn: Draws, x: dict[str, Array]) -> list[str]:
    """What the checks find against the draws, by their own limits."""
    found = list(drawn.faults)
    if not posterior.unresolved <= RESOLVED:
        found.append("run-outs unresolved")
    if "diverging" in drawn.stats and drawn.stats["diverging"].any():
        found.append(f"{int(drawn.stats['diverging'].sum())} divergences")
    rhat = max(float(array_stats.rhat(v)) for v in x.values())
    if not rhat <= MAX_RHAT:
        found.append(f"R-hat {rhat:.3f}")
    ways: tuple[dict[str, Any], ...] = (
        {"method": "bulk"},
        {"method": "tail", "prob": (0.05, 0.95)},
    )
    ess = min(float(array_stats.ess(v, **way)) for v in x.values() for way in ways)
    if not ess >= MIN_ESS:
        found.append(f"effective sample size {ess:.0f}")
    return found


def off(x: dict[str, Array], reference: dict[str, Array]) -> float:
    """The worst error of a mean, in sd, or of a sd, relative."""
    errors = []
    for name in ASKED:
        sd = reference[name].std()
        errors.append(abs(x[name].mean() - reference[name].mean()) / sd)
        errors.append(abs(x[name].std() / sd - 1))
    return float(np.max(errors)) if np.isfinite(errors).all() else np.inf


def verdict_of(scene: Scene, method: str = "importance") -> tuple[str, Outcome | None]:
    """What the checks of a reconstruction say, shortly."""
    try:
        outcome = reconstruct(scene, RunOptions(method=method))
    except Unanswerable as refusal:
        return f"refused ({str(refusal).split(';')[0]})", None
    checks = outcome.checks
    if not checks.passed:
        return f"withheld ({_short(checks.reasons[0])})", outcome
    flags = [_short(flag) for flag in checks.flags]
    return "passed" + (f", flagged: {'; '.join(flags)}" if flags else ""), outcome


def _short(reason: str) -> str:
    return textwrap.shorten(reason, 120, placeholder=" …")


def far_from_truth(outcome: Outcome | None, truth: dict[str, float]) -> float:
    """By how many posterior sd the mean misses the truth, the worst of four quantities."""
    if outcome is None:
        return np.nan
    draws = {name: outcome.idata["posterior"][name].values for name in ASKED}
    return max(float(abs(x.mean() - truth[name]) / x.std()) for name, x in draws.items())


def moved(scene: Scene, vehicle: str, metres: float) -> Scene:
    """The scene with a rest position written down so far off along x."""
    rest = scene.rest[vehicle]
    x = replace(rest.x, value=rest.x.value + metres)
    return replace(scene, rest=scene.rest | {vehicle: replace(rest, x=x)})


def vague(scene: Scene, factor: float) -> Scene:
    """The scene with rest poses so many times as uncertain."""

    def blurred(rest: object) -> object:
        names = ("x", "y", "heading")
        sds = {n: getattr(rest, n).sd * factor for n in names}
        return replace(rest, **{n: replace(getattr(rest, n), sd=sd) for n, sd in sds.items()})  # type: ignore[type-var]

    return replace(scene, rest={v: blurred(r) for v, r in scene.rest.items()})


def wrapped(scene: Scene) -> Scene:
    """The scene with B's rotation not written down."""
    rest, at = scene.rest["b"], scene.vehicles["b"].heading.value
    turn = (rest.heading.value - at + np.pi) % (2 * np.pi) - np.pi
    heading = replace(rest.heading, value=at + turn)
    return replace(
        scene, rest=scene.rest | {"b": replace(rest, heading=heading, turns_known=False)}
    )


class Forward:
    """The rung's density in one flat vector of its unconstrained sites.

    Args:
        structure: of the rung and scene, the run-out's steps as inference takes them.
        data: the scene's numbers.
        draws: of the posterior, the unknowns and more with a leading axis: where all start.
    """

    def __init__(self, structure: Structure, data: Data, draws: dict[str, Array]):
        # a number in the program, as reverse mode wants it
        structure = replace(structure, steps=steps_of(structure, data))
        self.model = partial(RUNGS[structure.rung].model, structure)
        self.structure, self.data = structure, data
        trace = handlers.trace(handlers.seed(self.model, 0)).get_trace(data)
        draws = {k: v for k, v in draws.items() if k in trace and trace[k]["type"] == "sample"}
        unconstrained = partial(unconstrain_fn, self.model, (data,), {})
        example = unconstrained({name: value[0] for name, value in draws.items()})
        _, self.unravel = ravel_pytree(example)
        flat = jax.jit(jax.vmap(lambda sites: ravel_pytree(unconstrained(sites))[0]))
        self.starts = np.asarray(flat(draws))

    def log_density(self, u: Any, data: Data) -> Any:
        """Of the flat vector, up to nothing: it is what NumPyro's NUTS samples."""
        return -potential_energy(self.model, (data,), {}, self.unravel(u))

    def sites(self, u: Array) -> dict[str, Array]:
        """The unknowns at draws of any leading shape."""
        constrained = partial(constrain_fn, self.model, (self.data,), {})
        of_all = jax.jit(jax.vmap(lambda row: constrained(self.unravel(row))))
        found = of_all(u.reshape(-1, u.shape[-1]))
        return {k: np.asarray(v).reshape(*u.shape[:-1], *v.shape[1:]) for k, v in found.items()}


def stiffness(posterior: Posterior, w: Array) -> tuple[float, float]:
    """Condition numbers of the draws' correlations, in NumPyro's coordinates and in ours.

    Args:
        posterior: that was drawn from.
        w: draws in the sampled coordinates, shape (any, q).
    """
    quantities = posterior.evaluate(w)[1]
    forward = Forward(posterior.programs.structure, posterior.data, quantities)
    naive, ours = (np.linalg.cond(np.corrcoef(u.T)) for u in (forward.starts, w))
    return float(naive), float(ours)
