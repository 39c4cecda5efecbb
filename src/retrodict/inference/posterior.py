"""A scene's posterior as a function in good coordinates: density, mode, and the way back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import jax
import numpy as np

from retrodict.inference import coordinates, sheet, unpinned
from retrodict.inference.coordinates import Chart, Sheet, Wall
from retrodict.inference.errors import Unanswerable
from retrodict.inference.programs import BATCH, CHUNK, Programs, in_chunks, programs_for
from retrodict.inference.scout import scouted
from retrodict.inference.squash import softness_for
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure, in_steps, steps_of
from retrodict.models.impact import E_M
from retrodict.scene.records import Scene

RIVAL = 1e-3  # weight from which on another mode counts
RESOLVED = 0.05  # standard deviations of a rest pose: what the run-out's steps may be out by
_MOST_STEPS = 768
_ROLLING_STEPS = 192  # at least: little holds a rolling vehicle back, and its clock runs stiff
_AS_DRAWS = 10  # what the whitening at the mode counts for beside that by draws
_SCOUTS, _CLIMBS, _STILL = 3, 12, 0.05  # crashes to climb from; whitenings; how little a mode moves
# Curvature that whitening takes for real: inputs have a prior of curvature 1, and a direction that is
# much wider than that is a ridge that bends away.
_NARROWEST = 0.3
IMPROBABLE = 20.0  # log density by which another mode may be lower and count
_SPEEDS = np.linspace(-2.0, 2.0, 17)  # deviates of A's speed where it is unknown: 1 to 68 m/s
Potential = Callable[[np.ndarray], tuple[float, np.ndarray]]  # w -> value, gradient
_NO_SHEETS = (Sheet(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0, 0))),) * 2
_NO_WALL = Wall(np.zeros(0), np.zeros(0, int), np.zeros(0), *(np.zeros((0, 0)),) * 3, np.zeros(0))


@dataclass(frozen=True)
class Posterior:
    """A posterior ready to be sampled: near w = 0 it is close to a standard normal.

    Args:
        programs: compiled functions, among them the density and its gradient.
        data: the scene's numbers.
        chart: the coordinates, centred and whitened at the mode.
        sheet_error: of the fitted sheets for A and B, in standard deviations of the rest pose.
        log_evidence: Laplace's approximation at the mode.
        unresolved: how far the rest poses may be out for want of steps, in standard deviations.
    """

    programs: Programs
    data: Data
    chart: Chart
    sheet_error: np.ndarray
    log_evidence: float
    unresolved: float

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.chart.spread.shape[1]

    @property
    def turned_by_force(self) -> str:
        """Which way the force alone would turn B against A: the branch, where e_m is bounded."""
        levels = coordinates.levels_of(self.programs.structure)
        sides = dict(zip(levels, self.chart.wall.side, strict=False))
        return {1.0: "left", -1.0: "right"}.get(float(sides.get(E_M, 0.0)), "")

    @cached_property
    def potential(self) -> Potential:
        """Minus the log density, and its gradient, at w."""
        return _potential(self.programs, self.data, self.chart)

    def log_density(self, w: np.ndarray) -> np.ndarray:
        """The log density at many points at once; w has shape (any, q)."""
        return self.weighed(w)[0]

    def about(self, w: np.ndarray) -> Posterior:
        """The same posterior in coordinates whitened by draws of it; where charts are plain only.

        Args:
            w: the draws, shape (any, q).
        """
        spread = np.asarray(self.chart.spread)
        # a little of the spread as it was, lest few draws should make it flat
        covariance = (w.shape[0] * np.cov(w.T) + _AS_DRAWS * np.eye(self.size)) / (
            w.shape[0] + _AS_DRAWS
        )
        centre = np.asarray(self.chart.centre) + spread @ w.mean(axis=0)
        return replace(self, chart=plain(centre, spread @ np.linalg.cholesky(covariance)))

    def seen_from(self, other: Posterior, w: np.ndarray) -> np.ndarray:
        """Points in the coordinates of the same posterior about elsewhere; plain charts only.

        Args:
            other: whose coordinates are asked for.
            w: points in these coordinates, shape (any, q).
        """
        q = np.asarray(self.chart.centre) + w @ np.asarray(self.chart.spread).T
        off = q - np.asarray(other.chart.centre)
        return np.linalg.solve(np.asarray(other.chart.spread), off.T).T

    def weighed(self, w: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """`log_density`; and the model's unknowns and what follows from them, at the same points."""
        return in_chunks(lambda w: self.programs("weigh", self.data, self.chart, w), w)


