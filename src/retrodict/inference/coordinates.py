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
so, and its coordinates are fewer than its entries.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.inference import unpinned
from retrodict.inference.squash import log_squash_slope, squash
from retrodict.models import RUNGS, parts
from retrodict.models.impact import Level, quotients

REACH = 4.0  # the quadratic's arguments saturate here (standard deviations), so it cannot fold

_ROUNDS = 10  # of Broyden's method along the bend
_ROUNDING = 1e-12  # of a wall's softness: steps too short to learn from
_STEP = 1e-4  # of a wall's softness, in difference quotients along the bend
_TRUSTED = 4.0  # times a wall's softness: how far a level may be from linear
_FLOOR = 0.1  # of the divisors at the centre: where they bend away from zero
_BEYOND = 20.0  # taken off the log density there: as good as nothing, and no wall to diverge at
_SOLVED = 1e-8  # of a wall's softness: what the bend may miss by

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
        level: of each at the centre, shape (m,).
        gradient: of each in q there, shape (m, q).
        along: for each a direction that moves it at rate 1 there and no other, shape (m, q).
        softness: over which a bound is approached, shape (m,).
        divisor: what each is divided by at the centre, shape (m,).
    """

    level: Float[Numbers, " m"]
    gradient: Float[Numbers, "m q"]
    along: Float[Numbers, "m q"]
    softness: Float[Numbers, " m"]
    divisor: Float[Numbers, " m"]


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


def levels_of(structure: parts.Structure) -> tuple[Level, ...]:
    """What the impact model bounds or holds fixed."""
    return RUNGS[structure.rung].impact.levels


def length(structure: parts.Structure) -> int:
    """Number of entries of q."""
    if structure.unpinned:
        return len(unpinned.names(structure)) + len(structure.uncertain)
    return len(structure.aims) + len(structure.uncertain)


def size(structure: parts.Structure) -> int:
    """Number of sampled coordinates, the entries of w."""
    if structure.unpinned:
        return length(structure)
    return length(structure) - sum(level.fixed for level in levels_of(structure))


def shaping_inputs(structure: parts.Structure, vehicle: str) -> list[int]:
    """Which uncertain inputs shape a vehicle's run-out, by index."""
    other = "_b" if vehicle == "a" else "_a"
    before = ("Gamma", "speed_a", "direction_a", "omega_a", "skid_a", "skid_b")
    return [i for i, n in enumerate(structure.names) if not n.endswith(other) and n not in before]


def friction_scale(
    structure: parts.Structure, data: parts.Data, x: parts.Values
) -> Float[Array, ""]:
    """sqrt(friction over its measured value): all speeds go with it, so the sheets need not."""
    name = f"friction_{structure.surfaces[0]}"
    value = data.inputs[name][0]
    if dict(structure.uncertain).get(name) == "lognormal":
        value = jnp.exp(value)
    return jnp.sqrt(x[name] / value)


