"""A scene changed and asked again: coordinates are fitted once, and taken along as its numbers change.

The search for a posterior's modes and coordinates takes most of a reconstruction, and few of its numbers
change with a measurement. Here it is done once. A scene of the same structure is answered in
coordinates rebased to its numbers, by some thousands of weighted points about where the first posterior
lay: scrambled Sobol points, whose scramblings show the error. The density is exact.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from retrodict.inference import diagnostics
from retrodict.inference.digits import decimals_of
from retrodict.inference.fitting.posterior import LEAST_WEIGHT, Posterior
from retrodict.inference.fitting.rebase import rebased
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.modes import (
    SLIGHT,
    Solution,
    UnsampledMode,
    shares,
    solutions,
    turned,
    unsampled,
)
from retrodict.inference.outcome import Checks
from retrodict.inference.samplers.importance import Proposal, adapted, evaluated
from retrodict.inference.samplers.psis import (
    effective,
    judged,
    log_mean,
    resampled,
    smoothed,
)
from retrodict.inference.samplers.quasi import Weighted, scrambled
from retrodict.inference.threads import one_blas_thread
from retrodict.models import RUNGS
from retrodict.progress import Progress, silent
from retrodict.scene.quantities import describe
from retrodict.scene.records import Scene

SCRAMBLINGS = 8
_POINTS, _MOST = 256, 4  # of each scrambling at first, and times as many at most
_PILOT, _FITTED = 512, 4096  # points that a proposal is moved by, and made by
# Independent draws whose errors are not exceeded: 1000 leave a mean uncertain by 3 % of its sd.
_AS_GOOD_AS = 1000.0
_DRAWS = 2000  # of equal weight
_TAILS = np.array([0.025, 0.975])
_USELESS = (
    12.0  # log weight by which a solution may fall behind, and count when measurements change
)
# Effective draws that a fitted proposal's covariance counts for beside those of a pilot. (Of 24 changes
# of up to 3 sd on the paper's scene 24 % or more of the points were effective with 2 q = 54, 44 % with
# this.)
_WORTH = 1000.0


@dataclass(frozen=True)
class Fitted:
    """A solution of the scene that coordinates were fitted to.

    Args:
        solution: with its posterior.
        constrained: where constraints take the centre of its coordinates, shape (q,).
        proposal: that its draws suggest.
        others: other modes of its posterior, which draws should reach.
    """

    solution: Solution
    constrained: np.ndarray
    proposal: Proposal
    others: tuple[UnsampledMode, ...]


@dataclass(frozen=True)
class _Drawn:
    """Points of a solution, the logs of their weights, and what they are known by."""

    w: np.ndarray
    log_weight: np.ndarray
    quantities: dict[str, np.ndarray]


@dataclass(frozen=True)
class Precision:
    """How precise reported quantities are.

    Args:
        bulk, tail: independent draws that would leave the same errors of means, and of probabilities in
            the tails, the least of any quantity.
        imprecise: quantities of which not one digit is sure.
        faults: for which they are not to be relied on.
    """

    bulk: float
    tail: float
    imprecise: tuple[str, ...]
    faults: tuple[str, ...]


@dataclass(frozen=True)
class Estimate:
    """A posterior by weighted points.

    Args:
        scene: what was measured.
        quantities: at each point, by name, SI units and radians.
        draws: of equal weight, by name.
        weighted: the weights of the points.
        checks: the verdict on them: effective sample sizes are the numbers of independent draws that
            would leave the same error, the least of any reported quantity; R-hat is NaN, without chains.
        share: of the points that are effective.
        evaluations: of the density.
        seconds: that it took.
        refitted: whether coordinates had to be fitted for it.
    """

    scene: Scene
    quantities: dict[str, np.ndarray]
    draws: dict[str, np.ndarray]
    weighted: Weighted
    checks: Checks
    share: float
    evaluations: int
    seconds: float
    refitted: bool = False


class Warm(Protocol):
    """A rung's posterior of a scene, ready to be asked of scenes that differ in numbers."""

    scene: Scene

    def fits(self, scene: Scene) -> bool:
        """Whether a scene is of the same structure, so that its numbers alone differ."""

    def estimate(self, scene: Scene) -> Estimate:
        """The posterior of a scene that this one `fits`; its checks say whether it can be relied on."""


