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

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.mechanics import approach_and_coefficients, inverse_log_det
from retrodict.models import parts

REACH = 4.0  # the quadratic's arguments saturate here (standard deviations), so it cannot fold
BOUNDS = np.array([[0.0, 1.0], [-1.0, 1.0]])  # of e and e_m
_ITERATIONS = 5
_TOLERANCE = 1e-8

Q = Float[Array, " q"]


class Sheet(NamedTuple):
    """A quadratic from (z, shaping inputs) to velocities over sqrt(friction).

    Args:
        constant: shape (3,).
        linear: shape (3, k).
        quadratic: shape (3, k, k), symmetric.
    """

    constant: Float[Array, "3"]
    linear: Float[Array, "3 k"]
    quadratic: Float[Array, "3 k k"]

    def __call__(self, x: Float[Array, " k"]) -> Float[Array, "3"]:
        """Its value at x."""
        s = saturated(x)
        return self.constant + times(self.linear, x) + times(times(self.quadratic, s), s)


def times(m: Float[Array, "*rows k"], x: Float[Array, " k"]) -> Float[Array, "*rows"]:
    """m @ x as a product and a sum: XLA compiles that four times faster than small matrix products."""
    return (m * x).sum(axis=-1)


def saturated(x: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """x, held within REACH: the argument of the quadratic terms, so that they cannot fold."""
    return REACH * jnp.tanh(x / REACH)


class Wall(NamedTuple):
    """How q is bent so that e and e_m stay within bounds.

    Args:
        at: where the bend is anchored, shape (q,).
        level: unbounded values of (e, e_m) there, shape (2,).
        gradient: of (e, e_m) in q there, shape (2, q).
        along: directions that move e and e_m one by one, shape (q, 2).
        softness: over which a bound is approached, shape (2,).
    """

    at: Q
    level: Float[Array, "2"]
    gradient: Float[Array, "2 q"]
    along: Float[Array, "q 2"]
    softness: Float[Array, "2"]


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
    centre: Q
    spread: Float[Array, "q q"]


def size(structure: parts.Structure) -> int:
    """Number of sampled coordinates."""
    return 6 + len(structure.uncertain)


def shaping_inputs(structure: parts.Structure, vehicle: str) -> list[int]:
    """Which uncertain inputs shape a vehicle's run-out, by index."""
    other = "_b" if vehicle == "a" else "_a"
    before = ("Gamma", "speed_a", "direction_a", "omega_a")
    return [i for i, n in enumerate(structure.names) if not n.endswith(other) and n not in before]


def friction_scale(structure: parts.Structure, data: parts.Data, x: parts.Values) -> Float[Array, ""]:
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


def bounded(
    structure: parts.Structure, data: parts.Data, chart: Chart, q: Q
) -> Float[Array, "2"]:
    """(e, e_m) at q."""
    separation, x = separation_of(structure, data, chart, q)
    _, c = approach_and_coefficients(separation, parts.approach_of_a(x), parts.bodies(x))
    return jnp.stack([c.e, c.e_m])


def squash(level: Float[Array, "2"], softness: Float[Array, "2"]) -> Float[Array, "2"]:
    """From the whole line into the bounds; the identity away from them."""
    low, high = BOUNDS.T
    up = jax.nn.softplus((level - low) / softness) - jax.nn.softplus((level - high) / softness)
    return low + softness * up


def walls(
    structure: parts.Structure, data: parts.Data, chart: Chart, q: Q
) -> tuple[Q, Float[Array, ""]]:
    """Bend q so that (e, e_m) = squash(their linear levels); also log |d bent / d q|."""
    wall = chart.wall
    level = wall.level + times(wall.gradient, q - wall.at)
    target = squash(level, wall.softness)
    at = lambda t: bounded(structure, data, chart, q + times(wall.along, t))  # noqa: E731

    # Newton finds the shift t. The iterations need no derivative: one last step from the
    # converged t carries the exact derivative of the solution (implicit function theorem)
    frozen = jax.lax.stop_gradient
    still = frozen((data, chart, q, target))

    def newton(_: int, t: Float[Array, "2"]) -> Float[Array, "2"]:
        data, chart, q, target = still
        at = lambda t: bounded(structure, data, chart, q + times(chart.wall.along, t))  # noqa: E731
        return t - _solve2(jax.jacfwd(at)(t), at(t) - target)

    t = frozen(jax.lax.fori_loop(0, _ITERATIONS, newton, target - level))
    miss = at(t) - target
    t = t - _solve2(frozen(jax.jacfwd(at)(t)), miss)
    slope = jax.jacfwd(at)(t)
    rise = jax.jvp(lambda v: squash(v, wall.softness), (level,), (jnp.ones(2),))[1]
    log_det = jnp.log(rise).sum() - jnp.log(jnp.abs(_det2(slope)))
    found = jnp.all(jnp.abs(miss) < _TOLERANCE)
    return q + times(wall.along, t), jnp.where(found, log_det, -jnp.inf)


def locate(
    structure: parts.Structure, data: parts.Data, chart: Chart, w: Q
) -> tuple[parts.Values, Float[Array, ""]]:
    """The model's unknowns at w, and log |d unknowns / d w|.

    Args:
        structure: of the scene.
        data: its numbers.
        chart: the numbers of the bijection.
        w: a point of the sampled space, shape (q,).

    Returns:
        A value for each of the model's sample sites, and the log determinant.
    """
    q, log_det = walls(structure, data, chart, chart.centre + times(chart.spread, w))
    log_det += jnp.log(jnp.diag(chart.spread)).sum()
    separation, x = separation_of(structure, data, chart, q)
    log_sheets = log_slope(structure, chart, q, friction_scale(structure, data, x))
    (v_bx, v_by, omega_b), c, log_inverse = inverse_log_det(
        separation, parts.approach_of_a(x), parts.bodies(x)
    )
    speed = jnp.sqrt(v_bx**2 + v_by**2)
    direction = jnp.arctan2(v_by, v_bx)
    if "direction_b" in structure.known_of_b:
        middle = data.inputs["direction_b"][0]
        direction = middle + jnp.arctan2(jnp.sin(direction - middle), jnp.cos(direction - middle))
    sites = {name: x[name] for name in structure.names}
    sites |= {"speed_b": speed, "direction_b": direction, "omega_b": omega_b}
    sites |= {"e": c.e, "mu": c.mu, "e_m": c.e_m}
    log_det += log_sheets + log_inverse + parts.log_scale(structure, data, q[6:]) - jnp.log(speed)
    return sites, log_det


def _det2(m: Float[Array, "2 2"]) -> Float[Array, ""]:
    return m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]


def _solve2(m: Float[Array, "2 2"], v: Float[Array, "2"]) -> Float[Array, "2"]:
    adjugate = jnp.array([[m[1, 1], -m[0, 1]], [-m[1, 0], m[0, 0]]])
    return times(adjugate, v) / _det2(m)