def reduced(
    structure: parts.Structure, chart: Chart, q: Q
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


def _sheet_arguments(structure: parts.Structure, q: Q) -> list[Float[Array, " k"]]:
    """(z, shaping inputs) of each vehicle."""
    z, xi = _split(structure, q)
    shaping = [np.array(shaping_inputs(structure, v), dtype=int) for v in "ab"]
    return [jnp.concatenate([own, xi[s]]) for own, s in zip(z.reshape(2, -1), shaping, strict=True)]


def _split(structure: parts.Structure, q: Q) -> tuple[Array, Array]:
    """z and xi of q."""
    n = len(structure.aims)
    return q[:n], q[n:]


def separation_at(
    structure: parts.Structure, data: parts.Data, chart: Chart, q: Q
) -> tuple[Float[Array, " separation"], parts.Values]:
    """Velocities after the impact, and measured inputs, at q."""
    x = parts.from_standard(structure, data, _split(structure, q)[1])
    return friction_scale(structure, data, x) * reduced(structure, chart, q)[0], x


def bend(
    structure: parts.Structure, data: parts.Data, chart: Chart, q: Q
) -> tuple[Q, dict[str, Array], Float[Array, ""]]:
    """Move q along the walls' directions to where each level is what it was, squashed, or held.

    A bounded level is what e or e_m is at q, but never far from linear in q, so that it passes every
    bound; away from the bounds bent q is nearly q itself. Broyden's method finds how far to move.
    Values are exact; derivatives are those of the bend were the levels linear in q, near enough to
    steer by.

    Returns:
        Bent q, the bounded levels there by name, and log |d bent / d q|, in which a fixed level
        stands for the coordinate along its direction; minus infinity where no such point was found.
    """
    levels = levels_of(structure)
    if not levels:
        return q, {}, jnp.zeros(())
    wall = Wall(*map(jnp.asarray, chart.wall))
    count = len(levels)
    free = [i for i, level in enumerate(levels) if not level.fixed]
    bounds = np.array([(level.low, level.high) for level in levels]).T
    fixed = jax.lax.stop_gradient(q)

    def at(t: Float[Array, " m"]) -> tuple[Float[Array, " m"], Float[Array, " m"]]:
        return quotients(levels, *separation_at(structure, data, chart, fixed + t @ wall.along))

    # central differences: automatic ones take as long to compile as all the rest, and these err by 1e-9
    nudges = jnp.diag(_STEP * wall.softness)
    around = jnp.concatenate([jnp.zeros((1, count)), nudges, -nudges])

    def values_and_slope(
        t: Float[Array, " m"], floored: bool
    ) -> tuple[Float[Array, " m"], Float[Array, "m m"], Float[Array, " m"]]:
        """The levels at t, their slopes by t, and their divisors over those at the centre."""
        over, under = jax.vmap(at)(t + around)
        values = over / (_floored(under / wall.divisor) * wall.divisor if floored else under)
        rise = values[1 : count + 1] - values[count + 1 :]
        slope = (rise / (2 * _STEP * wall.softness[:, None])).T
        return values[0], slope, under[0] / wall.divisor

    zero = jnp.zeros(count)
    linear = wall.level + times(wall.gradient, q - jnp.asarray(chart.centre))
    values, slope, _ = values_and_slope(zero, floored=True)
    apart = (values - jax.lax.stop_gradient(linear)) / (_TRUSTED * wall.softness)
    level = linear + _TRUSTED * wall.softness * jnp.tanh(apart)
    trust = 1 - jnp.tanh(apart[:, None]) ** 2
    slope_before = trust * slope + (1 - trust) * jnp.eye(count)
    target = jnp.stack(
        [
            squash(level[i], wall.softness[i], *bounds[:, i]) if i in free else jnp.array(at_)
            for i, at_ in enumerate(bounds[0])
        ]
    )
    aim = jax.lax.stop_gradient(target)

    Carry = tuple[Array, Array, Array, Array]

    def improve(carry: Carry, _: None) -> tuple[Carry, None]:
        t, step, miss_before, inverse = carry
        over, under = at(t)
        miss = over - aim * under  # closer to linear than the quotient
        change = inverse @ (miss - miss_before)
        gain = step @ change
        update = jnp.outer(step - change, step @ inverse)
        # what a step of rounding's size changes is noise, of which the inverse is to learn nothing
        sure = (jnp.abs(step) > _ROUNDING * wall.softness).any() & (gain != 0)
        inverse += jnp.where(sure, update / jnp.where(sure, gain, 1.0), 0.0)
        step = -inverse @ miss
        return (t + step, step, miss, inverse), None

    start = (zero, zero, zero, jnp.diag(1 / wall.divisor))
    (t, *_), _ = jax.lax.scan(improve, start, None, length=_ROUNDS)
    t = jax.lax.stop_gradient(t)
    found, slope, divisor = values_and_slope(t, floored=False)
    solved = (jnp.abs(found - aim) < _SOLVED * wall.softness).all()
    beyond = (divisor[np.array(free, int)] <= 0).any()  # lies another branch
    log_det = _log_det([[slope_before[i, j] for j in free] for i in free]) - _log_det(slope)
    for i in free:
        log_det += log_squash_slope(level[i], wall.softness[i], *bounds[:, i])
    move = target - level
    t += move - jax.lax.stop_gradient(move)
    bent = q + t @ wall.along
    reached = {levels[i].name: target[i] for i in free}
    log_det -= jnp.where(beyond, _BEYOND, 0.0)
    return bent, reached, jnp.where(solved, log_det, -jnp.inf)


def locate(
    structure: parts.Structure, data: parts.Data, chart: Chart, w: Float[Array, " w"]
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
    if structure.unpinned:
        sites, log_det = unpinned.locate(structure, data, q)
        return sites, log_det + chart.log_volume, q
    q, reached, log_det = bend(structure, data, chart, q)
    slopes = reduced(structure, chart, q)[1]
    separation, x = separation_at(structure, data, chart, q)
    log_det += chart.log_volume
    log_det += separation.size * jnp.log(friction_scale(structure, data, x))
    log_det += _log_det(slopes[0]) + _log_det(slopes[1])
    sites, log_inverse = _sites(structure, data, q, separation, x)
    log_det += log_inverse - jnp.log(sites["speed_b"])  # which stands with its direction for two
    return sites | reached, log_det, q


def solve_back(structure: parts.Structure, data: parts.Data, chart: Chart, q: Q) -> parts.Values:
    """The model's unknowns at q = (z, xi) by the sheets and the closed form, without bounds."""
    return _sites(structure, data, q, *separation_at(structure, data, chart, q))[0]


def _sites(
    structure: parts.Structure,
    data: parts.Data,
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


def _floored(ratio: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """A divisor over that at the centre, kept above zero: no level has a pole."""
    return _FLOOR * jax.nn.softplus(ratio / _FLOOR)


def _log_det(m: Any) -> Float[Array, ""]:
    """log |det| of a matrix of up to three rows, written out: LAPACK's calls cannot be kept on disk."""
    rows = len(m)
    if rows == 1:
        det = m[0][0]
    elif rows == 2:
        det = m[0][0] * m[1][1] - m[0][1] * m[1][0]
    else:
        a, b, c = jnp.asarray(m).T
        det = jnp.dot(a, jnp.cross(b, c))
    return jnp.log(jnp.abs(det))
