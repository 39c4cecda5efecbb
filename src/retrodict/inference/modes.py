"""Several solutions of one scene: found, weighted by their evidence, and mixed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from retrodict.inference.fitting.about_peak import (
    Prepared,
    crashes_of,
    divisor_signs,
    plainest,
    prepared,
)
from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.posterior import LEAST_WEIGHT, Posterior
from retrodict.inference.fitting.search import Peak, peaks
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.outcome import Mode
from retrodict.inference.prior_check import Reference, reference
from retrodict.inference.samplers.importance import Evidence, log_evidence
from retrodict.inference.threads import one_blas_thread
from retrodict.inference.transforms.choice import Coordinates
from retrodict.models.impact import E_M
from retrodict.scene.quantities import REPORTED, SHORT
from retrodict.scene.records import Scene

if TYPE_CHECKING:
    import xarray as xr

    from retrodict.inference.samplers.draws import Draws

# A solution of less weight can move no probability by more, and 400 effective draws leave as much open
# (of a tail of 5 %, 1.1 %): its draws are not judged by themselves.
SLIGHT = 0.01
_UNSETTLED = 16_000  # draws for the evidence of a solution whose weights do not settle

_SPEED = "speed"
_OF_DRAWS = ("posterior", "posterior_predictive", "log_likelihood", "log_prior", "sample_stats")


@dataclass(frozen=True)
class Solution:
    """A part of a scene's posterior: at one number of turns to rest, and about one peak.

    Args:
        posterior: this part of the posterior, in its own coordinates.
        scene: the scene, with whole turns added to the rest headings.
        differs: traits by which other solutions of the same turns differ: names of divisors of another
            sign; "speed" if one has the same signs.
        mode: record of the solution: weight, turns, and the quantities at its mode.
        peak: peak that the coordinates are made about; None where none was sought.
    """

    posterior: Posterior
    scene: Scene
    differs: tuple[str, ...]
    mode: Mode
    peak: Peak | None = None

    @property
    def turns(self) -> dict[str, int]:
        """Whole turns added, of the vehicles whose rotation is unknown."""
        return self.mode.turns

    def label(self) -> str:
        """Description that tells the solution apart: the total rotations to rest, and the branch."""
        labels = []
        for v in self.turns:
            heading = self.scene.rest[v].heading
            assert heading is not None, "only measured headings hide turns"
            turn = heading.value - self.scene.vehicles[v].heading.value
            labels.append(f"{v.upper()} {np.degrees(turn):+.0f} deg")
        if self.peak is not None and E_M.name in self.differs:
            way = "left" if divisor_signs(self.peak)[E_M.name] > 0 else "right"
            labels.append(f"B turned {way} against A by the force alone")
        if _SPEED in self.differs:
            sought = [k for k in ("speed_a", "speed_b") if k in self.scene.question]
            labels += [f"{SHORT[k]} near {self.mode.values[k]:.3g} m/s" for k in sought]
        return ", ".join(labels)


def solutions(
    scene: Scene, rung: str, seed: int = 0, coordinates: Coordinates = Coordinates.DEVIATES
) -> list[Solution]:
    """The parts that make up a scene's posterior, the likeliest first; arguments as of `prepare`.

    Raises:
        Unanswerable: as of `prepare`.
    """
    return ModeSearch(scene, seed).solutions(rung, coordinates)


def _solution(part: Prepared, parts: list[Prepared]) -> Solution:
    alike = [each for each in parts if each.peak.turns == part.peak.turns and each is not part]
    own, theirs = divisor_signs(part.peak), [divisor_signs(each.peak) for each in alike]
    differs = tuple(name for name in own if any(each[name] != own[name] for each in theirs))
    if own in theirs:
        differs = (*differs, _SPEED)
    # until the solution is sampled, its weight is by the Laplace approximation
    weights = shares(np.array([each.peak.log_evidence for each in parts]))
    place = next(i for i, each in enumerate(parts) if each is part)
    values = _reported(part.peak.quantities)
    error = 0.0 if len(parts) == 1 else np.nan
    mode = Mode(float(weights[place]), error, values, part.peak.turns)
    return Solution(part.posterior, part.scene, differs, mode, part.peak)


def weighted_by_evidence(
    found: list[Solution], evidence: list[Evidence]
) -> tuple[list[Solution], list[int], tuple[str, ...]]:
    """Solutions with their weights.

    Args:
        found: the solutions.
        evidence: log evidence of each solution.

    Returns:
        Solutions of more weight than LEAST_WEIGHT; their places among all; and faults of the evidence of
        each solution whose weight counts.
    """
    weights = shares(np.array([e.value for e in evidence]))
    variances = np.array([e.error**2 for e in evidence])
    # of log w_i = log Z_i - log sum Z_j, to first order
    errors = weights * np.sqrt((1 - 2 * weights) * variances + weights**2 @ variances)
    kept = [i for i in np.argsort(-weights, kind="stable") if weights[i] > LEAST_WEIGHT]
    weighed = [_weighted(found[i], weights[i], errors[i]) for i in kept]
    faults = tuple(
        f"{solution.label()}: its weight is not settled: {fault}"
        for i, solution in zip(kept, weighed, strict=True)
        for fault in evidence[i].faults
        if len(kept) > 1 and weights[i] >= SLIGHT
    )
    return weighed, kept, faults


def _weighted(solution: Solution, weight: float, error: float) -> Solution:
    mode = replace(solution.mode, weight=float(weight), error=float(error))
    return replace(solution, mode=mode)


def _settled(posterior: Posterior, seed: int) -> Evidence:
    """The evidence of a posterior, by more draws where its weights do not settle."""
    found = log_evidence(posterior, np.random.default_rng([seed, 2]))
    if found.faults:
        found = log_evidence(posterior, np.random.default_rng([seed, 2]), _UNSETTLED)
    return found


def evidence_of(drawn: Draws) -> Evidence:
    """The log evidence that draws of a solution gave."""
    attributes = drawn.attributes
    return Evidence(attributes["log_evidence"], attributes["log_evidence_sd"], drawn.faults)


def mixed(trees: list[xr.DataTree], modes: list[Mode], seed: int) -> xr.DataTree:
    """Draws of several solutions in one, each as often as its weight asks.

    For every place in the chains a solution is chosen at random by weight, and its draw at that place is
    taken; `sample_stats/mode` says which solution.

    Args:
        trees: draws of each solution, with the same chains.
        modes: weights and turns of the solutions, in the same order; those past the trees are left out.
        seed: integer seed of the random choice of solutions.

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
        layers = [tree[group].to_dataset() for tree, _ in pairs]
        if group == "posterior_predictive":
            layers = [_counted(layer, modes[0], m) for layer, m in zip(layers, modes, strict=True)]
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
    for name in groups.keys() & {*_OF_DRAWS}:
        if all(tree[name].data_vars for tree in trees):
            groups[name] = chosen(name, which)
        else:
            groups[name] = xr.Dataset(attrs=groups[name].attrs)
    if "trajectories" in groups:
        runs = groups["trajectories"].sizes["run"]
        of_runs = xr.DataArray(rng.choice(len(modes), runs, p=weights), dims="run")
        groups["trajectories"] = chosen("trajectories", of_runs)
    groups["sample_stats"] = groups["sample_stats"].assign(mode=which)
    stats = [tree["sample_stats"].attrs for tree, m in pairs if m.weight >= SLIGHT]
    if shapes := [own["pareto_k"] for own in stats if "pareto_k" in own]:
        groups["sample_stats"].attrs["pareto_k"] = max(shapes)
    return xr.DataTree.from_dict({f"/{name}": group for name, group in groups.items()})


