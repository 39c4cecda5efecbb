"""Charts made for a scene: bent at walls, and counted in the posterior's spread about a point."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.stats import norm

from retrodict.inference.density.compiled import Programs
from retrodict.inference.transforms import rest_pose
from retrodict.inference.transforms.rest_pose import Chart, Guess, Response, Sheet, Wall
from retrodict.inference.transforms.soft_bounds import raised, softness_for, unlift
from retrodict.inference.transforms.velocity import KEPT
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import SLIDING, E
from retrodict.scene.records import VEHICLES

_NARROW = 1e-4  # of an edge's standard deviation: at least, so that something can be divided by it
_NO_SHEETS = (Sheet(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0, 0))),) * 2
_NO_WALL = Wall(
    *(np.zeros(0), np.zeros(0, int), np.zeros(0)),
    *(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0))),
    *(np.zeros(0), np.ones(())),
)
_LIKELY = 0.1, 0.98  # shares of the sliding that a search begins from
_SOFT = 1e-3, 2.0  # the least and most
_RAISED = 0.35  # entry of q where a half-normal share is likeliest, if it is as soft as walls are

Point = Float[np.ndarray, " q"]
Spread = Float[np.ndarray, "q any"]


def plain(centre: Point, spread: Spread) -> Chart:
    """A chart without sheets or walls: w counts along the spread's columns from the centre."""
    return Chart(_NO_SHEETS, _NO_WALL, centre, spread, np.array(np.linalg.slogdet(spread)[1]), ())


def off(sheets: tuple[Sheet, Sheet], guess: Guess, n: int) -> Chart:
    """A chart of so many coordinates that are offsets, without walls: w is q.

    Args:
        sheets: of the vehicles whose coordinates are the misses of their rest pose.
        guess: of the velocities of the others.
        n: number of coordinates.
    """
    return plain(np.zeros(n), np.eye(n))._replace(sheets=sheets, guess=guess)


def blank(structure: Structure) -> Chart:
    """A chart of the right shapes and no meaning, to compile programs for."""
    n, v = rest_pose.length(structure), len(structure.rests)
    if structure.unpinned:
        return plain(np.zeros(n), np.eye(n))
    sizes = [v + len(rest_pose.shaping_inputs(structure, vehicle)) for vehicle in VEHICLES]
    for_a, for_b = (Sheet(np.zeros(v), np.zeros((v, k)), np.zeros((v, k, k))) for k in sizes)
    if structure.offset:
        return off((for_a, for_b), Guess(np.zeros(2), np.ones((2, 3)), np.zeros(())), n)
    responses = []
    for vehicle in structure.responding:
        m, k = len(structure.on_way_of(vehicle)), sizes[VEHICLES.index(vehicle)]
        surface = Sheet(np.zeros(m), np.zeros((m, k)), np.zeros((m, k, k)))
        responses.append(Response(np.zeros(v), np.ones(v), surface))
    levels = rest_pose.levels_of(structure)
    m = len(rest_pose.edges(levels, np.ones(len(levels)), *np.ones((2, len(levels)))))
    nowhere = np.zeros((m, n))
    across, side = np.zeros((m, 2 * v + 1)), np.ones(len(levels))
    wall = Wall(side, np.arange(m), np.zeros(m), nowhere, nowhere, across, np.ones(m), np.ones(()))
    spread = np.zeros((n, rest_pose.size(structure)))
    return Chart((for_a, for_b), wall, np.zeros(n), spread, np.zeros(()), tuple(responses))


def about(
    programs: Programs,
    data: Data,
    sheets: tuple[Sheet, Sheet],
    centre: Point,
    spread: Spread,
    bent: Point | None = None,
    side: Float[np.ndarray, " levels"] | None = None,
    kept: float = KEPT,
) -> Chart:
    """A chart about `centre`, with walls along the directions cheapest in `spread`; no responses yet.

    Args:
        programs: of the structure.
        data: the scene's numbers.
        sheets: as `sheet.fit` gives them.
        centre: q at w = 0.
        spread: q's change by deviates of the posterior about there.
        bent: where walls take the centre to, as far as is known: they are made for there.
        side: of the walls; that of the centre where not given, but for e that of vehicles closing in,
            where it is known from which side each does.
        kept: as of `Wall`.
    """
    structure = programs.structure
    held, empty = rest_pose.held_of(structure), blank(structure)
    wall = empty.wall
    if rest_pose.levels_of(structure):
        bent = centre if bent is None else bent
        wall, spread = _wall(programs, data, sheets, centre, spread, bent, side, kept)
    along, slope = np.asarray(wall.along)[:held], np.asarray(wall.slope)[:held]
    spread = _triangular(spread, slope)
    volume = np.linalg.slogdet(np.concatenate([spread, along.T], axis=1))[1]
    return Chart(sheets, wall, centre, spread, np.array(volume), empty.responses)


