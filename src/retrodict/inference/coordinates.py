"""The coordinates in which a posterior is sampled: a bijection beside the model, not inside it.

A rest pose measured to a hand's breadth pins the velocities after the impact to a thin curved
sheet, so neither the paper's unknowns nor their whitening makes an easy target. Sampled instead is
q = (z_a, z_b, xi): how many standard deviations each rest pose misses its measurement by, and the
measured inputs as standard normal deviates. A quadratic in q, fitted to run-outs beforehand, gives
velocities after the impact; the paper's closed-form inverse gives B's approach and e, mu, e_m. Any
smooth bijection with its Jacobian keeps the density exact, however roughly the quadratic fits.

e and e_m have hard bounds, and a posterior often leans on them (e near 0 is normal in hard
crashes). `walls` bends q, along the two directions that move e and e_m with the least change of
all else, so that the bounds lie at infinity.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.mechanics import (
    approach_and_coefficients,
    contact_velocity,
    impulse,
    inverse_log_det,
)
from retrodict.models import parts

REACH = 4.0  # the quadratic's arguments saturate here (standard deviations), so it cannot fold
BOUNDS = np.array([[0.0, 1.0], [-1.0, 1.0]])  # of e and e_m
_LEAST_RISE = (
    0.1  # of a level along its line, 1 at the expansion's centre: keeps the bend one-to-one
)
_RESIDUE = 0.2  # of a wall's softness: how exactly the bend keeps its bounds, roughly

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
        at: where both are expanded to second order, shape (q,).
        level: e and e_m there, over the closing speed and the free spin there (see `bounded`).
        gradient: theirs in q, shape (2, q).
        hessian: theirs in q, shape (2, q, q).
        along: for each a direction that moves it and, to first order, not the other, shape (2, q).
        softness: over which a bound is approached, shape (2,).
    """

    at: Float[Numbers, " q"]
    level: Float[Numbers, "2"]
    gradient: Float[Numbers, "2 q"]
    hessian: Float[Numbers, "2 q q"]
    along: Float[Numbers, "2 q"]
    softness: Float[Numbers, "2"]


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


def separation_of(
    structure: parts.Structure, data: parts.Data, chart: Chart, q: Q
) -> tuple[Float[Array, "6"], parts.Values]:
    """Velocities after the impact and the inputs at q."""
    x = parts.from_standard(structure, data, q[6:])
    scale = friction_scale(structure, data, x)
    arguments = _sheet_arguments(structure, q)
    velocities = [sheet(a) for sheet, a in zip(chart.sheets, arguments, strict=True)]
    return scale * jnp.concatenate(velocities), x


def log_slope(
    structure: parts.Structure, chart: Chart, q: Q, scale: Float[Array, ""]
) -> Float[Array, ""]:
    """Log |d velocities / d z| at q, both vehicles."""
    total = 6 * jnp.log(scale)
    for sheet, x in zip(chart.sheets, _sheet_arguments(structure, q), strict=True):
        bend = 1 - (saturated(x[:3]) / REACH) ** 2
        J = sheet.linear[:, :3] + 2 * times(sheet.quadratic, saturated(x))[:, :3] * bend
        total += jnp.log(jnp.abs(jnp.dot(J[:, 0], jnp.cross(J[:, 1], J[:, 2]))))
    return total


def _sheet_arguments(structure: parts.Structure, q: Q) -> list[Float[Array, " k"]]:
    """(z, shaping inputs) of each vehicle."""
    shaping = [np.array(shaping_inputs(structure, v), dtype=int) for v in "ab"]
    return [jnp.concatenate([q[3 * i : 3 * i + 3], q[6 + s]]) for i, s in enumerate(shaping)]


def bounded(structure: parts.Structure, data: parts.Data, chart: Chart, q: Q) -> Float[Array, "4"]:
    """What e and e_m are ratios of, at q: e = -opening / closing, 1 - e_m = moment's spin / free spin.

    Unlike the ratios these are close to quadratic in q, and -opening = 0 is e = 0 exactly, no spin
    by the moment is e_m = 1 exactly.

    Returns:
        (-opening, spin by the moment, closing, spin by the force alone), m/s and rad/s.
    """
    separation, x = separation_of(structure, data, chart, q)
    bodies, approach_a = parts.bodies(x), parts.approach_of_a(x)
    approach_b, c = approach_and_coefficients(separation, approach_a, bodies)
    approach = jnp.concatenate([approach_a, approach_b])
    normal = jnp.stack([jnp.cos(bodies.Gamma), jnp.sin(bodies.Gamma)])
    closing = (contact_velocity(approach, bodies) * normal).sum()
    opening = (contact_velocity(separation, bodies) * normal).sum()
    _, M = impulse(approach, bodies, c)
    by_moment = M * (1 / bodies.I_a + 1 / bodies.I_b)
    free_spin = separation[5] - separation[2] + by_moment
    return jnp.stack([-opening, by_moment, closing, free_spin])


