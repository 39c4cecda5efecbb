"""The coordinates in which a posterior is sampled: a bijection beside the model, not inside it.

A rest pose measured to a hand's breadth pins the velocities after the impact to a thin curved
sheet, so neither the paper's unknowns nor their whitening makes an easy target. Sampled instead is
q = (z_a, z_b, xi): how many standard deviations each rest pose misses its measurement by, and the
measured inputs as standard normal deviates. A quadratic in q, fitted to run-outs beforehand, gives
velocities after the impact; the impact model's closed-form inverse gives its unknowns. Any smooth
bijection with its Jacobian keeps the density exact, however roughly the quadratic fits.

e and e_m have hard bounds, and a posterior often leans on them (e near 0 is normal in hard
crashes). `bend` moves q along a direction for each, that changes it with the least change of all
else, so that the bounds lie at infinity and every point within them is reached. A simpler impact
model holds some of these levels fixed (e_m = 1, no sliding left): then q is moved to where they are
so, and its coordinates are fewer than its entries. Levels are quotients, whose numerators and
denominators are nearly linear in q, and just linear in the motion: q is moved as if they were linear
in it, then the motion, by the little that was missed. Both are linear equations.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.inference import unpinned
from retrodict.inference.squash import squash
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import Level, quotients

REACH = 4.0  # the quadratic's arguments saturate here (standard deviations), so it cannot fold

_TRUSTED = 4.0  # times a wall's softness: how far a level may be from linear in q
_MISSED = 16.0  # times a wall's softness: how far it may be from what it was bent to
_FLOOR = 0.1  # of the divisors at the centre: where they bend away from zero
_BEYOND = 20.0  # taken off the log density there: as good as nothing, and no wall to diverge at

Numbers = Array | np.ndarray
Q = Float[Array, " q"]


class Sheet(NamedTuple):
    """A quadratic from (z, shaping inputs) to velocities over sqrt(friction).

    Args:
        constant: velocities, shape (v,).
        linear: shape (v, k).
        quadratic: shape (v, k, k), symmetric.
    """

    constant: Float[Numbers, " v"]
    linear: Float[Numbers, "v k"]
    quadratic: Float[Numbers, "v k k"]

    def __call__(self, x: Float[Array, " k"]) -> Float[Array, " v"]:
        """Its value at x."""
        s = saturated(x)
        return (
            jnp.asarray(self.constant) + times(self.linear, x) + times(times(self.quadratic, s), s)
        )


def times(m: Float[Numbers, "*rows k"], x: Float[Numbers, " k"]) -> Float[Array, "*rows"]:
    """m @ x as a product and a sum: XLA compiles that four times faster than small matrix products."""
    return jnp.sum(m * x, axis=-1)


def saturated(x: Float[Array | np.ndarray, "*any"], xp: ModuleType = jnp) -> Any:
    """x, held within REACH: the argument of the quadratic terms, so that they cannot fold."""
    return REACH * xp.tanh(x / REACH)


class Wall(NamedTuple):
    """How q is bent so that the impact model's levels stay within bounds, or where they are held.

    Args:
        over: numerator of each level at the centre, shape (m,).
        under: its denominator there, shape (m,).
        over_slope: of the numerators by q there, shape (m, q).
        under_slope: of the denominators, shape (m, q).
        along: for each a direction of q that moves it at rate 1 there and no other, shape (m, q).
        across: for each a direction of the motion (velocities after the impact over sqrt(friction), then
            the deviate of A's speed where that is linear in it) that does, shape (m, v + 1).
        softness: over which a bound is approached, shape (m,).
    """

    over: Float[Numbers, " m"]
    under: Float[Numbers, " m"]
    over_slope: Float[Numbers, "m q"]
    under_slope: Float[Numbers, "m q"]
    along: Float[Numbers, "m q"]
    across: Float[Numbers, "m v+1"]
    softness: Float[Numbers, " m"]

    @property
    def level(self) -> Float[Numbers, " m"]:
        """Of each at the centre."""
        return self.over / self.under

    @property
    def gradient(self) -> Float[Numbers, "m q"]:
        """Of each in q there."""
        return (self.over_slope - self.level[:, None] * self.under_slope) / self.under[:, None]


class Chart(NamedTuple):
    """The numbers of the bijection w -> q -> the model's unknowns.

    Args:
        sheets: the quadratics for A and B.
        wall: the bend.
        centre: q at w = 0, shape (q,).
        spread: q's change per w, shape (q, w); no column changes a fixed level, to first order.
        log_volume: log |det| of the spread and the directions of the fixed levels together.
    """

    sheets: tuple[Sheet, Sheet]
    wall: Wall
    centre: Float[Numbers, " q"]
    spread: Float[Numbers, "q w"]
    log_volume: Float[Numbers, ""]


def levels_of(structure: Structure) -> tuple[Level, ...]:
    """What the impact model bounds or holds fixed."""
    return RUNGS[structure.rung].impact.levels


def length(structure: Structure) -> int:
    """Number of entries of q."""
    if structure.unpinned:
        return len(unpinned.names(structure)) + len(structure.uncertain)
    return len(structure.aims) + len(structure.uncertain)


def size(structure: Structure) -> int:
    """Number of sampled coordinates, the entries of w."""
    if structure.unpinned:
        return length(structure)
    return length(structure) - sum(level.fixed for level in levels_of(structure))


def shaping_inputs(structure: Structure, vehicle: str) -> list[int]:
    """Which uncertain inputs shape a vehicle's run-out, by index."""
    other = "_b" if vehicle == "a" else "_a"
    before = ("Gamma", "speed_a", "direction_a", "omega_a", "skid_a", "skid_b")
    return [i for i, n in enumerate(structure.names) if not n.endswith(other) and n not in before]


def friction_scale(structure: Structure, data: Data, x: parts.Values) -> Float[Array, ""]:
    """sqrt(friction over its measured value): all speeds go with it, so the sheets need not."""
    name = f"friction_{structure.surfaces[0]}"
    value = data.inputs[name][0]
    if dict(structure.uncertain).get(name) == "lognormal":
        value = jnp.exp(value)
    return jnp.sqrt(x[name] / value)


def reduced(
    structure: Structure, chart: Chart, q: Q
) -> tuple[Float[Array, " separation"], Float[Array, "2 v v"]]:
    """Velocities after the impact over sqrt(friction) at q, and each vehicle's slopes by its z."""
    velocities, slopes = [], []
    v = len(structure.rests)
    for sheet, x in zip(chart.sheets, _sheet_arguments(structure, q), strict=True):
        velocities.append(sheet(x))
        tame = 1 - (saturated(x[:v]) / REACH) ** 2
        bent = 2 * times(sheet.quadratic, saturated(x))[:, :v] * tame
        slopes.append(jnp.asarray(sheet.linear)[:, :v] + bent)
    return jnp.concatenate(velocities), jnp.stack(slopes)


def _sheet_arguments(structure: Structure, q: Q) -> list[Float[Array, " k"]]:
    """(z, shaping inputs) of each vehicle."""
    z, xi = _split(structure, q)
    shaping = [np.array(shaping_inputs(structure, v), dtype=int) for v in "ab"]
    return [jnp.concatenate([own, xi[s]]) for own, s in zip(z.reshape(2, -1), shaping, strict=True)]


def _split(structure: Structure, q: Q) -> tuple[Array, Array]:
    """z and xi of q."""
    n = len(structure.aims)
    return q[:n], q[n:]


def separation_at(
    structure: Structure, data: Data, chart: Chart, q: Q
) -> tuple[Float[Array, " separation"], parts.Values]:
    """Velocities after the impact, and measured inputs, at q."""
    x = parts.from_standard(structure, data, _split(structure, q)[1])
    return friction_scale(structure, data, x) * reduced(structure, chart, q)[0], x


class Bent(NamedTuple):
    """Where a point is moved to so that its levels are within bounds, or where they are held.

    Args:
        q: moved along `Wall.along`, shape (q,).
        motion: how far the motion is moved besides, m/s and rad/s, shape (v + 1,).
        by_q: what of q would move it as far, shape (q,).
        levels: those that are bounded, by name.
        log_det: log |d (motion, inputs) / d q|, a held level in the place of the coordinate along its
            direction, less that of the sheets at `q`; minus infinity where points would be reached
            again.
    """

    q: Q
    motion: Float[Array, " v+1"]
    by_q: Q
    levels: parts.Values
    log_det: Float[Array, ""]


def bend(structure: Structure, data: Data, chart: Chart, q: Q) -> Bent:
    """Move q, and then the motion, to where each level is what it was, squashed, or held.

    Values are exact; derivatives are those of the bend were numerators and denominators linear in q,
    near enough to steer by, and cheap.
    """
    levels, wall = levels_of(structure), Wall(*map(jnp.asarray, chart.wall))
    free = [i for i, level in enumerate(levels) if not level.fixed]

    # q along the walls' directions, as if numerators and denominators were linear in it
    y = q - jnp.asarray(chart.centre)
    linear = jnp.asarray(wall.level) + times(wall.gradient, y)
    over, under = wall.over + times(wall.over_slope, y), wall.under + times(wall.under_slope, y)
    over_rate, under_rate = (
        jnp.asarray(s @ wall.along.T) for s in (wall.over_slope, wall.under_slope)
    )
    value, slope = _quotient(wall, over, under, over_rate, under_rate)
    apart, trust = _within(value - linear, _TRUSTED * wall.softness)
    level = linear + apart
    slope = trust[:, None] * slope + (1 - trust[:, None]) * jnp.eye(len(levels))
    aim, share, _ = _squashed(levels, wall, level)
    t, under, rate = _to(aim, over, under, over_rate, under_rate)
    there = q + t @ wall.along
    turned = [slope, rate / wall.under[:, None], jnp.diag(under / wall.under)]
    log_det = jnp.log(jnp.abs(under)).sum() - _log_det(rate)
    log_det += _log_det(slope[np.ix_(free, free)]) if free else 0.0

    # then the motion, by what that missed: too little for its derivatives to be worth their price
    here, aim_there, share, divisor = jax.lax.stop_gradient((there, aim, share, under))
    x = parts.from_standard(structure, data, _split(structure, here)[1])
    scale = friction_scale(structure, data, x)
    velocities, slopes = reduced(structure, chart, here)
    units = jnp.append(jnp.full(velocities.size, scale), jnp.asarray(data.inputs["speed_a"])[1])

    def at(nudge: Float[Array, " v+1"]) -> tuple[Float[Array, " m"], Float[Array, " m"]]:
        faster = x | {"speed_a": x["speed_a"] + nudge[-1]}
        return quotients(levels, scale * velocities + nudge[:-1], faster)

    nudges = units * jnp.concatenate([jnp.zeros((1, units.size)), wall.across])
    over_at, under_at = jax.vmap(at)(nudges)
    across_rate = (over_at[1:] - over_at[0]).T, (under_at[1:] - under_at[0]).T
    by_q = _by_q(structure, wall, slopes)
    by_y = wall.over_slope - aim_there[:, None] * wall.under_slope
    aim_rate = jnp.asarray(by_y @ by_q / divisor[:, None])
    value, slope = _quotient(wall, over_at[0], under_at[0], *across_rate)
    apart, trust = _within(value - aim_there, _MISSED * wall.softness)
    slope = aim_rate + (share * trust)[:, None] * (slope - aim_rate)
    # the level that the point had before it was bent
    aim, _, volume = _squashed(levels, wall, level + apart)
    t, under, rate = _to(jax.lax.stop_gradient(aim), over_at[0], under_at[0], *across_rate)
    turned += [slope, rate / wall.under[:, None]]
    log_det += jnp.log(jnp.abs(under)).sum() - _log_det(rate) + _log_det(slope) + volume
    beyond = (under / wall.under)[np.array(free, int)] <= 0  # lies another branch
    log_det -= jnp.where(beyond.any(), _BEYOND, 0.0)
    # each is one at the centre; where a determinant has turned, far out, points would be reached again
    folded = jnp.stack([_det(m) for m in turned]) <= 0
    log_det = jnp.where(folded.any(), -jnp.inf, log_det)
    aims = {levels[i].name: aim[i] for i in free}
    return Bent(there, units * (t @ wall.across), by_q @ t, aims, log_det)


def _squashed(
    levels: tuple[Level, ...], wall: Wall, values: Float[Numbers, " m"]
) -> tuple[Float[Array, " m"], Float[Array, " m"], Float[Array, ""]]:
    """Levels within their bounds or where they are held, how fast the former change, and its log."""
    low, high = np.array([(level.low, level.high) for level in levels]).T
    free = np.flatnonzero(low < high)
    if not free.size:
        return jnp.asarray(low), jnp.zeros(low.size), jnp.zeros(())
    inside, log_slope = squash(values[free], wall.softness[free], low[free], high[free])
    aims = jnp.asarray(low).at[free].set(inside)
    return aims, jnp.zeros(low.size).at[free].set(jnp.exp(log_slope)), jnp.sum(log_slope)


def _quotient(
    wall: Wall,
    over: Float[Numbers, " m"],
    under: Float[Numbers, " m"],
    over_rate: Float[Numbers, "m m"],
    under_rate: Float[Numbers, "m m"],
) -> tuple[Float[Array, " m"], Float[Array, "m m"]]:
    """Levels without poles, for the divisors are kept above zero, and how fast they change."""
    ratio = under / wall.under
    divisor = wall.under * _FLOOR * jax.nn.softplus(ratio / _FLOOR)
    value = jnp.asarray(over / divisor)
    rate = over_rate - (value * jax.nn.sigmoid(ratio / _FLOOR))[:, None] * under_rate
    return value, jnp.asarray(rate / divisor[:, None])


def _to(
    aim: Float[Array, " m"],
    over: Float[Numbers, " m"],
    under: Float[Numbers, " m"],
    over_rate: Float[Numbers, "m m"],
    under_rate: Float[Numbers, "m m"],
) -> tuple[Float[Array, " m"], Float[Array, " m"], Float[Array, "m m"]]:
    """How far each way leads to where the quotients are `aim`; denominators there; what was solved."""
    rate = jnp.asarray(over_rate - aim[:, None] * under_rate)
    t = _over(rate, (aim * under - over)[:, None])[:, 0]
    return t, jnp.asarray(under + under_rate @ t), rate


def _within(
    x: Float[Numbers, " m"], most: Float[Numbers, " m"]
) -> tuple[Float[Array, " m"], Float[Array, " m"]]:
    """x, bent to stay below `most` in size, and its slope."""
    tanh = jnp.tanh(x / most)
    return jnp.asarray(most * tanh), 1 - tanh**2


def _by_q(structure: Structure, wall: Wall, slopes: Float[Array, "2 v v"]) -> Float[Array, "q m"]:
    """What of q moves the motion along `Wall.across`."""
    v, count = len(structure.rests), len(wall.across)
    of_a, of_b = wall.across[:, :v].T, wall.across[:, v : 2 * v].T
    by_q = jnp.zeros((length(structure), count))
    by_q = by_q.at[: 2 * v].set(jnp.concatenate([_over(slopes[0], of_a), _over(slopes[1], of_b)]))
    speed_a = place_of_speed_a(structure)
    return by_q if speed_a is None else by_q.at[speed_a].set(wall.across[:, -1])


def place_of_speed_a(structure: Structure) -> int | None:
    """Which entry of q is the deviate of A's speed, where the speed is linear in it."""
    if ("speed_a", "normal") not in structure.uncertain:
        return None
    return len(structure.aims) + structure.names.index("speed_a")


def locate(
    structure: Structure, data: Data, chart: Chart, w: Float[Array, " w"]
) -> tuple[parts.Values, Float[Array, ""], Q]:
    """The model's unknowns at w, and log |d unknowns / d w|.

    Args:
        structure: of the scene.
        data: its numbers.
        chart: the numbers of the bijection.
        w: a point of the sampled space, shape (w,).

    Returns:
        A value for each of the model's sample sites, the log determinant, and q.
    """
    q = jnp.asarray(chart.centre) + times(chart.spread, w)
    log_det = jnp.asarray(chart.log_volume)
    if structure.unpinned:
        sites, volume = unpinned.locate(structure, data, q)
        return sites, volume + log_det, q
    v = len(structure.aims)
    bent = Bent(q, jnp.zeros(v + 1), jnp.zeros(q.size), {}, jnp.zeros(()))
    if levels_of(structure):
        bent = bend(structure, data, chart, q)
    slopes = reduced(structure, chart, bent.q)[1]
    separation, x = separation_at(structure, data, chart, bent.q)
    log_det += bent.log_det + v * jnp.log(friction_scale(structure, data, x))
    log_det += _log_det(slopes[0]) + _log_det(slopes[1])
    x["speed_a"] += bent.motion[v]
    q = bent.q + bent.by_q
    sites, log_inverse = _sites(structure, data, q, separation + bent.motion[:v], x)
    log_det += log_inverse - jnp.log(sites["speed_b"])  # which stands with its direction for two
    return sites | bent.levels, log_det, q


def solve_back(structure: Structure, data: Data, chart: Chart, q: Q) -> parts.Values:
    """The model's unknowns at q = (z, xi) by the sheets and the closed form, without bounds."""
    return _sites(structure, data, q, *separation_at(structure, data, chart, q))[0]


def _sites(
    structure: Structure,
    data: Data,
    q: Q,
    separation: Float[Array, " separation"],
    x: parts.Values,
) -> tuple[parts.Values, Float[Array, ""]]:
    """A value for each of the model's sample sites, and log |d sites / d separation|."""
    sites, log_det = RUNGS[structure.rung].impact.unknowns(separation, x)
    v_bx, v_by = sites.pop("velocity_b")
    direction = jnp.arctan2(v_by, v_bx)
    if "direction_b" in structure.known_of_b:
        middle = data.inputs["direction_b"][0]
        direction = middle + jnp.arctan2(jnp.sin(direction - middle), jnp.cos(direction - middle))
    if structure.uncertain:
        sites["measured"] = _split(structure, q)[1]
    return sites | {"speed_b": jnp.sqrt(v_bx**2 + v_by**2), "direction_b": direction}, log_det


def _over(m: Float[Array, "n n"], b: Float[Numbers, "n k"]) -> Float[Array, "n k"]:
    """m's inverse times b, of up to three rows, written out: LAPACK's calls cannot be kept on disk."""
    if len(m) == 1:
        return jnp.asarray(b) / m[0, 0]
    if len(m) == 2:
        adjugate = jnp.array([[m[1, 1], -m[0, 1]], [-m[1, 0], m[0, 0]]])
    else:
        u, v, w = m.T
        adjugate = jnp.stack([jnp.cross(v, w), jnp.cross(w, u), jnp.cross(u, v)])
    return (adjugate @ b) / _det(m)


def _log_det(m: Any) -> Float[Array, ""]:
    """log |det| of a matrix of up to three rows."""
    return jnp.log(jnp.abs(_det(m)))


def _det(m: Any) -> Float[Array, ""]:
    """Determinant of a matrix of up to three rows, written out likewise."""
    if len(m) == 1:
        return m[0][0]
    if len(m) == 2:
        return m[0][0] * m[1][1] - m[0][1] * m[1][0]
    a, b, c = jnp.asarray(m).T
    return jnp.dot(a, jnp.cross(b, c))