def prepare(scene: Scene, rung: str) -> Posterior:
    """The first of `branches`: all of a posterior that has one, and else the likeliest part.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`.

    Raises:
        Unanswerable: a measured rest pose cannot be reached, or the density has no finite mode.
    """
    return branches(scene, rung)[0]


def branches(scene: Scene, rung: str) -> list[Posterior]:
    """A scene's posterior under a rung, in coordinates made for it: the parts that make it up.

    e_m is the relative spin after the impact over that which the force alone would have made, and lies
    between -1 and 1. The second is therefore larger than the first, and has either sign: two branches,
    which touch only where both vanish. Rest poses as coordinates reach one.

    Args:
        scene: what was measured.
        rung: a name in `retrodict.models.RUNGS`.

    Returns:
        A posterior for each branch that counts, the likeliest first.

    Raises:
        Unanswerable: a measured rest pose cannot be reached, or the density has no finite mode.
    """
    structure, data = RUNGS[rung].of_scene(scene)
    return [_unpinned(structure, data)] if structure.unpinned else _whitened(structure, data)


def _unpinned(structure: Structure, data: Data) -> Posterior:
    """The posterior about its mode in the coordinates of `unpinned`, sought from several crashes."""
    if structure.rolling:
        steps = max(steps_of(structure, data), _ROLLING_STEPS)
        structure, data = in_steps(structure, data, steps)
    score, told = scouted(programs_for(structure), data)
    starts = [
        unpinned.near(structure, data, {name: values[i] for name, values in told.items()})
        for i in np.argsort(-score)[:_SCOUTS]
    ]
    while True:
        programs = programs_for(structure)
        value, chart = min((_climbed(programs, data, q) for q in starts), key=lambda at: at[0])
        posterior = Posterior(programs, data, chart, np.zeros(2), -value, 0.0)
        posterior = replace(posterior, unresolved=unresolved(posterior))
        steps = steps_of(structure, data)
        if posterior.unresolved <= RESOLVED or steps >= _MOST_STEPS:
            return posterior
        structure, data = in_steps(structure, data, 2 * steps)
        starts = [np.asarray(chart.centre)]


def _climbed(programs: Programs, data: Data, q: np.ndarray) -> tuple[float, Chart]:
    """The mode above q: the potential there, and coordinates whitened about it."""
    value, spread = np.inf, np.eye(q.size)
    for _ in range(_CLIMBS):
        chart = plain(q, spread)
        spread = spread @ _spread_at(programs, data, chart, np.zeros(q.size), _NARROWEST)
        chart = plain(q, spread)
        mode, value = _mode(programs, data, chart)
        q = q + spread @ mode
        if not (np.isfinite(spread).all() and np.isfinite(q).all()):
            raise Unanswerable("the posterior's curvature is not finite near the measured scene")
        if np.linalg.norm(mode) < _STILL:
            break
    return value, plain(q, spread)


def unresolved(posterior: Posterior) -> float:
    """How far finer steps would move what is predicted of likely crashes, in standard deviations."""
    programs, data, s = posterior.programs, posterior.data, posterior.programs.structure

    def likely(count: int) -> dict[str, np.ndarray]:
        w = np.random.default_rng(0).standard_normal((count, posterior.size))
        return posterior.weighed(w)[1]

    if not s.marks:
        return sheet.unresolved(programs, data, run_outs_of(likely(BATCH))) if s.rested else 0.0
    told = likely(CHUNK)
    finer, finely = in_steps(s, data, 4 * steps_of(s, data))
    names, _ = jax.eval_shape(partial(unpinned.locate, s), data, posterior.chart.centre)
    again = programs_for(finer)("simulate", finely, {k: told[k] for k in names})
    moved = [
        (again[f"predicted/{k}"] - told[f"predicted/{k}"]) / data.evidence[k][1]
        for k in s.evidence
        if k.startswith(("rest_", "mark_"))
    ]
    return float(np.quantile(np.abs(moved), 0.9))