@dataclass(frozen=True)
class PosteriorModes:
    """The solutions that make up a scene's posterior on a rung, and what was drawn of them.

    Args:
        found: the solutions.
        faults: reasons not to rely on any draws, in words.
        drawn: draws of a solution, by its place, method, numbers of chains, draws and warm-up, seed and
            multiple of the draws, for another run on the same rung to use again.
        standing: draws without faults, by place of the solution, of a method that had faults elsewhere:
            another method that weighs solutions draws the others alone.
    """

    found: list[Solution]
    faults: tuple[str, ...]
    drawn: dict[tuple[Any, ...], Draws] = field(default_factory=dict, repr=False)
    standing: dict[int, Draws] = field(default_factory=dict, repr=False)

    @property
    def evidence(self) -> list[Evidence]:
        """Log evidence of each solution, where all were drawn by importance sampling; else empty."""
        weighed = {
            place[0]: draws for place, draws in self.drawn.items() if place[1] == "importance"
        }
        if len(weighed) < len(self.found):
            return []
        return [evidence_of(own) for _, own in sorted(weighed.items())]

    @property
    def shared(self) -> bool:
        """Whether several solutions share a density, of which chains may miss parts."""
        return any(solution.posterior.basins is not None for solution in self.found)


class ModeSearch:
    """Search for the solutions of a scene's posterior on each rung; what was found is kept.

    Args:
        scene: scene to be reconstructed.
        seed: integer seed of the search, and of the draws that weight solutions.
    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self.scene = scene
        self.seed = seed
        self._crashes: dict[str, Crashes] = {}
        self._peaks: dict[str, list[Peak]] = {}
        self._references: dict[str, Reference] = {}
        self._found: dict[tuple[str, Coordinates, bool], PosteriorModes] = {}

    @one_blas_thread()
    def on(self, rung: str, coordinates: Coordinates, *, weighted: bool = True) -> PosteriorModes:
        """Solutions of the posterior on a rung.

        Args:
            rung: a name in `retrodict.models.RUNGS`.
            coordinates: coordinates in which the posterior will be drawn from.
            weighted: whether several solutions are weighted by sampling, not by Laplace approximation.

        Raises:
            Unanswerable: as of `prepare`.
        """
        coordinates = self.plainest(rung, coordinates)
        place = rung, coordinates, weighted
        if place not in self._found and not weighted:
            found = self.solutions(rung, coordinates)
            self._found[place] = PosteriorModes(found, _unresolved(found))
        elif place not in self._found:
            where = self.on(rung, coordinates, weighted=False)
            if len(where.found) > 1:
                evidence = where.evidence or [
                    _settled(each.posterior, self.seed) for each in where.found
                ]
                found, _, unsettled = weighted_by_evidence(where.found, evidence)
                where = PosteriorModes(found, where.faults + unsettled)
            self._found[place] = where
        return self._found[place]

    def plainest(self, rung: str, coordinates: Coordinates) -> Coordinates:
        """The coordinates; deviates if rest poses cover none of the posterior; arguments as of `on`."""
        crashes, sought = self._sought(rung)
        return plainest(crashes, self.scene, sought, coordinates, self.seed)

    def solutions(self, rung: str, coordinates: Coordinates) -> list[Solution]:
        """The parts that make up the posterior, not yet weighted; arguments as of `on`."""
        crashes, sought = self._sought(rung)
        parts = prepared(crashes, self.scene, sought, coordinates, self.seed)
        return [_solution(part, parts) for part in parts]

    def _of_model(self, rung: str) -> Crashes:
        if rung not in self._crashes:
            self._crashes[rung] = crashes_of(self.scene, rung)
        return self._crashes[rung]

    def _sought(self, rung: str) -> tuple[Crashes, list[Peak]]:
        crashes = self._of_model(rung)
        if rung not in self._peaks:
            self._peaks[rung] = peaks(crashes, self.seed)
        return crashes, self._peaks[rung]

    def reference(self, rung: str) -> Reference:
        """Crashes of the prior on a rung, weighted by the evidence."""
        if rung not in self._references:
            reported = self.scene.reported()
            self._references[rung] = reference(self._of_model(rung), reported, self.seed)
        return self._references[rung]

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


def shares(log_evidence: np.ndarray) -> np.ndarray:
    """Weights that sum to one."""
    weights = np.exp(log_evidence - log_evidence.max())
    return weights / weights.sum()


def _reported(quantities: dict[str, np.ndarray]) -> dict[str, float]:
    """The reported quantities of a crash, by name."""
    return {name: float(quantities[name]) for name in REPORTED if name in quantities}


def _counted(layer: xr.Dataset, first: Mode, mode: Mode) -> xr.Dataset:
    """Predicted rest headings less the whole turns by which a solution is ahead of the first."""
    ahead = {f"rest_heading_{v}": mode.turns[v] - first.turns[v] for v in mode.turns}
    shifted = {k: layer[k] - 2 * np.pi * count for k, count in ahead.items() if k in layer}
    return layer.assign({k: v.assign_attrs(layer[k].attrs) for k, v in shifted.items()})
