"""Several solutions of one scene: found, weighted by their evidence, and mixed."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.errors import Unanswerable
from retrodict.inference.fitting import rolling
from retrodict.inference.fitting.optimise import spread
from retrodict.inference.fitting.posterior import (
    FLAT,
    IMPROBABLE,
    LEAST_WEIGHT,
    Posterior,
    branches,
)
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.outcome import Mode
from retrodict.inference.samplers.draws import Progress
from retrodict.inference.samplers.importance import Evidence, log_evidence
from retrodict.inference.threads import one_blas_thread
from retrodict.models import RUNGS
from retrodict.scene.quantities import REPORTED
from retrodict.scene.records import Scene

if TYPE_CHECKING:
    import xarray as xr

# A solution of less weight can move no probability by more, and 400 effective draws leave as much open
# (of a tail of 5 %, 1.1 %): its draws are not judged by themselves.
SLIGHT = 0.01
_TURNS = range(-4, 5)  # whole turns that a rest heading of unknown rotation may hide
_MOST_TRIED = 18  # numbers of turns for each vehicle: about so many are, before none is left to try
_SHARPEST = 0.1, np.radians(2)  # standard deviations of a rest pose, m and rad
_STARTS = np.geomspace(2, 8, 16)  # standard deviations of the starts from which modes are sought
_APART = 3.0  # standard deviations: nearer than this it is the same mode
_REACHED = 0.3  # of its share of the posterior: draws nearer another than the mode they began from
_UNSETTLED = 16_000  # draws for the evidence of a solution whose weights do not settle
_SURE = 100.0  # log odds: more of them say no more, and would not be numbers
_STILL = 1.0  # slope per standard deviation below which a search has arrived

_OF_DRAWS = ("posterior", "posterior_predictive", "log_likelihood", "sample_stats")


@dataclass(frozen=True)
class Solution:
    """A scene at one number of turns to rest, on one branch.

    Args:
        posterior: of the scene.
        scene: with whole turns added to the rest headings.
        differs: in which bounded quotients other branches that count differ from this.
        mode: its record: weight, turns, and the quantities there.
    """

    posterior: Posterior
    scene: Scene
    differs: tuple[str, ...]
    mode: Mode

    @property
    def turns(self) -> dict[str, int]:
        """Whole turns added, of the vehicles whose rotation is unknown."""
        return self.mode.turns

    def whitened_by(self, w: np.ndarray) -> Solution:
        """The same in coordinates about draws of it, shape (chains, draws, q), where these may move."""
        return replace(self, posterior=self.posterior.whitened_by(w.reshape(-1, w.shape[-1])))

    def label(self) -> str:
        """What sets it apart, in words: the total rotations to rest, and the branch."""
        labels = []
        for v in self.turns:
            heading = self.scene.rest[v].heading
            assert heading is not None, "only measured headings hide turns"
            turn = heading.value - self.scene.vehicles[v].heading.value
            labels.append(f"{v.upper()} {np.degrees(turn):+.0f} deg")
        if "e_m" in self.differs:
            way = "left" if self.posterior.branch["e_m"] > 0 else "right"
            labels.append(f"B turned {way} against A by the force alone")
        return ", ".join(labels)


def solutions(scene: Scene, rung: str, progress: Progress | None = None) -> list[Solution]:
    """The scene at every number of turns that fits, and on every branch.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`.
        progress: called with how many numbers of turns were tried, of all that will be.

    Returns:
        Those that Laplace's approximation does not make out to be IMPROBABLE, the best first.

    Raises:
        Unanswerable: no number of turns leads to the rest poses, or none has a finite mode.
    """
    items = scene.evidence() if RUNGS[rung].explains("rest_heading_a") else {}
    unknown = [
        v for v in scene.vehicles if f"rest_heading_{v}" in items and not scene.rest[v].turns_known
    ]
    if not unknown:
        return _on_branches(scene, rung, {})
    tried: dict[tuple[int, ...], list[Solution]] = {}
    blurred = _blurred(scene)

    def at(scene: Scene, turns: tuple[int, ...]) -> list[Solution]:
        added = dict(zip(unknown, turns, strict=True))
        try:
            return _on_branches(turned(scene, added), rung, added)
        except Unanswerable:
            return []

    def evidence(turns: tuple[int, ...]) -> float:
        if turns not in tried:
            tried[turns] = at(blurred, turns)
            if progress:
                progress(len(tried), max(_MOST_TRIED * len(unknown), len(tried) + 1))
        return max((s.posterior.log_evidence for s in tried[turns]), default=-np.inf)

    # one vehicle after the other, then from all that are likely to their neighbours: every pair would
    # take minutes
    best = (0,) * len(unknown)
    for i in range(len(unknown)):
        best = max(((*best[:i], count, *best[i + 1 :]) for count in _TURNS), key=evidence)
    while True:
        known = {turns: evidence(turns) for turns in tried}
        likely = [
            turns for turns, value in known.items() if value > max(known.values()) - IMPROBABLE
        ]
        untried = {turns for each in likely for turns in _neighbours(each)} - set(tried)
        if not untried:
            break
        for turns in sorted(untried):
            evidence(turns)
    found = _probable(solution for some in tried.values() for solution in some)
    if blurred is not scene:
        counts = dict.fromkeys(tuple(solution.turns.values()) for solution in found)
        found = _probable(solution for turns in counts for solution in at(scene, turns))
    if not found:
        branches(scene, rung)  # raises the reason
    return found


def _neighbours(turns: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """Numbers of turns that differ by one at most, in range."""
    return itertools.product(*({t - 1, t, t + 1} & set(_TURNS) for t in turns))


def _probable(found: Iterable[Solution]) -> list[Solution]:
    """Those that Laplace's approximation does not make out to be IMPROBABLE, the best first."""
    every = sorted(found, key=lambda s: -s.posterior.log_evidence)
    return [
        s for s in every if s.posterior.log_evidence > every[0].posterior.log_evidence - IMPROBABLE
    ]


def _blurred(scene: Scene) -> Scene:
    """A scene to distinguish numbers of turns by: no rest pose is sharper than `_SHARPEST`.

    The sharper rest poses are, the more steps run-outs take, and there are many turns to try. What
    a blurred pose leaves improbable a sharp one does too.
    """
    rest = {}
    for v, pose in scene.rest.items():
        sharpest = {"x": _SHARPEST[0], "y": _SHARPEST[0], "heading": _SHARPEST[1]}
        parts = {name: getattr(pose, name) for name in sharpest}
        rest[v] = replace(
            pose,
            **{k: replace(m, sd=max(m.sd, sharpest[k])) for k, m in parts.items() if m is not None},
        )
    return scene if rest == scene.rest else replace(scene, rest=rest)


def _on_branches(scene: Scene, rung: str, turns: dict[str, int]) -> list[Solution]:
    found = branches(scene, rung)
    scene = RUNGS[rung].with_approximations(scene)
    differs = tuple(name for name in found[0].branch if len({at.branch[name] for at in found}) > 1)
    # weights and values come with the evidence, of those that are kept
    return [Solution(posterior, scene, differs, Mode(1.0, 0.0, {}, turns)) for posterior in found]


def weighted_by_evidence(
    found: list[Solution], seed: int
) -> tuple[list[Solution], tuple[str, ...]]:
    """Solutions with their weights, by the evidence that importance sampling finds.

    Args:
        found: the solutions.
        seed: of the draws.

    Returns:
        Solutions of more weight than LEAST_WEIGHT, and those that may be since their weight does not
        settle; and faults where one does not.
    """
    if len(found) == 1:
        return [_weighted(found[0], 1.0, 0.0)], ()
    known = [(s, _settled(s.posterior, seed)) for s in found]
    least = max(e.value for _, e in known) + np.log(LEAST_WEIGHT)
    known = [(s, e) for s, e in known if e.value > least or e.faults]
    found, evidence = [s for s, _ in known], [e for _, e in known]
    weights = shares(np.array([e.value for e in evidence]))
    variances = np.array([e.error**2 for e in evidence])
    # of log w_i = log Z_i - log sum Z_j, to first order
    relative = np.sqrt((1 - 2 * weights) * variances + weights**2 @ variances)
    faults = tuple(
        f"{s.label()}: its weight is not settled: {fault}"
        for s, e in zip(found, evidence, strict=True)
        for fault in e.faults
    )
    found = [_weighted(s, w, w * r) for s, w, r in zip(found, weights, relative, strict=True)]
    return found, faults


def _weighted(solution: Solution, weight: float, error: float) -> Solution:
    values = _values_at(solution.posterior, np.zeros(solution.posterior.size))
    mode = replace(solution.mode, weight=float(weight), error=float(error), values=values)
    return replace(solution, mode=mode)


def _settled(posterior: Posterior, seed: int) -> Evidence:
    """The evidence of a posterior, by more draws where its weights do not settle."""
    found = log_evidence(posterior, np.random.default_rng([seed, 2]))
    if found.faults:
        found = log_evidence(posterior, np.random.default_rng([seed, 2]), _UNSETTLED)
    return found


def mixed(trees: list[xr.DataTree], modes: list[Mode], seed: int) -> xr.DataTree:
    """Draws of several solutions in one, each as often as its weight asks.

    Every draw is taken at its place in the chains of the solution that chance gives it, and
    `sample_stats/mode` says which.

    Args:
        trees: draws of each solution, with the same chains.
        modes: their weights and turns, in the same order; what follows them is left out.
        seed: of the chance.

    Returns:
        One tree; its rest headings are counted as those of the first solution.
    """
    import xarray as xr

    if len(trees) == 1:
        return trees[0]
    sizes = trees[0]["posterior"].sizes
    draws = min(tree["posterior"].sizes["draw"] for tree in trees)
    rng = np.random.default_rng([seed, 3])

    def chosen(group: str, which: xr.DataArray) -> xr.Dataset:
        layers = [_counted(tree[group].to_dataset(), modes[0], m) for tree, m in pairs]
        steps = min((layer.sizes["step"] for layer in layers if "step" in layer.sizes), default=0)
        if steps:  # solutions may be run out in different steps
            layers = [
                layer.isel(step=np.linspace(0, layer.sizes["step"] - 1, steps).astype(int))
                for layer in layers
            ]
        cut = {str(dim): size for dim, size in which.sizes.items()}
        layers = [layer.isel({dim: slice(size) for dim, size in cut.items()}) for layer in layers]
        places = {dim: xr.DataArray(np.arange(size), dims=dim) for dim, size in cut.items()}
        stacked = xr.concat(layers, "which", combine_attrs="override")
        return stacked.isel({"which": which, **places})

    modes = modes[: len(trees)]
    pairs = list(zip(trees, modes, strict=True))
    weights = np.array([m.weight for m in modes])
    weights /= weights.sum()
    shape = (sizes["chain"], draws)
    which = xr.DataArray(rng.choice(len(modes), shape, p=weights), dims=("chain", "draw"))
    groups = {name: tree.to_dataset() for name, tree in trees[0].children.items()}
    # a method may have no statistics of its draws
    groups |= {name: chosen(name, which) for name in _OF_DRAWS if trees[0][name].data_vars}
    if "trajectories" in groups:
        runs = groups["trajectories"].sizes["run"]
        of_runs = xr.DataArray(rng.choice(len(modes), runs, p=weights), dims="run")
        groups["trajectories"] = chosen("trajectories", of_runs)
    groups["sample_stats"] = groups["sample_stats"].assign(mode=which)
    attrs = [tree["sample_stats"].attrs for tree in trees]
    if "pareto_k" in attrs[0]:
        groups["sample_stats"].attrs["pareto_k"] = max(a["pareto_k"] for a in attrs)
    return xr.DataTree.from_dict({f"/{name}": group for name, group in groups.items()})


@dataclass(frozen=True)
class UnsampledMode:
    """Another mode beside that of a solution, at the same numbers of turns.

    Args:
        of: place of the solution among all.
        odds: its weight over the solution's, by Laplace's approximation.
        w: where it lies in the solution's coordinates.
    """

    of: int
    odds: float
    w: np.ndarray

    def converted_to(self, before: Solution, after: Solution) -> UnsampledMode:
        """The same where its solution has other coordinates than before."""
        if after.posterior is before.posterior:
            return self
        w = before.posterior.converted_to(after.posterior, self.w[None])[0]
        return replace(self, w=w)

    def reached(self, draws: np.ndarray, weights: np.ndarray | None = None) -> bool:
        """Whether draws of the solution hold it.

        Args:
            draws: in the solution's coordinates, shape (any, q).
            weights: of the draws; None where all count the same.
        """
        nearer = np.linalg.norm(draws - self.w, axis=1) < np.linalg.norm(draws, axis=1)
        return float(np.average(nearer, weights=weights)) > _REACHED * self.odds / (1 + self.odds)


@dataclass(frozen=True)
class PosteriorModes:
    """Where a scene's posterior lies on a rung.

    Args:
        found: its solutions.
        faults: for which no draws are to be relied on.
        seed: that it was found by, and that unsampled modes are sought by.
    """

    found: list[Solution]
    faults: tuple[str, ...]
    seed: int

    @cached_property
    def unsampled(self) -> list[UnsampledMode]:
        """Modes that no solution has, of more weight than LEAST_WEIGHT: sought when first asked."""
        return [
            UnsampledMode(i, odds, w)
            for i, solution in enumerate(self.found)
            for odds, w in unsampled(solution.posterior, self.seed)
            if odds * solution.mode.weight > LEAST_WEIGHT
        ]


@one_blas_thread()
def posterior_modes(
    scene: Scene, rung: str, seed: int, method: str, progress: Progress | None = None
) -> PosteriorModes:
    """Where a scene's posterior lies on a rung.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`.
        seed: of the draws that weight solutions, and of the search for unsampled modes.
        method: by which it will be drawn from.
        progress: as of `solutions`.

    Raises:
        Unanswerable: as of `solutions`.
    """
    if rolling.tempered(scene, rung, method):
        whole = rolling.prepare(scene, rung)
        scene = RUNGS[rung].with_approximations(scene)
        found = [Solution(whole, scene, (), Mode(1.0, 0.0, {}))]
    else:
        found = solutions(scene, rung, progress)
    found, unsettled = weighted_by_evidence(found, seed)
    return PosteriorModes(found, _unresolved(found) + unsettled, seed)


class ModeSearch:
    """Where a scene's posterior lies on each rung: sought when first asked, and remembered.

    Args:
        scene: what was measured.
        seed: as of `posterior_modes`.
    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self.scene = scene
        self.seed = seed
        self._found: dict[tuple[str, bool], PosteriorModes] = {}

    def on(self, rung: str, method: str, progress: Progress | None = None) -> PosteriorModes:
        """Where it lies on a rung; arguments as of `posterior_modes`."""
        place = rung, rolling.tempered(self.scene, rung, method)
        if place not in self._found:
            self._found[place] = posterior_modes(self.scene, rung, self.seed, method, progress)
        return self._found[place]

    def unload_others(self, rung: str) -> None:
        """Give back the memory of the compiled programs of every rung but this."""
        for (other, _), where in self._found.items():
            for solution in where.found if other != rung else ():
                solution.posterior.programs.unload()


