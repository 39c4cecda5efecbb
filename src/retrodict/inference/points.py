"""A scene's posterior by weighted points: scrambled Sobol points about each solution.

The scramblings show the error. The density is exact; the choice of proposal only affects efficiency.
`answer` computes the points from a scene alone, and keeps nothing for the next scene.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from retrodict.inference import diagnostics
from retrodict.inference.digits import decimals_of
from retrodict.inference.fitting.posterior import LEAST_WEIGHT, Posterior
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.modes import SLIGHT, shares, solutions
from retrodict.inference.outcome import Checks
from retrodict.inference.samplers.importance import adapted, evaluated
from retrodict.inference.samplers.nested import EXTRA, Nested, nested
from retrodict.inference.samplers.proposal import Proposal
from retrodict.inference.samplers.psis import (
    MAX_PARETO_K,
    effective,
    judged,
    log_mean,
    resampled,
    smoothed,
)
from retrodict.inference.samplers.quasi import Weighted, scrambled
from retrodict.inference.threads import one_blas_thread
from retrodict.inference.transforms.choice import Coordinates
from retrodict.scene.quantities import describe
from retrodict.scene.records import Scene

SCRAMBLINGS = 8
USELESS = 12.0  # log weight by which a solution may fall behind, and be sampled
_POINTS = 256  # points of each scrambling at first
_MOST = 4  # largest multiple of them
_PILOT = 512  # points that a proposal is moved by
# The same where these do not do and a whole run would follow, which takes ten times as long.
_THEN_MOST, _THEN_PILOT = 16, 2048
# Independent draws whose errors are not exceeded: 1000 leave a mean uncertain by 3 % of its sd.
_AS_GOOD_AS = 1000.0
# Points of each scrambling at first, and the largest multiple of them, where each is solved for.
_NESTED_FIRST, _NESTED_MOST = 128, 64
_HEAVY_MOST = 16  # the same where weights are too uneven, though they shape the proposal each time
_MEANLESS = 1.0  # Pareto k above which weights have no mean, however many they are
TAILS = 2  # coordinates of the unit cube that make the tails of a proposal about a mode
_SHORT = 1 / 3  # share of the draws that are enough, below which first points shape the proposal
_DRAWS = 2000  # of equal weight
_TAILS = np.array([0.025, 0.975])


@dataclass(frozen=True)
class _Drawn:
    """Points of a solution, the logs of their weights, and the model's quantities there."""

    w: np.ndarray
    log_weight: np.ndarray
    quantities: dict[str, np.ndarray]


@dataclass(frozen=True)
class Precision:
    """Precision of reported quantities.

    Args:
        bulk, tail: number of independent draws that would leave the same errors of means, and of
            probabilities in the tails, the least of any quantity.
        imprecise: quantities of which not one digit of the standard deviation is sure.
        faults: reasons not to rely on the quantities, in words.
    """

    bulk: float
    tail: float
    imprecise: tuple[str, ...]
    faults: tuple[str, ...]


