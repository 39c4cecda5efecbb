"""Several solutions of one scene: found, weighted by their evidence, and mixed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.fitting import rolling
from retrodict.inference.fitting.about_peak import Prepared, crashes_of, prepared
from retrodict.inference.fitting.posterior import LEAST_WEIGHT, Posterior
from retrodict.inference.fitting.search import Peak
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.outcome import Mode
from retrodict.inference.prior_check import Reference, reference
from retrodict.inference.samplers import METHODS
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
_REACHED = 0.3  # of its share of the posterior: draws nearer another than the mode they began from
_UNSETTLED = 16_000  # draws for the evidence of a solution whose weights do not settle
_SURE = 100.0  # log odds: more of them say no more, and would not be numbers

_OF_DRAWS = ("posterior", "posterior_predictive", "log_likelihood", "sample_stats")


@dataclass(frozen=True)
class Solution:
    """A scene at one number of turns to rest, on one branch.

    Args:
        posterior: of the scene.
        scene: with whole turns added to the rest headings.
        differs: in which bounded quotients other branches that count differ from this.
        mode: its record: weight, turns, and the quantities there.
        peak: about which its coordinates are; None where none was sought.
        others: further peaks of the posterior, which draws should reach.
    """

    posterior: Posterior
    scene: Scene
    differs: tuple[str, ...]
    mode: Mode
    peak: Peak | None = None
    others: tuple[Peak, ...] = ()

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


def solutions(
    scene: Scene,
    rung: str,
    seed: int = 0,
    *,
    solved_back: bool = False,
    known: tuple[np.ndarray, ...] = (),
) -> list[Solution]:
    """The parts that make up a scene's posterior, the likeliest first; arguments as of `prepared`.

    Raises:
        Unanswerable: as of `prepared`.
    """
    parts = prepared(scene, rung, seed=seed, solved_back=solved_back, known=known)
    return [_solution(part, parts) for part in parts]


def _solution(part: Prepared, parts: list[Prepared]) -> Solution:
    branches = [each.posterior.branch for each in parts if each.peak.turns == part.peak.turns]
    differs = tuple(
        name
        for name, side in part.posterior.branch.items()
        if any(branch.get(name, side) != side for branch in branches)
    )
    # weights and values come with the evidence, of those that are kept
    mode = Mode(1.0, 0.0, {}, part.peak.turns)
    return Solution(part.posterior, part.scene, differs, mode, part.peak, part.others)


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
        reference: crashes of the prior, weighted by the evidence.
    """

    found: list[Solution]
    faults: tuple[str, ...]
    reference: Reference

    @property
    def unsampled(self) -> list[UnsampledMode]:
        """Modes that are the centre of no solution, of more weight than LEAST_WEIGHT."""
        return [
            other
            for i, solution in enumerate(self.found)
            for other in unsampled(solution, i)
            if other.odds * solution.mode.weight > LEAST_WEIGHT
        ]


@one_blas_thread()
def posterior_modes(
    scene: Scene, rung: str, seed: int, method: str, known: tuple[np.ndarray, ...] = ()
) -> PosteriorModes:
    """Where a scene's posterior lies on a rung.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`.
        seed: integer seed of the search, and of the draws that weight solutions.
        method: by which it will be drawn from.
        known: as of `prepared`.

    Raises:
        Unanswerable: as of `solutions`.
    """
    if rolling.tempered(scene, rung, method):
        whole = rolling.prepare(scene, rung)
        scene = RUNGS[rung].with_approximations(scene)
        found = [Solution(whole, scene, (), Mode(1.0, 0.0, {}))]
    else:
        solved_back = METHODS[method].solves_back
        found = solutions(scene, rung, seed, solved_back=solved_back, known=known)
    found, unsettled = weighted_by_evidence(found, seed)
    prior = reference(crashes_of(scene, rung), scene.reported(), seed)
    return PosteriorModes(found, _unresolved(found) + unsettled, prior)


class ModeSearch:
    """Where a scene's posterior lies on each rung: sought when first asked, and remembered.

    Args:
        scene: what was measured.
        seed: as of `posterior_modes`.
    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self.scene = scene
        self.seed = seed
        self._found: dict[tuple[str, bool, bool], PosteriorModes] = {}

    def on(self, rung: str, method: str) -> PosteriorModes:
        """Where it lies on a rung; arguments as of `posterior_modes`."""
        tempered = rolling.tempered(self.scene, rung, method)
        place = rung, tempered, METHODS[method].solves_back
        if place not in self._found:
            self._found[place] = posterior_modes(self.scene, rung, self.seed, method)
        return self._found[place]

    def unload_others(self, rung: str) -> None:
        """Give back the memory of the compiled programs of every rung but this."""
        for (other, *_), where in self._found.items():
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


def unsampled(solution: Solution, place: int = 0) -> list[UnsampledMode]:
    """Other modes of a solution's posterior than that which its coordinates are about.

    Args:
        solution: one of several.
        place: of it among these.
    """
    found = []
    for other in solution.others:
        assert solution.peak is not None, "others lie beside a peak"
        odds = np.exp(min(other.log_evidence - solution.peak.log_evidence, _SURE))
        w = solution.posterior.at_deviates(other.u[None])[0]
        found.append(UnsampledMode(place, float(odds), w))
    return sorted(found, key=lambda other: -other.odds)


def shares(log_evidence: np.ndarray) -> np.ndarray:
    """Weights that sum to one."""
    weights = np.exp(log_evidence - log_evidence.max())
    return weights / weights.sum()


def _values_at(posterior: Posterior, w: np.ndarray) -> dict[str, float]:
    """The reported quantities at a point, SI units and radians."""
    quantities = posterior.evaluate(w[None])[1]
    return {name: float(quantities[name][0]) for name in REPORTED if name in quantities}


def _counted(layer: xr.Dataset, first: Mode, mode: Mode) -> xr.Dataset:
    """Predicted rest headings less the whole turns by which a solution is ahead of the first."""
    ahead = {f"rest_heading_{v}": mode.turns[v] - first.turns[v] for v in mode.turns}
    shifted = {k: layer[k] - 2 * np.pi * count for k, count in ahead.items() if k in layer}
    return layer.assign({k: v.assign_attrs(layer[k].attrs) for k, v in shifted.items()})