def _unresolved(found: list[Solution]) -> tuple[str, ...]:
    worst = max(solution.posterior.unresolved for solution in found)
    if worst <= RESOLVED:
        return ()
    return (
        f"the run-outs are resolved to {worst:.2f} standard deviations of the rest poses only, "
        f"{RESOLVED} is asked: a vehicle spins too long for its run-out to be followed",
    )


def all_modes(found: list[Solution], unreached: list[UnsampledMode]) -> list[Mode]:
    """The modes of the solutions, then each unsampled mode that no draw holds.

    Args:
        found: the solutions.
        unreached: the unsampled modes.

    Returns:
        Modes; an unsampled one's weight, and what it takes from its solution's, are Laplace's.
    """
    kept, others = [], []
    for i, solution in enumerate(found):
        near = [other for other in unreached if other.of == i]
        share = solution.mode.weight / (1 + sum(other.odds for other in near))
        kept.append(replace(solution.mode, weight=share))
        for other in near:
            quantities = _values_at(solution.posterior, other.w)
            others.append(Mode(other.odds * share, np.nan, quantities, solution.turns, False))
    return kept + others


def unsampled(posterior: Posterior, seed: int) -> list[tuple[float, np.ndarray]]:
    """Other modes of a posterior than that at w = 0, searched for from far-off starts.

    Args:
        posterior: in coordinates centred at its mode.
        seed: of the starts.

    Returns:
        (odds, w) of each: its weight over that of the mode at w = 0, by Laplace's approximation.
    """
    n = posterior.size
    home = posterior.potential(np.zeros(n))[0]
    found: list[tuple[float, np.ndarray]] = []
    rng = np.random.default_rng([seed, 4])
    starts = _STARTS[:, None] * rng.standard_normal((_STARTS.size, n))

    def arrived(w: np.ndarray) -> bool:
        return bool(np.linalg.norm(w) < _APART)

    for end in posterior.potential.minimise_from(starts, arrived):
        known = [np.zeros(n), *(other for _, other in found)]
        if min(np.linalg.norm(end.w - other) for other in known) < _APART:
            continue
        if end.value - home > IMPROBABLE or np.abs(end.slope).max() > _STILL:
            continue
        between = -posterior.log_density(np.linspace(0.1, 0.9, 9)[:, None] * end.w)
        if between.max() < max(end.value, home) + 1:  # no dip: a ridge, and part of the same mode
            continue
        log_odds = home - end.value + _log_volume(posterior, end.w)
        odds = np.exp(min(log_odds, _SURE))
        if odds > LEAST_WEIGHT:
            found.append((float(odds), end.w))
    return sorted(found, key=lambda other: -other[0])