@dataclass(frozen=True)
class Estimate:
    """A posterior by weighted points.

    Args:
        scene: scene that the estimate is of.
        quantities: the model's quantities at each point, by name, SI units and radians.
        draws: the same for draws of equal weight, by name.
        weighted: the weights of the points.
        checks: verdict on the points; its effective sample sizes are numbers of independent draws that
            would leave the same error, the least of any reported quantity; R-hat is NaN, without chains.
        share: effective sample size over the number of points.
        evaluations: number of density evaluations.
        seconds: duration of the computation, s.
        refitted: whether coordinates had to be fitted for the scene.
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


@dataclass(frozen=True)
class Part:
    """A solution's share in an estimate: its posterior, and the proposal for its points.

    Args:
        posterior: posterior of the scene, at one number of turns and on one branch.
        proposal: proposal; one about the mode moves first to where a pilot finds the posterior.
    """

    posterior: Posterior
    proposal: Proposal | Nested

    def moved(self, pilot: Callable[[], np.ndarray]) -> _Moved:
        """The part after a pilot, where its proposal needs one.

        Args:
            pilot: function that gives the points of the pilot in the unit cube.
        """
        if isinstance(self.proposal, Nested):
            return _Moved(self, self.posterior.log_evidence, 0)
        points = pilot()
        found = adapted(self.posterior, self.proposal, lambda at: at.at(points))
        part = Part(self.posterior, found.next)
        return _Moved(part, log_mean(found.log_weight)[0], found.evaluations)

    def shaped(self, drawn: _Drawn) -> Part:
        """The part with its proposal where first draws have shown the posterior to be."""
        if not isinstance(self.proposal, Nested):  # pilots have moved it
            return self
        return Part(self.posterior, self.proposal.moved(drawn.w, drawn.log_weight))

    def drawn(self, points: np.ndarray) -> _Drawn:
        """Points in the unit cube, one scrambling after another, as draws from the proposal."""
        points = points.reshape(-1, points.shape[2])
        if isinstance(self.proposal, Nested):
            w, log_density = self.proposal.at(points)
        else:
            w = self.proposal.at(points)
            log_density = self.proposal.log_density(w)
        heights, quantities = evaluated(self.posterior, w)
        return _Drawn(w, heights - log_density, quantities)


class _Moved(NamedTuple):
    """A part with its proposal where the posterior is, its log evidence, and evaluations so far."""

    part: Part
    log_evidence: float
    evaluations: int


class Points:
    """Scrambled points of one seed, for posteriors of one size.

    Args:
        cube: number of coordinates of a point in the unit cube.
        seed: integer seed of the scramblings.
        most: largest number of points as a multiple of those at first, a power of two.
        pilot: number of points in each pilot that adapts a proposal, a power of two.
        first: number of points of each scrambling at first, a power of two.
    """

    def __init__(
        self, cube: int, seed: int, most: int = _MOST, pilot: int = _PILOT, first: int = _POINTS
    ) -> None:
        self._pilot = cache(lambda: scrambled(cube, pilot, 1, seed + 1))
        # a row of points for each scrambling, of which the first ones fill the cube evenly too
        self._points = scrambled(cube, most * first, SCRAMBLINGS, seed).reshape(
            SCRAMBLINGS, -1, cube
        )
        self._most, self._first = most, first

    def estimate(
        self, scene: Scene, parts: list[Part], begin: float, enough: float = _AS_GOOD_AS
    ) -> Estimate:
        """The posterior of a scene.

        Args:
            scene: scene that is asked about.
            parts: solutions that make up its posterior.
            begin: time when the work began, by `time.perf_counter`, s.
            enough: number of independent draws whose errors are small enough; larger ones ask for more
                points.

        Returns:
            The estimate; its checks say whether it can be relied on.
        """
        moved = [part.moved(self._pilot) for part in parts]
        evidence = [each.log_evidence for each in moved]
        # none of them is behind another where no point has a density
        least = max(evidence) - USELESS if np.isfinite(evidence).any() else -np.inf
        parts = [each.part for each in moved if each.log_evidence >= least]

        def more(first: int, last: int) -> list[_Drawn]:
            points = self._points[:, first * self._first : last * self._first]
            return [part.drawn(points) for part in parts]

        times, drawn, shaped = 1, more(0, 1), False
        counting = np.flatnonzero(_odds(drawn) > LEAST_WEIGHT)
        parts, drawn = [parts[i] for i in counting], [drawn[i] for i in counting]
        while True:
            weighted, faults, k = _weighted(parts, drawn)
            quantities = {
                name: _side_by_side([each.quantities[name] for each in drawn])
                for name in drawn[0].quantities
            }
            precise = precision(scene, quantities, weighted)
            worth, even = min(precise.bulk, precise.tail), k <= MAX_PARETO_K
            most = self._most if even else min(self._most, _HEAVY_MOST)
            if (even and worth >= enough) or times >= most or (shaped and k > _MEANLESS):
                break
            if not even or (worth < _SHORT * enough and not shaped):
                shaped = True
                parts = [part.shaped(each) for part, each in zip(parts, drawn, strict=True)]
                drawn = more(times, 2 * times)  # those that shaped a proposal would bias the answer
            else:
                further = more(times, 2 * times)
                drawn = [_joined(*each) for each in zip(drawn, further, strict=True)]
            times *= 2
        evaluations = sum(each.evaluations for each in moved)
        for part in parts:
            evaluations += (1 + part.proposal.evaluations) * weighted.weights.size // len(parts)
        return estimated(scene, quantities, weighted, precise, faults, evaluations, begin, k)


_points = lru_cache(maxsize=8)(Points)  # thousands of scenes have few sizes


def more_points(size: int, seed: int) -> Points:
    """Several times as many points, and a larger pilot, for where the first ones do not do."""
    return _points(size + TAILS, seed, _THEN_MOST, _THEN_PILOT)


@one_blas_thread()
def answer(scene: Scene, rung: str, seed: int = 0, times: int = 1) -> Estimate:
    """The posterior of a scene by importance sampling: no chains, no predictions, no tree.

    Args:
        scene: scene that is asked about.
        rung: a name in `retrodict.models.RUNGS`.
        seed: integer seed of the search and of the points.
        times: factor by which there may be more points, a power of two.

    Returns:
        The estimate; its checks say whether it can be relied on.

    Raises:
        Unanswerable: as of `solutions`.
    """
    begin = time.perf_counter()
    found = solutions(scene, rung, seed, Coordinates.UNBENT)
    parts = [
        Part(each.posterior, proposal)
        for each in found
        if (proposal := nested(each.posterior)) is not None
    ]
    most = times * _NESTED_MOST
    points = _points(found[0].posterior.size + EXTRA, seed, most, first=_NESTED_FIRST)
    return points.estimate(scene, parts, begin, diagnostics.MIN_ESS)


def too_sharp(posterior: Posterior) -> tuple[str, ...]:
    """A fault where rest poses are sharper than run-outs resolve; else empty."""
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
        scene: scene that the points are of.
        quantities: the model's quantities at each point, by name, SI units and radians.
        weighted: weights of the points.
        precise: precision of the quantities.
        faults: other reasons not to rely on the quantities, in words.
        evaluations: number of density evaluations.
        begin: time when the work began, by `time.perf_counter`, s.
        pareto_k: Pareto k of the importance weights; None where there is none.
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
        flags=diagnostics.flags(draws, predicted, scene, noise=False),
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


def _odds(drawn: list[_Drawn]) -> np.ndarray:
    """Weights of solutions that sum to one; alike where no point has a density."""
    evidence = np.array([log_mean(each.log_weight)[0] for each in drawn])
    return shares(evidence) if np.isfinite(evidence).any() else np.ones(len(drawn)) / len(drawn)


def _weighted(parts: list[Part], drawn: list[_Drawn]) -> tuple[Weighted, tuple[str, ...], float]:
    """Weights of the points of all solutions; faults of the weights, and the worst Pareto k."""
    reasons: list[str] = []
    weights, k = [], []
    for share, each, part in zip(_odds(drawn), drawn, parts, strict=True):
        own, shape = smoothed(each.log_weight)
        weights.append(share * own)
        if share >= SLIGHT:
            k.append(shape)
            reasons += judged(shape)["faults"]
            reasons += too_sharp(part.posterior)
    return Weighted(_side_by_side(weights), SCRAMBLINGS), tuple(reasons), max(k, default=np.inf)


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
    """Precision of the reported quantities of weighted points; arguments as of `estimated`."""
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
        for count, of, it in ((bulk[name], "mean is", "it"), (tail[name], "tails are", "them")):
            if not count >= diagnostics.MIN_ESS:
                faults.append(
                    f"{describe(name)[0]}: its {of} as uncertain as {count:.0f} independent draws "
                    f"would leave {it}, {diagnostics.MIN_ESS:.0f} are asked"
                )
    return Precision(min(bulk.values()), min(tail.values()), tuple(imprecise), tuple(faults))