def run_outs_of(told: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Velocities after the impact, and deviates of the inputs, of crashes; a row for each."""
    V = np.stack([told[k] for of_one in parts.AFTER for k in of_one if k in told], axis=1)
    return V, told.get("measured", np.zeros((len(V), 0)))


def plain(centre: np.ndarray, spread: np.ndarray) -> Chart:
    """A chart without sheets or walls: w counts along the spread's columns from the centre."""
    return Chart(_NO_SHEETS, _NO_WALL, centre, spread, np.array(np.linalg.slogdet(spread)[1]))


def _whitened(structure: Structure, data: Data) -> list[Posterior]:
    """The posterior on each branch that counts, the likeliest first, with as many steps as it takes."""
    # no more steps of the run-out than this scene's measurements can tell apart
    while True:
        programs = programs_for(structure)
        separation = sheet.shoot(programs, data)
        sheets, error, run_outs = sheet.fit(programs, data, separation)
        unresolved = sheet.unresolved(programs, data, run_outs)
        steps = steps_of(structure, data)
        if unresolved <= RESOLVED or steps >= _MOST_STEPS:
            break
        structure, data = in_steps(structure, data, 2 * steps)
    n = coordinates.length(structure)
    charts = [_chart(programs, data, sheets, q, np.eye(n)) for q in _starts(structure)]
    chart = _likeliest(programs, data, charts)
    first = Posterior(programs, data, chart, error, -np.inf, unresolved)
    found: list[Posterior] = []
    refusals = []
    for start in _starts_on_branches(first):
        if any(_branch(start) == _branch(other) for other in found):
            continue
        # the potential at a mode, whatever the volume that its coordinates count in
        peaks = [float(at.chart.log_volume) - at.log_evidence for at in found]
        try:
            mode = _about_mode(start, min(peaks, default=np.inf) + IMPROBABLE)
        except Unanswerable as refusal:
            refusals.append(refusal)
            continue
        if all(_branch(mode) != _branch(other) for other in found):
            found.append(mode)
    if not found:
        raise refusals[0]
    found = sorted(found, key=lambda posterior: -posterior.log_evidence)
    return [at for at in found if at.log_evidence > found[0].log_evidence + np.log(RIVAL)]


def _branch(posterior: Posterior) -> tuple[float, ...]:
    """Which branch coordinates are of: the signs of what e and e_m are quotients by."""
    return tuple(posterior.chart.wall.side)


def _starts_on_branches(posterior: Posterior) -> Iterator[Posterior]:
    """As it is, then about where e_m is within its bounds on the other branch, if it is left open."""
    yield posterior
    programs, data, chart = posterior.programs, posterior.data, posterior.chart
    levels = coordinates.levels_of(programs.structure)
    if E_M not in levels:
        return
    other = np.where([level == E_M for level in levels], -1, 1) * np.asarray(chart.wall.side)
    centre, anyhow = np.asarray(chart.centre), np.eye(chart.centre.size)
    wall = _chart(programs, data, chart.sheets, centre, anyhow, side=other).wall
    # to where each edge is at least as far above zero as it is soft
    move = np.linalg.pinv(wall.slope) @ np.maximum(wall.softness - wall.edge, 0)
    about = _chart(programs, data, chart.sheets, centre + move, anyhow, side=other)
    yield replace(posterior, chart=about)


def _about_mode(posterior: Posterior, most: float) -> Posterior:
    """The posterior in coordinates about the mode near their centre.

    Raises:
        Unanswerable: there is none, or its potential is above `most`.
    """
    programs, data, chart = posterior.programs, posterior.data, posterior.chart
    # walls and whitening depend on the mode and it on them: thrice is enough
    for _ in range(3):
        mode, value = _mode(programs, data, chart)
        if value + chart.log_volume > most:
            raise Unanswerable("this mode is too improbable to count")
        (_, bent), _ = programs("potential", mode, data, chart)
        bent, centre = np.asarray(bent), np.asarray(chart.centre) + np.asarray(chart.spread) @ mode
        spread = np.asarray(chart.spread) @ _spread_at(programs, data, chart, mode)
        if not (np.isfinite(spread).all() and np.isfinite(bent).all()):
            raise Unanswerable("the posterior's curvature is not finite near the measured scene")
        side = np.asarray(chart.wall.side)
        chart = _chart(programs, data, chart.sheets, centre, spread, bent, side)
    return replace(posterior, chart=chart, log_evidence=-value)


def blank_chart(structure: Structure) -> Chart:
    """A chart of the right shapes and no meaning, to compile programs for."""
    v = len(structure.rests)
    if structure.unpinned:
        n = coordinates.length(structure)
        return plain(np.zeros(n), np.eye(n))
    sizes = [v + len(coordinates.shaping_inputs(structure, vehicle)) for vehicle in "ab"]
    sheets = [coordinates.Sheet(np.zeros(v), np.zeros((v, k)), np.zeros((v, k, k))) for k in sizes]
    n, levels = coordinates.length(structure), coordinates.levels_of(structure)
    m = 2 * len(levels) - coordinates.held_of(structure)
    nowhere = np.zeros((m, n))
    across, side = np.zeros((m, 2 * v + 1)), np.ones(len(levels))
    wall = Wall(side, np.arange(m), np.zeros(m), nowhere, nowhere, across, np.ones(m))
    spread = np.zeros((n, coordinates.size(structure)))
    return Chart((sheets[0], sheets[1]), wall, np.zeros(n), spread, np.zeros(()))


def _chart(
    programs: Programs,
    data: Data,
    sheets: tuple,
    centre: np.ndarray,
    spread: np.ndarray,
    bent: np.ndarray | None = None,
    side: np.ndarray | None = None,
) -> Chart:
    """Coordinates about `centre`, with walls along the directions cheapest in `spread`.

    Args:
        programs: of the structure.
        data: the scene's numbers.
        sheets: as `sheet.fit` gives them.
        centre: q at w = 0.
        spread: q's change by deviates of the posterior about there, shape (q, any).
        bent: where walls take the centre to, as far as is known: they are made for there.
        side: of the walls; that of the centre where not given.
    """
    chart = blank_chart(programs.structure)._replace(sheets=sheets)
    levels = coordinates.levels_of(programs.structure)
    held = coordinates.held_of(programs.structure)
    G, along, wall = np.zeros((0, centre.size)), np.zeros((0, centre.size)), chart.wall
    if levels:
        bent = centre if bent is None else bent
        over, under, *slopes, by_z = map(np.asarray, programs("levels", data, chart, bent))
        side = np.where(under < 0, -1.0, 1.0) if side is None else side
        edge = np.array(coordinates.edges(levels, side, over, under))
        G = np.array(coordinates.edges(levels, side, *slopes))
        along = np.linalg.pinv(G[:held]).T  # the shortest way, for q counts in deviates
        spread = spread - along.T @ (G[:held] @ spread)
        metric = spread @ spread.T
        # those that cut off most first: each is bent along a way that leaves those before it alone,
        # and where two edges meet that is far narrower than the edge is by itself
        unbent = edge + G @ (centre - bent)
        wide = np.maximum(np.linalg.norm(G @ spread, axis=1), 1e-4)
        order = np.array([*range(held), *(held + np.argsort((unbent / wide)[held:]))], dtype=int)
        edge, unbent, G, softness = edge[order], unbent[order], G[order], np.ones(len(G))
        for i in range(held, len(G)):
            upto = G[held : i + 1]
            precision = np.linalg.inv(upto @ metric @ upto.T)
            along = np.vstack([along, precision[-1] @ upto @ metric])
            sd = np.maximum(precision[-1, -1] ** -0.5, 1e-4)  # with those before it held
            softness[i] = softness_for(sd, edge[i])
        across = _across(programs.structure, G, by_z)
        wall = Wall(side, order, unbent, G, along, across, softness)
    # along axes of q where nothing is held; lower triangular, by QR: squaring the spread first would
    # lose half the digits
    keep = np.linalg.svd(G[:held])[2][held:].T if held else np.eye(centre.size)
    R = np.linalg.qr((keep.T @ spread).T, mode="r")
    spread = keep @ (R * np.sign(np.diag(R))[:, None]).T
    volume = np.linalg.slogdet(np.concatenate([spread, along[:held].T], axis=1))[1]
    return Chart(sheets, wall, centre, spread, np.array(volume))


def _across(structure: Structure, G: np.ndarray, by_z: np.ndarray) -> np.ndarray:
    """The shortest ways of the motion that move one edge each and none before it: `Wall.across`.

    Args:
        structure: of the scene.
        G: gradients of the edges by q, shape (m, q).
        by_z: velocities of A and of B over sqrt(friction) by z, shape (2, v, v).
    """
    n, speed_a = len(structure.aims), coordinates.place_of_speed_a(structure)
    G = G[:, [*range(n), *([] if speed_a is None else [speed_a])]]
    way = np.stack([np.linalg.pinv(G[: i + 1])[:, -1] for i in range(len(G))], axis=1)
    velocities = np.concatenate(by_z @ way[:n].reshape(2, -1, len(G)))
    faster = np.zeros((1, len(G))) if speed_a is None else way[n:]
    return np.concatenate([velocities, faster]).T


def _starts(structure: Structure) -> list[np.ndarray]:
    """Where a mode may be sought from: all as measured, and A's speed anywhere if it was not."""
    middle = np.zeros(coordinates.length(structure))
    if ("speed_a", "halfnormal") not in structure.uncertain:
        return [middle]
    unknown = len(structure.aims) + structure.names.index("speed_a")
    return [middle + deviate * (np.arange(middle.size) == unknown) for deviate in _SPEEDS]


def _likeliest(programs: Programs, data: Data, charts: list[Chart]) -> Chart:
    """The chart at whose centre the density is the highest."""
    if len(charts) == 1:
        return charts[0]
    nowhere = np.zeros(coordinates.size(programs.structure))
    heights = [_potential(programs, data, chart)(nowhere)[0] for chart in charts]
    return charts[int(np.argmin(np.nan_to_num(heights, nan=np.inf)))]


def _mode(programs: Programs, data: Data, chart: Chart) -> tuple[np.ndarray, float]:
    from scipy.optimize import minimize  # slow to import, and compilers are at work by now

    at = _potential(programs, data, chart)

    def potential(w: np.ndarray) -> tuple[float, np.ndarray]:
        value, gradient = at(w)
        if not np.isfinite(value):
            return 1e10 + 1e8 * float(w @ w), 2e8 * w
        return value, np.nan_to_num(gradient)

    best = minimize(
        potential,
        np.zeros(chart.spread.shape[1]),
        jac=True,
        method="BFGS",
        options={"gtol": 1e-3, "maxiter": 400},
    )
    if best.fun > 1e9:
        raise Unanswerable("the posterior has no finite density near the measured scene")
    return best.x, float(best.fun)


def _potential(programs: Programs, data: Data, chart: Chart) -> Potential:
    """The potential and its gradient as a function of w alone.

    Numbers go over to JAX once here; at every call they would cost as much as the gradient does.
    """
    data, chart = jax.device_put((data, chart))

    def at(w: np.ndarray) -> tuple[float, np.ndarray]:
        (value, _), gradient = programs("potential", w, data, chart)
        return float(value), np.asarray(gradient)

    return at


def hessian(potential: Potential, w: np.ndarray) -> np.ndarray:
    """Of a potential at w, by differences of its gradient; zero where that is no number."""
    h = 0.05
    steps = h * np.eye(w.size)
    rows = np.array([potential(w + s)[1] - potential(w - s)[1] for s in steps]) / (2 * h)
    return np.nan_to_num((rows + rows.T) / 2)


def _spread_at(
    programs: Programs, data: Data, chart: Chart, mode: np.ndarray, least: float = 1e-2
) -> np.ndarray:
    """Square root of the inverse Hessian at the mode, by differences of the compiled gradient."""
    values, vectors = np.linalg.eigh(hessian(_potential(programs, data, chart), mode))
    return vectors @ np.diag(1 / np.sqrt(np.clip(values, least, 1e4))) @ vectors.T
