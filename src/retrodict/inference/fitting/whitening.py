"""Transforms made for a scene: constrained, and whitened by the posterior's scale at a point."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.special import ndtr

from retrodict.inference.density.compiled import Programs
from retrodict.inference.density.kernels import LEVELS
from retrodict.inference.transforms import rest_pose
from retrodict.inference.transforms.parameters import Constraints, Quadratic, TransformParameters
from retrodict.inference.transforms.soft_bounds import (
    raised,
    soft_lower_bound_inverse,
    softness_for,
)
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import SLIDING, E

KEPT = 0.2  # softness of the share of the sliding where nothing is known yet: its prior's scale
_NARROW = 1e-4  # of a margin's standard deviation: at least, so that something can be divided by it
_LIKELY = 0.1, 0.98  # shares of the sliding that a search begins from
_SOFT = 1e-3, 2.0  # the least and most
# entry of q where a half-normal share is likeliest, if it is as soft as constraints are
_RAISED = 0.35

Point = Float[np.ndarray, " q"]
Spread = Float[np.ndarray, "q any"]


def whitened_about(
    programs: Programs,
    data: Data,
    regressions: tuple[Quadratic, Quadratic],
    centre: Point,
    spread: Spread,
    constrained: Point | None = None,
    side: Float[np.ndarray, " levels"] | None = None,
    kept: float = KEPT,
) -> TransformParameters:
    """A transform about `centre`, constrained along the cheapest directions of `spread`.

    Args:
        programs: of the structure.
        data: the scene's numbers.
        regressions: as `regression.fit` gives them.
        centre: q at w = 0.
        spread: q's change by deviates of the posterior about there.
        constrained: where constraints take the centre, as far as is known: they are made for there.
        side: of the constraints; where not given that of the centre, but for e that of vehicles that
            close in, where it is known from which side each does.
        kept: as of `Constraints`.
    """
    structure = programs.structure
    held, empty = rest_pose.held_of(structure), rest_pose.RestPose().example(structure)
    constraints = empty.constraints
    if rest_pose.levels_of(structure):
        constrained = centre if constrained is None else constrained
        constraints, spread = _wall(
            programs, data, regressions, centre, spread, constrained, side, kept
        )
    along, slope = np.asarray(constraints.along)[:held], np.asarray(constraints.slope)[:held]
    spread = _triangular(spread, slope)
    volume = np.linalg.slogdet(np.concatenate([spread, along.T], axis=1))[1]
    return TransformParameters(
        regressions, constraints, centre, spread, np.array(volume), empty.responses
    )


def _wall(
    programs: Programs,
    data: Data,
    regressions: tuple[Quadratic, Quadratic],
    centre: Point,
    spread: Spread,
    constrained: Point,
    side: np.ndarray | None,
    kept: float,
) -> tuple[Constraints, Spread]:
    """The constraints of `about`, and the spread without what of it changes what is held."""
    structure = programs.structure
    levels, held = rest_pose.levels_of(structure), rest_pose.held_of(structure)
    flat = rest_pose.RestPose().example(structure)._replace(regressions=regressions)
    over, under, *slopes, by_z, sense = map(np.asarray, programs(LEVELS, data, flat, constrained))
    if side is None:
        # vehicles close in, each from its own side, whatever the centre says
        known = [level == E and sense != 0 for level in levels]
        side = np.where(known, sense, np.where(under < 0, -1.0, 1.0))
    share = kept * raised(constrained[-1])  # where that is sampled
    margin = np.array(rest_pose.margins(levels, side, over, under, share))
    over_by_q, under_by_q = slopes
    slope = np.array(rest_pose.margins(levels, side, over_by_q, under_by_q, share))
    along = np.linalg.pinv(slope[:held]).T
    if SLIDING in levels:  # held at a value that is a coordinate, and stays
        at = [level.name for level in levels if level.held].index(SLIDING.name)
        slope[at, -1] = -kept * ndtr(constrained[-1]) * under[levels.index(SLIDING)]
    unbent = margin + slope @ (centre - constrained)
    # the shortest way to what is held, for q counts in deviates; then the posterior's width besides
    spread = spread - along.T @ (slope[:held] @ spread)
    metric = spread @ spread.T
    # those that cut off most first: each is constrained along a way that leaves those before it alone,
    # and where two margins meet that is far narrower than the margin is by itself
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
    return Constraints(side, order, unbent, slope, along, across, softness, np.array(kept)), spread


def sliding(
    programs: Programs, data: Data, regressions: tuple[Quadratic, Quadratic], q: Point
) -> Point:
    """A point with the share of the sliding that its motion keeps, where that is sampled."""
    if not rest_pose.samples_sliding(programs.structure):
        return q
    at = rest_pose.levels_of(programs.structure).index(SLIDING)
    flat = rest_pose.RestPose().example(programs.structure)._replace(regressions=regressions)
    over, under = map(np.asarray, programs(LEVELS, data, flat, q)[:2])
    q = q.copy()
    q[-1] = soft_lower_bound_inverse(float(np.clip(over[at] / under[at], *_LIKELY)), KEPT) / KEPT
    return q


def softened(
    transform: TransformParameters, *points: Float[np.ndarray, "q *any"]
) -> tuple[float, list[Float[np.ndarray, "q *any"]]]:
    """How soft the share of the sliding best is at zero by where it is likeliest, and points so counted.

    Args:
        transform: as points are counted now.
        points: where it is likeliest, then others or directions there (columns).
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
    """The shortest changes of the motion that move one margin and none before it: `Constraints.across`.

    Args:
        structure: of the scene.
        slope: of the margins by q, shape (m, q).
        by_z: velocities of A and of B over sqrt(friction) by z, shape (2, v, v).
    """
    n, speed_a = len(structure.rest_components), rest_pose.place_of_speed_a(structure)
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
