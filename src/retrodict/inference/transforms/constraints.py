"""Constraint transforms: q is moved until what the impact model bounds, or holds, is so."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.inference.transforms.layout import (
    friction_scale,
    held_of,
    levels_of,
    margins,
    over,
    place_of_speed_a,
    reduced,
    split,
)
from retrodict.inference.transforms.parameters import (
    Constraints,
    Q,
    Regressions,
    times,
)
from retrodict.inference.transforms.soft_bounds import soft_lower_bound
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import quotients

_UNBENT = 1 - 1e-6  # slope of `soft_lower_bound` from which on a margin bends nothing


class Constrained(NamedTuple):
    """A point moved so that its levels lie within bounds, or at the values at which they are held.

    Args:
        q: point moved along `Constraints.along`, shape (q,).
        motion: further change of the velocities after the impact (m/s and rad/s), then of A's speed
            before it (m/s), shape (v + 1,).
        by_q: change of q that would move the motion as far, shape (q,).
        levels: values of the bounded levels, by name.
        log_det: log |d (motion, inputs) / d q|, where each held level takes the place of the coordinate
            along its direction, less that of the regressions at `q`; minus infinity where the map
            would reach points a second time.
    """

    q: Q
    motion: Float[Array, " v+1"]
    by_q: Q
    levels: parts.Values
    log_det: Float[Array, ""]


def constrain(
    structure: Structure, data: Data, constraints: Constraints, regressions: Regressions, q: Q
) -> Constrained:
    """Move q, then the motion, until each margin is softly above zero, or zero where its level is held.

    A margin well above zero stays as it was and costs nothing: each margin is moved along a direction
    that leaves the margins before it unchanged, and may change those after it. Values are exact, and
    so are the derivatives of the margins; all other derivatives take account of the lengths of the
    moves alone, which is cheap and accurate enough for a gradient that only steers a sampler.
    """
    levels, constraints = levels_of(structure), Constraints(*map(jnp.asarray, constraints))
    held, count = held_of(structure), len(constraints.margin)

    first, aim, share, shift = _constrained_along_q(constraints, held, q - constraints.centre)
    there = q + shift @ constraints.along

    # then change the motion by the small remainder
    x = parts.from_standard(structure, data, split(structure, there)[1])
    scale = friction_scale(structure, data, x)
    velocities, slopes = reduced(structure, data, regressions, there)

    kept = soft_lower_bound(constraints.kept * there[-1], constraints.kept)[
        0
    ]  # where that is sampled

    def moved(motion: Float[Array, " v+1"]) -> Float[Array, " m"]:
        faster = x | {"speed_a": x["speed_a"] + motion[-1]}
        both = quotients(levels, scale * velocities + motion[:-1], faster)
        return jnp.stack(margins(levels, constraints.side, *both, kept=kept))[constraints.order]

    found = moved(jnp.zeros(velocities.size + 1))
    units, slopes = jax.lax.stop_gradient((jnp.full(velocities.size, scale), slopes))
    units = jnp.append(units, jnp.asarray(data.inputs["speed_a"])[1])
    rate = jax.lax.stop_gradient(jax.vmap(moved)(units * constraints.across) - found).T
    rate, ways = _lower_triangular(rate)
    by_q = _by_q(structure, constraints, slopes) @ ways
    linear = constraints.slope @ by_q
    own = jnp.diag(rate)
    log_det, t, bends = -jnp.log(jnp.abs(own)).sum(), jnp.zeros(count), share < _UNBENT
    for i in range(count):
        found = found.at[i].add(rate[i] @ t)
        if i >= held:  # starting at the margin before it was constrained
            above, log_slope = soft_lower_bound(
                first[i] + found[i] - aim[i], constraints.softness[i]
            )
            aim, log_det = aim.at[i].set(above), log_det + log_slope
            bends = bends.at[i].set(bends[i] | (log_slope < jnp.log(_UNBENT)))
        t = t.at[i].set((aim[i] - found[i]) / own[i])
    # the remainder is zero in value, but not in its derivatives, which count where a divisor nears zero
    missed = aim - moved(units * (ways @ t @ constraints.across))
    for i in range(count):
        t = t.at[i].add(missed[i] / own[i])
        missed -= rate[:, i] * missed[i] / own[i]
    # row i without its dependence on t[:i], which is a multiple of the rows before it
    share = jax.lax.stop_gradient(share)[:, None]
    turn = _determinant(share * jnp.diag(own) + (1 - share) * linear)
    log_det += jnp.log(jnp.abs(turn))
    # each rate is 1 at the centre; where one has changed sign, far out, points would be reached a second
    # time. The rate of a margin that bends nothing does not matter
    turned = (bends & (own <= 0)).any() | (turn * jnp.sign(own).prod() <= 0)
    log_det = jnp.where(turned, -jnp.inf, log_det)
    in_place = jnp.zeros(count).at[constraints.order].set(aim)
    bounded = [level for level in levels if not level.held]
    near, far = in_place[held : held + len(bounded)], in_place[held + len(bounded) :]
    nearer, farther = (np.array([getattr(b, end) for b in bounded]) for end in ("near", "far"))
    inside = (nearer * far + farther * near) / (near + far)
    values = {level.name: inside[i] for i, level in enumerate(bounded)}
    return Constrained(there, units * (ways @ t @ constraints.across), by_q @ t, values, log_det)


def _constrained_along_q(
    constraints: Constraints, held: int, off: Q
) -> tuple[Float[Array, " m"], Float[Array, " m"], Float[Array, " m"], Float[Array, " m"]]:
    """Lengths of the moves of q along `Constraints.along`, if margins were linear in q.

    Args:
        constraints: constraints, the held levels first.
        held: number of held levels.
        off: q minus the centre, shape (q,).

    Returns:
        Each margin before its own move, and after it; the derivative of the latter by the former (zero
        where the level is held); and the lengths of the moves.
    """
    count = len(constraints.margin)
    before = jnp.asarray(constraints.margin) + times(constraints.slope, off)
    moves = constraints.slope @ constraints.along.T
    after, slope, shift = jnp.zeros((3, count))
    for i in range(count):
        before = before.at[i].add(moves[i] @ shift)
        if i >= held:
            above, log_slope = soft_lower_bound(before[i], constraints.softness[i])
            after, slope = after.at[i].set(above), slope.at[i].set(jnp.exp(log_slope))
        shift = shift.at[i].set(after[i] - before[i])
    return before, after, slope, shift


def _lower_triangular(rate: Float[Array, "m m"]) -> tuple[Float[Array, "m m"], Float[Array, "m m"]]:
    """Combine directions so that each leaves unchanged the margins before its own.

    Args:
        rate: rate of change of each margin (row) along each direction (column), shape (m, m).

    Returns:
        The rates of the combined directions, lower triangular; and the coefficients of the given
        directions (rows) in each combined one (columns).
    """
    m = len(rate)
    both = jnp.concatenate([rate, jnp.eye(m)])
    for i in range(m - 1):
        later = jnp.where(np.arange(m) > i, both[i] / both[i, i], 0.0)
        both -= jnp.outer(both[:, i], later)
    return both[:m], both[m:]


def _determinant(m: Float[Array, "n n"]) -> Float[Array, ""]:
    """Determinant by elimination: m is near triangular, and LAPACK's calls cannot be kept on disk."""
    return jnp.prod(jnp.diag(_lower_triangular(m)[0]))


def _by_q(
    structure: Structure, constraints: Constraints, slopes: Float[Array, "2 v v"]
) -> Float[Array, "q m"]:
    """Changes of q that move the motion along `Constraints.across`, a column for each margin."""
    v, count = len(structure.rests), len(constraints.across)
    of_a, of_b = constraints.across[:, :v].T, constraints.across[:, v : 2 * v].T
    by_q = jnp.zeros((len(constraints.slope.T), count))
    by_q = by_q.at[: 2 * v].set(jnp.concatenate([over(slopes[0], of_a), over(slopes[1], of_b)]))
    speed_a = place_of_speed_a(structure)
    return by_q if speed_a is None else by_q.at[speed_a].set(constraints.across[:, -1])