class WarmPoints:
    """The same by importance sampling.

    Args:
        scene: that coordinates are fitted to.
        rung: a name in `retrodict.models.RUNGS`.
        seed: of the points.
        progress: as of `solutions`.

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
        searching = partial(progress or silent, "finding where the posterior lies")
        found = solutions(scene, rung, searching)
        fitted = [_fitted(solution, seed) for solution in found]
        most = max(value for _, value in fitted)
        self.fitted = [each for each, value in fitted if value > most - _USELESS]
        size = self.fitted[0].proposal.middle.size + 2
        self._pilot = scrambled(size, _PILOT, 1, seed + 1)
        # of each scrambling in a row; the first of them are even too
        points = scrambled(size, _MOST * _POINTS, SCRAMBLINGS, seed)
        self._points = points.reshape(SCRAMBLINGS, -1, size)

    def fits(self, scene: Scene) -> bool:
        """Whether a scene is of the same structure, so that its numbers alone differ."""
        for each in self.fitted:
            own = each.solution.posterior.programs.structure
            structure, _ = RUNGS[self.rung].of_scene(turned(scene, each.solution.turns))
            if replace(structure, steps=own.steps) != own:
                return False
        return True

    @one_blas_thread()
    def estimate(self, scene: Scene) -> Estimate:
        """The posterior of a scene that this one `fits`.

        Args:
            scene: what was measured.

        Returns:
            The estimate; its checks say whether it can be relied on.
        """
        begin = time.perf_counter()
        posteriors = [self._rebased(each, scene) for each in self.fitted]
        moved = [
            adapted(posterior, each.proposal, lambda at: at.at(self._pilot))
            for posterior, each in zip(posteriors, self.fitted, strict=True)
        ]
        proposals = [each.next for each in moved]
        drawn = [self._drawn(*each, 0, 1) for each in zip(posteriors, proposals, strict=True)]
        times = 1
        while True:
            weighted, faults, k = self._weighted(posteriors, drawn)
            quantities = {
                name: _side_by_side([each.quantities[name] for each in drawn])
                for name in drawn[0].quantities
            }
            precise = precision(scene, quantities, weighted)
            if times == _MOST or min(precise.bulk, precise.tail) >= _AS_GOOD_AS:
                break
            more = [
                self._drawn(*each, times, 2 * times)
                for each in zip(posteriors, proposals, strict=True)
            ]
            drawn = [_joined(*each) for each in zip(drawn, more, strict=True)]
            times *= 2
        evaluations = sum(each.evaluations for each in moved) + weighted.weights.size
        return estimated(scene, quantities, weighted, precise, faults, evaluations, begin, k)

    def _rebased(self, fitted: Fitted, scene: Scene) -> Posterior:
        _, data = RUNGS[self.rung].of_scene(turned(scene, fitted.solution.turns))
        return rebased(fitted.solution.posterior, data, fitted.constrained)

    def _drawn(self, posterior: Posterior, proposal: Proposal, first: int, last: int) -> _Drawn:
        """Points of every scrambling, from so many times `_POINTS` on."""
        points = self._points[:, first * _POINTS : last * _POINTS]
        w = proposal.at(points.reshape(-1, points.shape[2]))
        heights, quantities = evaluated(posterior, w)
        return _Drawn(w, heights - proposal.log_density(w), quantities)

    def _weighted(
        self, posteriors: list[Posterior], drawn: list[_Drawn]
    ) -> tuple[Weighted, tuple[str, ...], float]:
        """Solutions side by side by their evidence; faults of their weights, and the worst Pareto k."""
        evidence = np.array([log_mean(each.log_weight)[0] for each in drawn])
        parts = (
            shares(evidence) if np.isfinite(evidence).any() else np.ones(len(drawn)) / len(drawn)
        )
        reasons: list[str] = []
        weights, k = [], []
        for share, each, posterior, fitted in zip(
            parts, drawn, posteriors, self.fitted, strict=True
        ):
            own, shape = smoothed(each.log_weight)
            weights.append(share * own)
            reasons += [
                f"the evidence fits another solution (weight {other.odds * share:.1%}) that was not "
                "sampled: confirm the answer by a full run"
                for other in fitted.others
                if other.odds * share > LEAST_WEIGHT and not other.reached(each.w, own)
            ]
            if share >= SLIGHT:
                k.append(shape)
                reasons += judged(shape)["faults"]
                reasons += too_sharp(posterior)
        weighted = Weighted(_side_by_side(weights), SCRAMBLINGS)
        return weighted, tuple(reasons), max(k, default=np.inf)


def too_sharp(posterior: Posterior) -> tuple[str, ...]:
    """That rest poses are sharper than run-outs resolve; nothing where they are not."""
    if posterior.unresolved <= RESOLVED:
        return ()
    return (
        "rest poses are sharper than the steps of their run-outs resolve: "
        f"{posterior.unresolved:.2f} standard deviations, {RESOLVED} is asked",
    )


def estimated(
    scene: Scene,
    quantities: dict[str, np.ndarray],
    weighted: Weighted,
    precise: Precision,
    faults: tuple[str, ...],
    evaluations: int,
    begin: float,
    pareto_k: float | None = None,
) -> Estimate:
    """Weighted points with the verdict on them.

    Args:
        scene: what was measured.
        quantities: at each point, by name.
        weighted: their weights.
        precise: how precise they are.
        faults: other reasons for which they are not to be relied on.
        evaluations: of the density.
        begin: when the work began, by `time.perf_counter`.
        pareto_k: of the importance weights, where they are.
    """
    reasons = faults + precise.faults
    draws = _equally_weighted(weighted, quantities)
    predicted = {
        name.removeprefix("predicted/"): values
        for name, values in draws.items()
        if name.startswith("predicted/")
    }
    checks = Checks(
        divergences=None,
        max_rhat=np.nan,
        min_ess_bulk=precise.bulk,
        min_ess_tail=precise.tail,
        passed=not reasons,
        reasons=reasons,
        failed=tuple(_reported(scene, quantities)) if reasons else (),
        flags=diagnostics.flags(draws, predicted, scene),
        pareto_k=pareto_k,
        imprecise=precise.imprecise,
    )
    return Estimate(
        scene=scene,
        quantities=quantities,
        draws=draws,
        weighted=weighted,
        checks=checks,
        share=effective(weighted.weights) / weighted.weights.size,
        evaluations=evaluations,
        seconds=time.perf_counter() - begin,
    )


def _equally_weighted(
    weighted: Weighted, quantities: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    index = resampled(weighted.weights, _DRAWS, np.random.default_rng(0))
    return {
        name: values[index]
        for name, values in quantities.items()
        if not name.startswith("log_likelihood/")
    }


def _fitted(solution: Solution, seed: int) -> tuple[Fitted, float]:
    """A solution with the proposal that its draws suggest, and its log evidence."""
    posterior = solution.posterior
    points = scrambled(posterior.size + 2, _FITTED, 1, seed + 2)
    found = adapted(posterior, Proposal.first(posterior.size), lambda at: at.at(points))
    constrained = posterior.constrained(np.zeros(posterior.size))
    proposal = replace(found.next, worth=_WORTH)
    others = tuple(UnsampledMode(0, odds, w) for odds, w in unsampled(posterior, seed))
    return Fitted(solution, constrained, proposal, others), log_mean(found.log_weight)[0]


def _joined(one: _Drawn, other: _Drawn) -> _Drawn:
    """More points of every scrambling, beside those before."""
    return _Drawn(
        _side_by_side([one.w, other.w]),
        _side_by_side([one.log_weight, other.log_weight]),
        {k: _side_by_side([v, other.quantities[k]]) for k, v in one.quantities.items()},
    )


def _side_by_side(parts: list[np.ndarray]) -> np.ndarray:
    """Parts that each hold every scrambling in a row, as one that does."""
    rows = [part.reshape(SCRAMBLINGS, -1, *part.shape[1:]) for part in parts]
    joined = np.concatenate(rows, axis=1)
    return joined.reshape(-1, *joined.shape[2:])


def _reported(scene: Scene, quantities: dict[str, np.ndarray]) -> list[str]:
    return [name for name in scene.reported() if name in quantities]


def precision(scene: Scene, quantities: dict[str, np.ndarray], weighted: Weighted) -> Precision:
    """How precise the reported quantities of weighted points are; arguments as of `estimated`."""
    bulk, tail = {}, {}
    imprecise, faults = [], []
    for name in _reported(scene, quantities):
        values = quantities[name]
        (_, error), (sd, _) = weighted.mean(values), weighted.sd(values)
        errors = weighted.quantiles(values, _TAILS)[1]
        bulk[name] = float(np.square(sd / error)) if error > 0 else np.inf
        tail[name] = float(np.min(_TAILS * (1 - _TAILS) / np.maximum(errors, 1e-12) ** 2))
        # an error of a probability moves the limit as far as this
        beyond = weighted.quantiles(values, np.clip(_TAILS + errors, 0, 1))[0]
        before = weighted.quantiles(values, np.clip(_TAILS - errors, 0, 1))[0]
        of_limits = float(np.max(beyond - before)) / 2
        if decimals_of(sd, 1, of_limits) != decimals_of(sd, 1):
            imprecise.append(name)
        for count, of in ((bulk[name], "mean"), (tail[name], "tails")):
            if not count >= diagnostics.MIN_ESS:
                faults.append(
                    f"{describe(name)[0]}: its {of} are as uncertain as {count:.0f} independent draws "
                    f"would leave them, {diagnostics.MIN_ESS:.0f} are asked"
                )
    return Precision(min(bulk.values()), min(tail.values()), tuple(imprecise), tuple(faults))
