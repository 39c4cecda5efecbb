"""Sequential Monte Carlo, tempered from a wide Student-t to the posterior; it gives the evidence too."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np

from retrodict.inference.errors import Interrupted
from retrodict.inference.methods.draws import Draws, Task
from retrodict.inference.methods.weights import resampled

_MOST_STAGES = 60


def draw(task: Task) -> Draws:
    """Draw by blackjax's adaptive tempered SMC with HMC moves, each chain a run of its own.

    Raises:
        Interrupted: stopped before all of a run's stages were done.
    """
    posterior, n = task.posterior, task.posterior.size
    start, advance = posterior.programs.tempering(task.draws, posterior.data, posterior.chart)
    particles, evidence = [], []
    faults: tuple[str, ...] = ()
    rng = np.random.default_rng(task.seed)
    try:
        for chain, key in enumerate(jax.random.split(jax.random.key(task.seed), task.chains)):
            state = start(key, posterior.data, posterior.chart)
            for _ in range(_MOST_STAGES):
                state = advance(state, posterior.data, posterior.chart)
                if float(state.temperature) >= 1:
                    break
            else:
                faults = (f"tempering had not reached the posterior after {_MOST_STAGES} stages",)
            # the last stage's weights still stand beside its particles
            index = resampled(np.asarray(state.weights), len(state.weights), rng)
            particles.append(np.asarray(state.particles)[index])
            evidence.append(float(state.log_evidence))
            task.progress(chain + 1, task.chains)
    except KeyboardInterrupt:
        if not particles:
            raise Interrupted("stopped before any draws were kept") from None
    w = np.stack(particles).reshape(len(particles), task.draws, n)
    return Draws(
        w,
        {},
        complete=len(particles) == task.chains,
        faults=faults,
        attributes={
            "log_evidence": float(np.mean(evidence)),
            "log_evidence_sd": float(np.std(evidence, ddof=1)) if len(evidence) > 1 else np.nan,
        },
        more=lambda: _as_many_again(task, w),
    )


def _as_many_again(task: Task, w: np.ndarray) -> Draws:
    """Runs beside those that there are: twice the particles would be another program to compile."""
    others = draw(replace(task, seed=task.seed + 2**31))
    return replace(others, w=np.concatenate([w[: len(others.w)], others.w], axis=1), more=None)