def _wall(
    programs: Programs,
    data: Data,
    sheets: tuple[Sheet, Sheet],
    centre: Point,
    spread: Spread,
    bent: Point,
    side: np.ndarray | None,
    kept: float,
) -> tuple[Wall, Spread]:
    """The walls of `about`, and the spread without what of it changes what is held."""
    structure = programs.structure
    levels, held = rest_pose.levels_of(structure), rest_pose.held_of(structure)
    flat = blank(structure)._replace(sheets=sheets)
    over, under, *slopes, by_z, sense = map(np.asarray, programs("levels", data, flat, bent))
    if side is None:
        # vehicles close in, each from its own side, whatever the centre says
        known = [level == E and sense != 0 for level in levels]
        side = np.where(known, sense, np.where(under < 0, -1.0, 1.0))
    share = kept * raised(bent[-1])  # where that is sampled
    edge = np.array(rest_pose.edges(levels, side, over, under, share))
    over_by_q, under_by_q = slopes
    slope = np.array(rest_pose.edges(levels, side, over_by_q, under_by_q, share))
    along = np.linalg.pinv(slope[:held]).T
    if SLIDING in levels:  # held at a value that is a coordinate, and stays
        at = [level.name for level in levels if level.held].index(SLIDING.name)
        slope[at, -1] = -kept * norm.cdf(bent[-1]) * under[levels.index(SLIDING)]
    unbent = edge + slope @ (centre - bent)
    # the shortest way to what is held, for q counts in deviates; then the posterior's width besides
    spread = spread - along.T @ (slope[:held] @ spread)
    metric = spread @ spread.T
    # those that cut off most first: each is bent along a way that leaves those before it alone,
    # and where two edges meet that is far narrower than the edge is by itself
    wide = np.maximum(np.linalg.norm(slope @ spread, axis=1), _NARROW)
    order = np.array([*range(held), *(held + np.argsort((unbent / wide)[held:]))], dtype=int)
    edge, unbent, slope, softness = edge[order], unbent[order], slope[order], np.ones(len(order))
    for i in range(held, len(order)):
        upto = slope[held : i + 1]
        precision = np.linalg.inv(upto @ metric @ upto.T)
        along = np.vstack([along, precision[-1] @ upto @ metric])
        sd = np.maximum(precision[-1, -1] ** -0.5, _NARROW)  # with those before it held
        softness[i] = softness_for(sd, edge[i])
    across = _across(structure, slope, by_z)
    return Wall(side, order, unbent, slope, along, across, softness, np.array(kept)), spread


def sliding(programs: Programs, data: Data, sheets: tuple[Sheet, Sheet], q: Point) -> Point:
    """A point with the share of the sliding that its motion keeps, where that is sampled."""
    if not rest_pose.samples_sliding(programs.structure):
        return q
    at = rest_pose.levels_of(programs.structure).index(SLIDING)
    flat = blank(programs.structure)._replace(sheets=sheets)
    over, under = map(np.asarray, programs("levels", data, flat, q)[:2])
    q = q.copy()
    q[-1] = unlift(float(np.clip(over[at] / under[at], *_LIKELY)), KEPT) / KEPT
    return q


def softened(
    chart: Chart, *points: Float[np.ndarray, "q *any"]
) -> tuple[float, list[Float[np.ndarray, "q *any"]]]:
    """How soft the share of the sliding best is at zero by where it is likeliest, and points so counted.

    Args:
        chart: as points are counted now.
        points: where it is likeliest, then others or directions there (columns).
    """
    share, before = float(chart.wall.kept), points[0][-1]
    kept = float(np.clip(share * raised(before) / raised(_RAISED), *_SOFT))
    after = unlift(share * raised(before), kept) / kept
    rate = share * norm.cdf(before) / (kept * norm.cdf(after))
    counted = [point.copy() for point in points]
    for point in counted:
        point[-1] = after if point.ndim == 1 else rate * point[-1]
    return kept, counted


def _across(structure: Structure, slope: np.ndarray, by_z: np.ndarray) -> np.ndarray:
    """The shortest ways of the motion that move one edge each and none before it: `Wall.across`.

    Args:
        structure: of the scene.
        slope: of the edges by q, shape (m, q).
        by_z: velocities of A and of B over sqrt(friction) by z, shape (2, v, v).
    """
    n, speed_a = len(structure.aims), rest_pose.place_of_speed_a(structure)
    moving = slope[:, [*range(n), *([] if speed_a is None else [speed_a])]]
    ways = [np.linalg.pinv(moving[: i + 1])[:, -1] for i in range(len(moving))]
    way = np.stack(ways, axis=1)
    velocities = np.concatenate(by_z @ way[:n].reshape(2, -1, len(moving)))
    faster = np.zeros((1, len(moving))) if speed_a is None else way[n:]
    return np.concatenate([velocities, faster]).T


def _triangular(spread: Spread, held: np.ndarray) -> Spread:
    """A spread of the same covariance, lower triangular along axes of q on which nothing is held.

    By QR: squaring the spread first would lose half the digits.

    Args:
        spread: which changes nothing that is held.
        held: slopes of what is held by q, shape (any, q).
    """
    keep = np.linalg.svd(held)[2][len(held) :].T if len(held) else np.eye(len(spread))
    R = np.linalg.qr((keep.T @ spread).T, mode="r")
    return keep @ (R * np.sign(np.diag(R))[:, None]).T