def shares(log_evidence: np.ndarray) -> np.ndarray:
    """Weights that sum to one."""
    weights = np.exp(log_evidence - log_evidence.max())
    return weights / weights.sum()


def _log_volume(posterior: Posterior, w: np.ndarray) -> float:
    """Log of the volume of a mode at w over that of a standard normal."""
    return float(np.linalg.slogdet(spread(posterior.potential.curvature(w), FLAT))[1])


def _values_at(posterior: Posterior, w: np.ndarray) -> dict[str, float]:
    """The reported quantities at a point, SI units and radians."""
    quantities = posterior.evaluate(w[None])[1]
    return {name: float(quantities[name][0]) for name in REPORTED if name in quantities}


def turned(scene: Scene, turns: dict[str, int]) -> Scene:
    """The scene with whole turns added to rest headings.

    Args:
        scene: what was measured.
        turns: how many to each vehicle's.
    """
    rest = dict(scene.rest)
    for v, count in turns.items():
        heading = rest[v].heading
        assert heading is not None, "only measured headings hide turns"
        heading = replace(heading, value=heading.value + 2 * np.pi * count)
        rest[v] = replace(rest[v], heading=heading)
    return replace(scene, rest=rest)


def _counted(layer: xr.Dataset, first: Mode, mode: Mode) -> xr.Dataset:
    """Predicted rest headings less the whole turns by which a solution is ahead of the first."""
    ahead = {f"rest_heading_{v}": mode.turns[v] - first.turns[v] for v in mode.turns}
    shifted = {k: layer[k] - 2 * np.pi * count for k, count in ahead.items() if k in layer}
    return layer.assign({k: v.assign_attrs(layer[k].attrs) for k, v in shifted.items()})
