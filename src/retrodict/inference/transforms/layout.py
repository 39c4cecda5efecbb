"""The entries of rest-pose coordinates q = (z_a, z_b, xi), and the motion there by the regressions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.inference.transforms.parameters import (
    REACH,
    Numbers,
    Q,
    Regressions,
    saturated,
    times,
)
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import SLIDING, Level
from retrodict.scene.fields import APPROACH, flat_labels
from retrodict.scene.records import VEHICLES


def levels_of(structure: Structure) -> tuple[Level, ...]:
    """Levels that the impact model bounds or holds."""
    levels = RUNGS[structure.rung].impact.levels
    return tuple(b for b in levels if b != SLIDING or not structure.interlocked)


def margins(
    levels: Sequence[Level],
    side: Numbers,
    over: Numbers,
    under: Numbers,
    kept: Numbers | float = 0.0,
) -> list[Float[Numbers, "*any"]]:
    """Margins: one of each held level, which is zero; then those of the others, which stay above zero.

    A level that is not held has two margins: all near bounds come first, then all far bounds.

    Args:
        levels: quotients that the impact model bounds or holds.
        side: sign of each denominator, shape (levels,).
        over: numerators, or linear functions of them such as derivatives, shape (levels, ...).
        under: denominators, or the same linear functions of them, shape (levels, ...).
        kept: value at which the sampled level is held.
    """

    def beyond(i: int, bound: Numbers | float) -> Numbers:
        return over[i] - bound * under[i]

    held = [(i, kept if b.sampled else b.near) for i, b in enumerate(levels) if b.held]
    free = [(i, np.sign(b.far - b.near) * side[i]) for i, b in enumerate(levels) if not b.held]
    return [
        *(beyond(i, at) for i, at in held),
        *(way * beyond(i, levels[i].near) for i, way in free),
        *(-way * beyond(i, levels[i].far) for i, way in free),
    ]


def held_of(structure: Structure) -> int:
    """Number of held levels, whose margins come first."""
    return sum(level.held for level in levels_of(structure))


def samples_sliding(structure: Structure) -> bool:
    """Whether the last entry of q is the share of the sliding that is kept, before it is bounded."""
    return SLIDING in levels_of(structure)


def spins(structure: Structure) -> bool:
    """Whether B's yaw rate before the impact was measured, and follows from the motion after it."""
    return "omega_b" in structure.known_of_b and bool(levels_of(structure))


def length_for_regressions(structure: Structure) -> int:
    """Number of entries that regressions are fitted over: (z_a, z_b, xi)."""
    return len(structure.rest_components) + len(structure.uncertain)


def shaping_inputs(structure: Structure, vehicle: str) -> list[int]:
    """Indices of the uncertain inputs that shape a vehicle's run-out."""
    other = "_b" if vehicle == "a" else "_a"
    before = {f"{name}_{v}" for name in (*flat_labels(APPROACH), "time_zero") for v in VEHICLES}
    before.add("Gamma")
    return [i for i, n in enumerate(structure.names) if not n.endswith(other) and n not in before]


def place_of_speed_a(structure: Structure) -> int | None:
    """Index of the deviate of A's speed in q; None where the speed is not linear in such a deviate."""
    if ("speed_a", "normal") not in structure.uncertain:
        return None
    return len(structure.rest_components) + structure.names.index("speed_a")


def with_response_surface(structure: Structure) -> tuple[str, ...]:
    """Vehicles whose evidence along the path to rest is predicted by response surfaces.

    Used where a vehicle rolls: its adaptive steps have no reverse-mode derivatives.
    """
    if structure.steps or not structure.paced:
        return ()
    return tuple(v for v in VEHICLES if structure.on_way_of(v))


def split(structure: Structure, q: Q) -> tuple[Array, Array]:
    """z and xi of q."""
    n = len(structure.rest_components)
    return q[:n], q[n : n + len(structure.uncertain)]


