"""NUTS, the default and the reference: a run with few divergences is repeated in shorter steps, once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from retrodict.inference.density.compiled import Programs
from retrodict.inference.errors import Interrupted
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.samplers import chains
from retrodict.inference.samplers.chains import Chains, sample
from retrodict.inference.samplers.draws import Draws, Task
from retrodict.inference.samplers.importance import weighted_points
from retrodict.inference.samplers.psis import resampled, smoothed
from retrodict.inference.transforms.choice import Transform
from retrodict.models.arrays import Data, Structure
from retrodict.storage import checkpoint

_FIRST_TRY = 0.65  # target acceptance: fewer, longer steps bring more effective draws a second
# Target acceptance of the run that follows one with divergences. No more: the gradient steers only near
# enough, so that acceptance stays at 0.9 however short the steps, and steps that aim for it collapse
# (measured).
_SECOND_TRY = 0.8
# Both targets for a posterior that rest poses do not pin, whose gradients are exact: 0.8 leaves one to
# three divergences in 2000 draws of four random crashes in ten, 0.95 none, in 1.4 times as many steps
# (measured).
# Where one is left all the same, shorter steps still help.
_CURVED, _STEADY = 0.95, 0.99
_STUCK = "a chain gets nowhere: its steps became too short to cross the posterior"
_PILOT = 2000  # importance draws by which such a posterior is whitened, or responses are fitted
_FEW = 0.05  # share of divergent draws up to which shorter steps may help


def draw(task: Task) -> Draws:
    """Draw by NUTS.

    Raises:
        Interrupted: stopped before any draws were kept.
    """
    original = task.posterior.differentiable()
    task = replace(task, posterior=original)
    first, second = targets(original.programs.structure)
    task = replace(task, posterior=refitted(original, task.seed))
    found, target_accept = sample(task, first), first
    notes: tuple[str, ...] = ()
    divergences = int(found.stats["diverging"].sum()) if found.stats else 0
    few = 0 < divergences <= _FEW * found.w.shape[0] * found.w.shape[1]
    if found.complete and few and not found.stuck:
        notes = (
            f"a first run had {divergences} divergent transitions; the run reported here took shorter "
            f"steps (target acceptance {second}) and twice the warm-up",
        )
        task = replace(task, warmup=2 * task.warmup, resume=None)
        target_accept = second
        found = sample(task, target_accept)
    if found.w.shape[1] < 4:
        raise Interrupted("stopped before any draws were kept")
    drawn = _draws_of(found, task, original, target_accept, notes)
    if found.stuck:
        return replace(drawn, faults=(_STUCK,))

    def more() -> Draws:
        longer = replace(task, draws=2 * task.draws, resume=None)
        return _draws_of(
            sample(longer, target_accept, found), longer, original, target_accept, notes
        )

    return replace(drawn, more=more)


def refitted(posterior: Posterior, seed: int) -> Posterior:
    """The same posterior with coordinates or surrogates fitted to importance draws, if they take it.

    Args:
        posterior: posterior to be sampled by chains.
        seed: integer seed of the draws.
    """
    if not posterior.refits:
        return posterior
    rng = np.random.default_rng([seed, 10])
    w, log_weight, _, _ = weighted_points(posterior, _PILOT, rng)
    return posterior.refit(w[resampled(smoothed(log_weight)[0], _PILOT, rng)])


def compile_ahead(programs: Programs, warmup: int, data: Data, transform: Transform) -> None:
    """Have the first run's kernels compiled in the background, in rest-pose coordinates."""
    chains.kernels(programs, warmup, targets(programs.structure)[0], data, transform)


def targets(structure: Structure) -> tuple[float, float]:
    """Target acceptance of a first run, and of one after divergences."""
    return (_CURVED, _STEADY) if structure.in_deviates else (_FIRST_TRY, _SECOND_TRY)


def _draws_of(
    found: Chains, task: Task, original: Posterior, target_accept: float, notes: tuple[str, ...]
) -> Draws:
    first = target_accept == targets(task.posterior.programs.structure)[0] and not found.complete
    unfinished = (
        checkpoint.packed(found.states, found.records, chains.settings(task)) if first else None
    )
    w = task.posterior.converted_to(original, found.w.reshape(-1, original.size))
    return Draws(
        w.reshape(found.w.shape), found.stats, found.complete, notes, unfinished=unfinished
    )
