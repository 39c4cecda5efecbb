"""Transforms made for a scene: constrained, and whitened by the posterior's scale at a point."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.special import ndtr

from retrodict.inference.density.compiled import Programs
from retrodict.inference.density.kernels import LEVELS
from retrodict.inference.transforms import layout
from retrodict.inference.transforms.parameters import Affine, Constraints, Regressions
from retrodict.inference.transforms.rest_pose import RestPose
from retrodict.inference.transforms.soft_bounds import (
    raised,
    soft_lower_bound_inverse,
    softness_for,
)
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import SLIDING, E

KEPT = 0.2  # softness of the share of the sliding where nothing is known yet: its prior's scale
_NARROW = 1e-4  # least standard deviation of a margin, so that it can be divided by
_LIKELY = 0.1, 0.98  # range of the share of the sliding at which a search begins
_SOFT = 1e-3, 2.0  # range of the softness of the share of the sliding
# entry of q where a half-normal share is likeliest, if it is as soft as constraints are
_RAISED = 0.35

Point = Float[np.ndarray, " q"]
Spread = Float[np.ndarray, "q any"]


def whitened_about(
    programs: Programs,
    data: Data,
    regressions: Regressions,
    centre: Point,
    spread: Spread,
    constrained: Point | None = None,
    side: Float[np.ndarray, " levels"] | None = None,
    kept: float = KEPT,
) -> RestPose:
    """A transform about `centre`, constrained along the cheapest directions of `spread`.

    Args:
        programs: compiled programs of the scene's structure.
        data: the scene's numbers.
        regressions: regressions for A and B that `regression.fit` returns.
        centre: q at w = 0, shape (q,).
        spread: change of q per deviate of the posterior about the centre, shape (q, any).
        constrained: q of the centre after constraints moved it, as far as is known: the constraints are
            linearised there, shape (q,).
        side: signs of the denominators, `Constraints.side`; None for those at `constrained`, except that
            e takes the sign of vehicles that close in, where it is known from which side each does.
        kept: softness of the share of the sliding, `Constraints.kept`.
    """
    structure = programs.structure
    held, empty = layout.held_of(structure), RestPose.example(structure)
    constraints = empty.constraints
    if layout.levels_of(structure):
        constrained = centre if constrained is None else constrained
        constraints, spread = _wall(
            programs, data, regressions, centre, spread, constrained, side, kept
        )
    along, slope = np.asarray(constraints.along)[:held], np.asarray(constraints.slope)[:held]
    spread = _triangular(spread, slope)
    volume = np.linalg.slogdet(np.concatenate([spread, along.T], axis=1))[1]
    whitening = Affine(centre, spread, np.array(volume))
    return RestPose(whitening, regressions, constraints, empty.responses)


def _wall(
    programs: Programs,
    data: Data,
    regressions: Regressions,
    centre: Point,
    spread: Spread,
    constrained: Point,
    side: np.ndarray | None,
    kept: float,
) -> tuple[Constraints, Spread]:
    """The constraints of `whitened_about`, and the spread without its part that changes held levels."""
    structure = programs.structure
    levels, held = layout.levels_of(structure), layout.held_of(structure)
    over, under, *slopes, by_z, sense = map(
        np.asarray, programs(LEVELS, data, regressions, constrained)
    )
    if side is None:
        # vehicles close in, each from its own side, whatever the centre says
        known = [level == E and sense != 0 for level in levels]
        side = np.where(known, sense, np.where(under < 0, -1.0, 1.0))
    share = kept * raised(constrained[-1])  # where that is sampled
    margin = np.array(layout.margins(levels, side, over, under, share))
    over_by_q, under_by_q = slopes
    slope = np.array(layout.margins(levels, side, over_by_q, under_by_q, share))
    along = np.linalg.pinv(slope[:held]).T
    if SLIDING in levels:  # held at a value that is a coordinate, and that is not moved
        at = [level.name for level in levels if level.held].index(SLIDING.name)
        slope[at, -1] = -kept * ndtr(constrained[-1]) * under[levels.index(SLIDING)]
    unbent = margin + slope @ (centre - constrained)
    # the shortest moves to the held levels, as q is in deviates; then also the width of the posterior
    spread = spread - along.T @ (slope[:held] @ spread)
    metric = spread @ spread.T
    # margins that cut off most come first: each is constrained along a direction that leaves the earlier
    # ones unchanged, along which the posterior is far narrower than the margin where two margins meet
    wide = np.maximum(np.linalg.norm(slope @ spread, axis=1), _NARROW)
    order = np.array([*range(held), *(held + np.argsort((unbent / wide)[held:]))], dtype=int)
    margin, unbent, slope, softness = (
        margin[order],
        unbent[order],
        slope[order],
        np.ones(len(order)),
    )
    for i in range(held, len(order)):
        upto = slope[held : i + 1]
        precision = np.linalg.inv(upto @ metric @ upto.T)
        along = np.vstack([along, precision[-1] @ upto @ metric])
        sd = np.maximum(precision[-1, -1] ** -0.5, _NARROW)  # with those before it held
        softness[i] = softness_for(sd, margin[i])
    across = _across(structure, slope, by_z)
    softly = softness, np.array(kept)
    return Constraints(centre, side, order, unbent, slope, along, across, *softly), spread


def sliding(programs: Programs, data: Data, regressions: Regressions, q: Point) -> Point:
    """A point whose share of the sliding, where that is sampled, is set to that of its motion."""
    if not layout.samples_sliding(programs.structure):
        return q
    at = layout.levels_of(programs.structure).index(SLIDING)
    over, under = map(np.asarray, programs(LEVELS, data, regressions, q)[:2])
    q = q.copy()
    q[-1] = soft_lower_bound_inverse(float(np.clip(over[at] / under[at], *_LIKELY)), KEPT) / KEPT
    return q


def softened(
    transform: RestPose, *points: Float[np.ndarray, "q *any"]
) -> tuple[float, list[Float[np.ndarray, "q *any"]]]:
    """Best softness of the share of the sliding at zero, given its mode, and points in that unit.

    Args:
        transform: transform with the present softness, `Constraints.kept`.
        points: mode, shape (q,), then other points or directions there (columns), in the present unit.
    """
    share, before = float(transform.constraints.kept), points[0][-1]
    kept = float(np.clip(share * raised(before) / raised(_RAISED), *_SOFT))
    after = soft_lower_bound_inverse(share * raised(before), kept) / kept
    rate = share * ndtr(before) / (kept * ndtr(after))
    counted = [point.copy() for point in points]
    for point in counted:
        point[-1] = after if point.ndim == 1 else rate * point[-1]
    return kept, counted


def _across(structure: Structure, slope: np.ndarray, by_z: np.ndarray) -> np.ndarray:
    """`Constraints.across`: the shortest changes of the motion that move one margin and none before it.

    Args:
        structure: static structure of the scene.
        slope: derivatives of the margins by q, shape (m, q).
        by_z: derivatives of the velocities of A and B over sqrt(friction) by z, shape (2, v, v).
    """
    n, speed_a = len(structure.rest_components), layout.place_of_speed_a(structure)
    moving = slope[:, [*range(n), *([] if speed_a is None else [speed_a])]]
    ways = [np.linalg.pinv(moving[: i + 1])[:, -1] for i in range(len(moving))]
    way = np.stack(ways, axis=1)
    velocities = np.concatenate(by_z @ way[:n].reshape(2, -1, len(moving)))
    faster = np.zeros((1, len(moving))) if speed_a is None else way[n:]
    return np.concatenate([velocities, faster]).T


def _triangular(spread: Spread, held: np.ndarray) -> Spread:
    """A spread of the same covariance, lower triangular along axes of q on which nothing is held.

    It is found by QR: squaring the spread first would lose half the digits.

    Args:
        spread: spread that changes no held level, shape (q, any).
        held: derivatives of the held levels' margins by q, shape (held, q).
    """
    keep = np.linalg.svd(held)[2][len(held) :].T if len(held) else np.eye(len(spread))
    R = np.linalg.qr((keep.T @ spread).T, mode="r")
    return keep @ (R * np.sign(np.diag(R))[:, None]).T