def friction_scale(structure: Structure, data: Data, x: parts.Values) -> Float[Array, ""]:
    """sqrt(friction over its measured value): speeds scale with it, so the regressions need not."""
    name = f"friction_{structure.surfaces[0]}"
    value = data.inputs[name][0]
    if dict(structure.uncertain).get(name) == "lognormal":
        value = jnp.exp(value)
    return jnp.sqrt(x[name] / value)


def reduced(
    structure: Structure, data: Data, regressions: Regressions, q: Q
) -> tuple[Float[Array, " separation"], Float[Array, "2 v v"]]:
    """Velocities after the impact over sqrt(friction) at q, and each vehicle's slopes by its z."""
    velocities, slopes = [], []
    v = len(structure.rests)
    for name, regression, x in zip(
        VEHICLES, regressions, _regression_arguments(structure, q), strict=True
    ):
        if name in structure.inverted:
            V, by_z = _inverted(structure, data, q, name)
            velocities.append(V)
            slopes.append(by_z)
            continue
        velocities.append(regression(x))
        tame = 1 - (saturated(x[:v]) / REACH) ** 2
        constrained = 2 * times(regression.quadratic, saturated(x))[:, :v] * tame
        slopes.append(jnp.asarray(regression.linear)[:, :v] + constrained)
    return jnp.concatenate(velocities), jnp.stack(slopes)


def _inverted(
    structure: Structure, data: Data, q: Q, v: str
) -> tuple[Float[Array, " v"], Float[Array, "v v"]]:
    """`reduced` of a vehicle whose run-out has an inverse in closed form."""
    z, xi = split(structure, q)
    x = parts.from_standard(structure, data, xi)
    inverse = RUNGS[structure.rung].run_out.inverse
    assert inverse is not None, "its run-out is not integrated"
    back = inverse(structure, data, x, v)
    scale = friction_scale(structure, data, x)

    def velocity(own: Float[Array, " v"]) -> tuple[Array, Array]:
        every = z.reshape(2, -1).at[VEHICLES.index(v)].set(own)
        V = back(parts.rest_poses_at(structure, data, every.ravel())[VEHICLES.index(v)]) / scale
        return V, V

    by_z, V = jax.jacfwd(velocity, has_aux=True)(z.reshape(2, -1)[VEHICLES.index(v)])
    return V, by_z


def _regression_arguments(structure: Structure, q: Q) -> list[Float[Array, " k"]]:
    """(z, shaping inputs) of each vehicle."""
    z, xi = split(structure, q)
    shaping = [np.array(shaping_inputs(structure, v), dtype=int) for v in "ab"]
    return [jnp.concatenate([own, xi[s]]) for own, s in zip(z.reshape(2, -1), shaping, strict=True)]


def separation_at(
    structure: Structure, data: Data, regressions: Regressions, q: Q
) -> tuple[Float[Array, " separation"], parts.Values]:
    """Velocities after the impact, and measured inputs, at q."""
    x = parts.from_standard(structure, data, split(structure, q)[1])
    return friction_scale(structure, data, x) * reduced(structure, data, regressions, q)[0], x


def over(m: Float[Array, "n n"], b: Float[Numbers, "n k"]) -> Float[Array, "n k"]:
    """Inverse of m, of 2 or 3 rows, times b, written out: LAPACK's calls cannot be kept on disk."""
    if len(m) == 2:
        adjugate = jnp.array([[m[1, 1], -m[0, 1]], [-m[1, 0], m[0, 0]]])
    else:
        u, v, w = m.T
        adjugate = jnp.stack([jnp.cross(v, w), jnp.cross(w, u), jnp.cross(u, v)])
    return (adjugate @ b) / _det(m)


def log_det_of(m: Any) -> Float[Array, ""]:
    """log |det| of a matrix of two or three rows."""
    return jnp.log(jnp.abs(_det(m)))


def _det(m: Any) -> Float[Array, ""]:
    """Determinant of a matrix of two or three rows, written out without LAPACK."""
    if len(m) == 2:
        return m[0][0] * m[1][1] - m[0][1] * m[1][0]
    a, b, c = jnp.asarray(m).T
    return jnp.dot(a, jnp.cross(b, c))
