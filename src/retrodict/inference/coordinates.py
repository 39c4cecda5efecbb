"""The coordinates in which a posterior is sampled: a bijection beside the model, not inside it.

A rest pose measured to a hand's breadth pins the velocities after the impact to a thin curved
sheet, so neither the paper's unknowns nor their whitening makes an easy target. Sampled instead is
q = (z_a, z_b, xi): how many standard deviations each rest pose misses its measurement by, and the
measured inputs as standard normal deviates. A quadratic in q, fitted to run-outs beforehand, gives
velocities after the impact; the paper's closed-form inverse gives B's approach and e, mu, e_m. Any
smooth bijection with its Jacobian keeps the density exact, however roughly the quadratic fits.

e and e_m have hard bounds, and a posterior often leans on them (e near 0 is normal in hard
crashes). `bend` moves q along two directions, those that change e and e_m with the least change of
all else, so that the bounds lie at infinity and every point within them is reached.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.mechanics import Coefficients, approach_and_coefficients, inverse_log_det, undo
from retrodict.models import parts

REACH = 4.0  # the quadratic's arguments saturate here (standard deviations), so it cannot fold
BOUNDS = np.array([[0.0, 1.0], [-1.0, 1.0]])  # of e and e_m

_ROUNDS = 10  # of Broyden's method along the bend
_STEP = 1e-4  # of a wall's softness, in difference quotients along the bend
_TRUSTED = 4.0  # times a wall's softness: how far a level may be from linear
_FLOOR = 0.1  # of the divisors at the centre: where they bend away from zero
_SOLVED = 1e-8  # of a wall's softness: what the bend may miss by

Numbers = Array | np.ndarray
Q = Float[Array, " q"]
Levels = Array | np.ndarray | float


class Sheet(NamedTuple):
    """A quadratic from (z, shaping inputs) to velocities over sqrt(friction).

    Args:
        constant: shape (3,).
        linear: shape (3, k).
        quadratic: shape (3, k, k), symmetric.
    """

    constant: Float[Numbers, "3"]
    linear: Float[Numbers, "3 k"]
    quadratic: Float[Numbers, "3 k k"]

    def __call__(self, x: Float[Array, " k"]) -> Float[Array, "3"]:
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
    """How q is bent so that e (first) and e_m (second) stay within bounds.

    Args:
        level: of both at the centre, shape (2,).
        gradient: of both in q there, shape (2, q).
        along: for each a direction that moves it at rate 1 there and not the other, shape (2, q).
        softness: over which a bound is approached, shape (2,).
        divisor: closing speed and spin by the force alone at the centre, shape (2,).
    """

    level: Float[Numbers, "2"]
    gradient: Float[Numbers, "2 q"]
    along: Float[Numbers, "2 q"]
    softness: Float[Numbers, "2"]
    divisor: Float[Numbers, "2"]


class Chart(NamedTuple):
    """The numbers of the bijection w -> q -> the model's unknowns.

    Args:
        sheets: the quadratics for A and B.
        wall: the bend.
        centre: q at w = 0, shape (q,).
        spread: q's change per w, shape (q, q), lower triangular.
    """

    sheets: tuple[Sheet, Sheet]
    wall: Wall
    centre: Float[Numbers, " q"]
    spread: Float[Numbers, "q q"]


def size(structure: parts.Structure) -> int:
    """Number of sampled coordinates."""
    return 6 + len(structure.uncertain)


def shaping_inputs(structure: parts.Structure, vehicle: str) -> list[int]:
    """Which uncertain inputs shape a vehicle's run-out, by index."""
    other = "_b" if vehicle == "a" else "_a"
    before = ("Gamma", "speed_a", "direction_a", "omega_a")
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
) -> tuple[Float[Array, "6"], Float[Array, "2 3 3"]]:
    """Velocities after the impact over sqrt(friction) at q, and each vehicle's slopes by its z."""
    velocities, slopes = [], []
    for sheet, x in zip(chart.sheets, _sheet_arguments(structure, q), strict=True):
        velocities.append(sheet(x))
        tame = 1 - (saturated(x[:3]) / REACH) ** 2
        bent = 2 * times(sheet.quadratic, saturated(x))[:, :3] * tame
        slopes.append(jnp.asarray(sheet.linear)[:, :3] + bent)
    return jnp.concatenate(velocities), jnp.stack(slopes)


