"""A scene whose vehicles roll, changed and asked again: particles move on from where they were.

Posteriors of rolling vehicles bend and fold too much for one proposal. Populations of particles that
were drawn from the first scene are tempered from its posterior to the changed one's, which takes a few
stages and not dozens.
"""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial

import numpy as np

from retrodict.inference.fitting import rolling
from retrodict.inference.fitting.rebase import rebased
from retrodict.inference.points import Estimate, estimated, precision, too_sharp
from retrodict.inference.samplers import smc
from retrodict.inference.samplers.draws import Draws, Task
from retrodict.inference.samplers.quasi import Weighted
from retrodict.inference.warm import Warm, WarmPoints
from retrodict.progress import Progress, silent
from retrodict.scene.records import Scene

_POPULATIONS, _PARTICLES = 8, 256  # independent populations, whose spread is the error


class WarmParticles:
    """A rung's posterior of a scene with rolling vehicles, as of `Warm`.

    Args:
        scene: that particles are drawn from at first.
        rung: a name in `retrodict.models.RUNGS`.
        seed: of all random numbers.
        progress: called as the work goes on.

    Raises:
        Unanswerable: as of `rolling.prepare`.
        Interrupted: stopped before any draws were kept.
    """

    def __init__(
        self, scene: Scene, rung: str, seed: int = 0, progress: Progress | None = None
    ) -> None:
        self.scene = scene
        self.rung = rung
        self.seed = seed
        self._posterior = rolling.prepare(scene, rung)
        self._drawn = smc.draw(self._task(partial(progress or silent, "sampling")))

    def _task(self, progress: smc.Progress) -> Task:
        return Task(self._posterior, _POPULATIONS, _PARTICLES, 0, self.seed, progress)

    def fits(self, scene: Scene) -> bool:
        """Whether a scene is of the same structure, so that its numbers alone differ."""
        if not rolling.tempered(scene, self.rung):
            return False
        own = self._posterior.programs.structure
        return replace(rolling.seen(scene, self.rung).offset, steps=own.steps) == own

    def estimate(self, scene: Scene) -> Estimate:
        """The posterior of a scene that this one `fits`; its checks say whether it can be relied on."""
        begin = time.perf_counter()
        drawn, posterior = self._drawn, self._posterior
        if scene != self.scene:
            posterior = rebased(posterior, rolling.seen(scene, self.rung).data)
            task = replace(self._task(lambda *_: None), posterior=posterior)
            drawn = smc.draw_again(task, self._posterior, self._drawn.w)
        faults = drawn.faults + too_sharp(posterior)
        count = drawn.w.shape[0] * drawn.w.shape[1]
        weighted = Weighted(np.full(count, 1 / count), _POPULATIONS)
        evaluations = int(drawn.attributes["evaluations"])
        quantities = _known(drawn, posterior)
        precise = precision(scene, quantities, weighted)
        return estimated(scene, quantities, weighted, precise, faults, evaluations, begin)


def _known(drawn: Draws, posterior: rolling.Posterior) -> dict[str, np.ndarray]:
    return {k: np.asarray(v) for k, v in drawn.known(posterior).items() if np.ndim(v) == 1}


def warm(scene: Scene, rung: str, seed: int = 0, progress: Progress | None = None) -> Warm:
    """A rung's posterior of a scene, ready to be asked of scenes that differ in numbers.

    Args:
        scene: that coordinates are fitted to.
        rung: a name in `retrodict.models.RUNGS`.
        seed: of all random numbers.
        progress: called as the work goes on.

    Raises:
        Unanswerable: the scene has no posterior that could be sampled.
    """
    by_particles = scene.rolling and rolling.tempered(scene, rung)
    return (WarmParticles if by_particles else WarmPoints)(scene, rung, seed, progress)
