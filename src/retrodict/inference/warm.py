"""A scene changed and asked again: coordinates are fitted once, and taken along as its numbers change.

The search for a posterior's modes and coordinates takes most of a reconstruction, and few of its numbers
change with a measurement. Here the search is done once. A scene of the same structure is answered in
coordinates rebased to its numbers, by some thousands of weighted points about where the first posterior
lay.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from retrodict.inference.fitting.about_peak import turned
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.fitting.rebase import rebased
from retrodict.inference.modes import Solution, solutions
from retrodict.inference.plan import kept_warm
from retrodict.inference.points import TAILS, USELESS, Estimate, Part, Points, more_points
from retrodict.inference.samplers.importance import adapted
from retrodict.inference.samplers.nested import nested
from retrodict.inference.samplers.proposal import LIGHT, Proposal
from retrodict.inference.samplers.psis import log_mean
from retrodict.inference.samplers.quasi import scrambled
from retrodict.inference.threads import one_blas_thread
from retrodict.models import RUNGS
from retrodict.progress import Progress, silent
from retrodict.scene.records import Scene

_FITTED = 4096  # points by which a proposal is fitted
# Effective draws that a fitted proposal's covariance counts for beside those of a pilot. (Of 24 changes
# of up to 3 sd on the paper's scene 24 % or more of the points were effective with 2 q = 54, 44 % with
# this.)
_WORTH = 1000.0


@dataclass(frozen=True)
class Fitted:
    """A solution of the scene that coordinates were fitted to.

    Args:
        solution: solution, with its posterior.
        constrained: centre of its coordinates as constraints move it, shape (q,).
        proposal: proposal that its draws suggest; None where each scene has a nested one of its own,
            which follows long tails that one about the mode misses.
    """

    solution: Solution
    constrained: np.ndarray
    proposal: Proposal | None


class Warm:
    """A rung's posterior of a scene, ready to be asked of scenes that differ in numbers.

    Args:
        scene: scene that coordinates are fitted to.
        rung: a name in `retrodict.models.RUNGS`.
        seed: integer seed of the search and of the points.
        progress: callback that is called with (stage, done, of all) as the work goes on.

    Raises:
        Unanswerable: as of `solutions`.
    """

    @one_blas_thread()
    def __init__(
        self, scene: Scene, rung: str, seed: int = 0, progress: Progress | None = None
    ) -> None:
        self.scene = scene
        self.rung = rung
        self.seed = seed
        (progress or silent)("finding where the posterior lies", 0, 1)
        found = solutions(scene, rung, seed, kept_warm(scene, rung))
        fitted = [_fitted(solution, seed) for solution in found]
        most = max(value for _, value in fitted)
        self.fitted = [each for each, value in fitted if value > most - USELESS]
        self._points = Points(self.fitted[0].solution.posterior.size + TAILS, seed)

    def fits(self, scene: Scene) -> bool:
        """Whether a scene is of the same structure, so that its numbers alone differ."""
        for each in self.fitted:
            own = each.solution.posterior.programs.structure
            structure, _ = RUNGS[self.rung].of_scene(turned(scene, each.solution.turns))
            if replace(structure, steps=own.steps, transform=own.transform) != own:
                return False
        return True

    @one_blas_thread()
    def estimate(self, scene: Scene) -> Estimate:
        """The posterior of a scene that this one `fits`.

        Args:
            scene: scene of the same structure that is asked about.

        Returns:
            The estimate; its checks say whether it can be relied on.
        """
        begin = time.perf_counter()
        parts = [self._part(each, scene) for each in self.fitted]
        found = self._points.estimate(scene, parts, begin)
        if found.checks.passed or scene != self.scene:  # refitted coordinates may do
            return found
        more = more_points(self.fitted[0].solution.posterior.size, self.seed)
        return more.estimate(scene, parts, begin)

    def _part(self, fitted: Fitted, scene: Scene) -> Part:
        """A solution of a scene with the proposal for it."""
        posterior = self._rebased(fitted, scene)
        if fitted.proposal is not None:
            return Part(posterior, fitted.proposal)
        own = nested(replace(posterior, peak=fitted.solution.posterior.peak))
        assert own is not None, "as of the scene that was fitted to"
        return Part(posterior, own)

    def _rebased(self, fitted: Fitted, scene: Scene) -> Posterior:
        _, data = RUNGS[self.rung].of_scene(turned(scene, fitted.solution.turns))
        return rebased(fitted.solution.posterior, data, fitted.constrained)


def _fitted(solution: Solution, seed: int) -> tuple[Fitted, float]:
    """A solution with the proposal that its draws suggest, and its log evidence.

    Run-outs of wheels that roll are too dear for a nested proposal to each change of a scene.
    """
    posterior = solution.posterior
    constrained = posterior.constrained(np.zeros(posterior.size))
    if nested(posterior) is not None and not posterior.programs.structure.paced:
        return Fitted(solution, constrained, None), posterior.log_evidence
    points = scrambled(posterior.size + 2, _FITTED, 1, seed + 2)
    found = adapted(posterior, Proposal.first(posterior.size, LIGHT), lambda at: at.at(points))
    proposal = replace(found.next, worth=_WORTH)
    return Fitted(solution, constrained, proposal), log_mean(found.log_weight)[0]