def _sheet_arguments(structure: parts.Structure, q: Q) -> list[Float[Array, " k"]]:
    """(z, shaping inputs) of each vehicle."""
    shaping = [np.array(shaping_inputs(structure, v), dtype=int) for v in "ab"]
    return [jnp.concatenate([q[3 * i : 3 * i + 3], q[6 + s]]) for i, s in enumerate(shaping)]


def quotients(
    structure: parts.Structure, data: parts.Data, chart: Chart, q: Q
) -> tuple[Float[Array, "2"], Float[Array, "2"]]:
    """What e and e_m are quotients of at q, which is closer to linear in q than they are.

    Returns:
        (-opening velocity, spin kept) and (closing velocity, spin by the force alone), m/s and rad/s.
    """
    x = parts.from_standard(structure, data, q[6:])
    velocities = friction_scale(structure, data, x) * reduced(structure, chart, q)[0]
    found = undo(velocities, parts.approach_of_a(x), parts.bodies(x))
    return (
        jnp.stack([-found.opening, found.spin]),
        jnp.stack([found.closing, found.free_spin]),
    )


def squash(level: Levels, softness: Levels, low: Levels, high: Levels) -> Array:
    """From the whole line into (low, high); the identity away from them."""
    up = jax.nn.softplus((level - low) / softness) - jax.nn.softplus((level - high) / softness)
    return jnp.asarray(low + softness * up)


def log_squash_slope(level: Levels, softness: Levels, low: Levels, high: Levels) -> Array:
    """Log of squash's derivative."""
    # sigmoid(up) - sigmoid(-down), without cancellation
    slope = jax.nn.log_sigmoid((level - low) / softness)
    slope += jax.nn.log_sigmoid((high - level) / softness)
    return slope + jnp.log(-jnp.expm1((low - high) / softness))


def bend(
    structure: parts.Structure, data: parts.Data, chart: Chart, q: Q
) -> tuple[Q, Float[Array, "2"], Float[Array, ""]]:
    """Move q along the walls' directions to where e and e_m are their levels at q, squashed.

    A level is what e or e_m is at q, but never far from linear in q, so that it passes every bound;
    away from the bounds bent q is nearly q itself. Broyden's method finds how far to move. Values are
    exact; derivatives are those of the bend were e and e_m linear in q, near enough to steer by.

    Returns:
        Bent q, e and e_m there, and log |d bent / d q|; minus infinity where no such point was found.
    """
    wall = Wall(*map(jnp.asarray, chart.wall))
    fixed = jax.lax.stop_gradient(q)

    def at(t: Float[Array, "2"]) -> tuple[Float[Array, "2"], Float[Array, "2"]]:
        return quotients(structure, data, chart, fixed + t @ wall.along)

    # central differences: automatic ones take as long to compile as all the rest, and these err by 1e-9
    nudges = jnp.diag(_STEP * wall.softness)
    around = jnp.concatenate([jnp.zeros((1, 2)), nudges, -nudges])

    def values_and_slope(
        t: Float[Array, "2"], floored: bool
    ) -> tuple[Float[Array, "2"], Float[Array, "2 2"]]:
        """e and e_m at t, and their slopes by t."""
        over, under = jax.vmap(at)(t + around)
        values = over / (_floored(under / wall.divisor) * wall.divisor if floored else under)
        return values[0], ((values[1:3] - values[3:]) / (2 * _STEP * wall.softness[:, None])).T

    zero = jnp.zeros(2)
    linear = wall.level + times(wall.gradient, q - jnp.asarray(chart.centre))
    values, slope = values_and_slope(zero, floored=True)
    apart = (values - jax.lax.stop_gradient(linear)) / (_TRUSTED * wall.softness)
    level = linear + _TRUSTED * wall.softness * jnp.tanh(apart)
    trust = 1 - jnp.tanh(apart[:, None]) ** 2
    slope_before = _log_det(trust * slope + (1 - trust) * jnp.eye(2))
    target = squash(level, wall.softness, *BOUNDS.T)
    aim = jax.lax.stop_gradient(target)

    Carry = tuple[Array, Array, Array, Array]

    def improve(carry: Carry, _: None) -> tuple[Carry, None]:
        t, step, miss_before, inverse = carry
        over, under = at(t)
        miss = over - aim * under  # closer to linear than the quotient
        change = inverse @ (miss - miss_before)
        gain = step @ change
        update = jnp.outer(step - change, step @ inverse)
        inverse += jnp.where(gain == 0, 0.0, 1 / jnp.where(gain == 0, 1.0, gain)) * update
        step = -inverse @ miss
        return (t + step, step, miss, inverse), None

    start = (zero, zero, zero, jnp.diag(1 / wall.divisor))
    (t, *_), _ = jax.lax.scan(improve, start, None, length=_ROUNDS)
    found, slope = values_and_slope(t, floored=False)
    solved = (jnp.abs(found - aim) < _SOLVED * wall.softness).all()
    log_det = (
        log_squash_slope(level, wall.softness, *BOUNDS.T).sum() + slope_before - _log_det(slope)
    )
    move = target - level
    bent = q + (move + t - jax.lax.stop_gradient(move)) @ wall.along
    return bent, target, jnp.where(solved, log_det, -jnp.inf)