def squash(level: Levels, softness: Levels, low: Levels, high: Levels) -> Array:
    """From the whole line into (low, high); the identity away from them."""
    up = jax.nn.softplus((level - low) / softness) - jax.nn.softplus((level - high) / softness)
    return jnp.asarray(low + softness * up)


def unsquash(value: float, softness: float, low: float, high: float) -> float:
    """The level whose squashed value is `value`, strictly between low and high."""
    up, down = (value - low) / softness, (value - high) / softness
    return low + softness * float(np.log(np.expm1(up)) - np.log(-np.expm1(down)))


def log_squash_slope(level: Levels, softness: Levels, low: Levels, high: Levels) -> Array:
    """Log of squash's derivative."""
    # sigmoid(up) - sigmoid(-down), without cancellation
    slope = jax.nn.log_sigmoid((level - low) / softness)
    slope += jax.nn.log_sigmoid((high - level) / softness)
    return slope + jnp.log(-jnp.expm1((low - high) / softness))


def walls(chart: Chart, q: Q) -> tuple[Q, Float[Array, ""]]:
    """Bend q so that e and e_m, as expanded to second order, are squashed; also log |d bent / d q|.

    Along a line the expansion is a parabola, so the shift t that takes a level to its squashed value
    is the root of a quadratic equation, and d bent / d q has a closed form by differentiating it.
    """
    wall, total = chart.wall, jnp.zeros(())
    for i, (low, high) in enumerate(BOUNDS):
        away = q - wall.at
        slope = wall.gradient[i] + times(wall.hessian[i], away)
        level = wall.level[i] + ((wall.gradient[i] + slope) * away).sum() / 2
        excess = level - squash(level, wall.softness[i], low, high)
        rise = (slope * wall.along[i]).sum()
        bow = (wall.along[i] * times(wall.hessian[i], wall.along[i])).sum() / 2
        root = jnp.sqrt(jnp.maximum(rise**2 - 4 * bow * excess, _LEAST_RISE**2))
        rise = jnp.maximum(rise, _LEAST_RISE)
        q = q - 2 * excess / (rise + root) * wall.along[i]
        # root is the slope along the line where the bend ends
        total += log_squash_slope(level, wall.softness[i], low, high) + jnp.log(rise / root)
    return q, total


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
    q, log_det = walls(chart, jnp.asarray(chart.centre) + times(chart.spread, w))
    log_det += jnp.log(jnp.diag(chart.spread)).sum()
    separation, x = separation_of(structure, data, chart, q)
    log_sheets = log_slope(structure, chart, q, friction_scale(structure, data, x))
    (v_bx, v_by, omega_b), c, log_inverse = inverse_log_det(
        separation, parts.approach_of_a(x), parts.bodies(x)
    )
    # the bend knows e and e_m to second order: what it leaves out of bounds is squashed here
    raw, soft = jnp.stack([c.e, c.e_m]), _RESIDUE * chart.wall.softness
    e, e_m = squash(raw, soft, *BOUNDS.T)
    log_det += log_squash_slope(raw, soft, *BOUNDS.T).sum()
    speed = jnp.sqrt(v_bx**2 + v_by**2)
    direction = jnp.arctan2(v_by, v_bx)
    if "direction_b" in structure.known_of_b:
        middle = data.inputs["direction_b"][0]
        direction = middle + jnp.arctan2(jnp.sin(direction - middle), jnp.cos(direction - middle))
    sites = {"measured": q[6:]} if structure.uncertain else {}
    sites |= {"speed_b": speed, "direction_b": direction, "omega_b": omega_b}
    sites |= {"e": e, "mu": jnp.asarray(c.mu), "e_m": e_m}
    log_det += log_sheets + log_inverse - jnp.log(speed)
    return sites, log_det, q