def locate(
    structure: parts.Structure, data: parts.Data, chart: Chart, w: Q
) -> tuple[parts.Values, Float[Array, ""], Q]:
    """The model's unknowns at w, and log |d unknowns / d w|.

    Args:
        structure: of the scene.
        data: its numbers.
        chart: the numbers of the bijection.
        w: a point of the sampled space, shape (q,).

    Returns:
        A value for each of the model's sample sites, the log determinant, and q.
    """
    q = jnp.asarray(chart.centre) + times(chart.spread, w)
    q, (e, e_m), log_det = bend(structure, data, chart, q)
    x = parts.from_standard(structure, data, q[6:])
    scale = friction_scale(structure, data, x)
    velocities, slopes = reduced(structure, chart, q)
    log_det += jnp.log(jnp.diag(chart.spread)).sum() + 6 * jnp.log(scale)
    log_det += jnp.log(jnp.abs(_det_3(slopes[0]) * _det_3(slopes[1])))

    approach_b, c, log_inverse = inverse_log_det(
        scale * velocities, parts.approach_of_a(x), parts.bodies(x)
    )
    sites = _sites(structure, data, q, approach_b, c._replace(e=e, e_m=e_m))
    return sites, log_det + log_inverse - jnp.log(sites["speed_b"]), q


def solve_back(structure: parts.Structure, data: parts.Data, chart: Chart, q: Q) -> parts.Values:
    """The model's unknowns at q = (z, xi) by the sheets and the closed form, without bounds."""
    x = parts.from_standard(structure, data, q[6:])
    velocities = friction_scale(structure, data, x) * reduced(structure, chart, q)[0]
    found = approach_and_coefficients(velocities, parts.approach_of_a(x), parts.bodies(x))
    return _sites(structure, data, q, *found)


def _sites(
    structure: parts.Structure,
    data: parts.Data,
    q: Q,
    approach_b: Float[Array, "3"],
    coefficients: Coefficients,
) -> parts.Values:
    """A value for each of the model's sample sites."""
    v_bx, v_by, omega_b = approach_b
    direction = jnp.arctan2(v_by, v_bx)
    if "direction_b" in structure.known_of_b:
        middle = data.inputs["direction_b"][0]
        direction = middle + jnp.arctan2(jnp.sin(direction - middle), jnp.cos(direction - middle))
    e, mu, e_m = map(jnp.asarray, coefficients)
    return ({"measured": q[6:]} if structure.uncertain else {}) | {
        "speed_b": jnp.sqrt(v_bx**2 + v_by**2),
        "direction_b": direction,
        "omega_b": omega_b,
        "e": e,
        "mu": mu,
        "e_m": e_m,
    }


def _floored(ratio: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """A divisor over that at the centre, kept above zero: no level has a pole."""
    return _FLOOR * jax.nn.softplus(ratio / _FLOOR)


def _log_det(m: Float[Array, "2 2"]) -> Float[Array, ""]:
    return jnp.log(jnp.abs(m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]))


def _det_3(m: Float[Array, "3 3"]) -> Float[Array, ""]:
    return jnp.dot(m[:, 0], jnp.cross(m[:, 1], m[:, 2]))
