"""Friction of the ground under a wheel: one surface everywhere, others beyond straight edges."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

# A tyre straddles an edge over about its own width, so friction passes from one surface to the
# next over this length (m); it also keeps the rest pose differentiable in the edge's place.
TYRE_WIDTH = 0.2


class Zone(NamedTuple):
    """A half-plane: every point p with (p - point) @ inward > 0.

    Args:
        point: a point of the edge, m, shape (zones, 2).
        inward: unit normal of the edge, into the zone, shape (zones, 2).
    """

    point: Float[Array | np.ndarray, "zones 2"]
    inward: Float[Array | np.ndarray, "zones 2"]


def friction(
    position: Float[Array, "wheels 2"],
    speed: Float[Array, " wheels"],
    coefficients: Float[Array, " surfaces"],
    speed_dependence: Float[Array, " surfaces"] | None,
    zones: Zone,
) -> Float[Array, " wheels"]:
    """Sliding friction at each wheel: f exp(-c v) of the surface it is on.

    Args:
        position: of the wheels, m.
        speed: of their slip, m/s.
        coefficients: f of the surface that lies everywhere, then of each zone; later ones cover.
        speed_dependence: c, s/m, likewise; None where friction does not depend on speed.
        zones: the edges, one less than there are surfaces.

    Returns:
        Friction of each wheel, passing smoothly over a tyre's width at an edge.
    """
    of_surface = jnp.broadcast_to(coefficients, (*speed.shape, coefficients.shape[0]))
    if speed_dependence is not None:
        of_surface = of_surface * jnp.exp(-speed_dependence * speed[:, None])
    value = of_surface[:, 0]
    for i in range(zones.point.shape[0]):
        depth = ((position - zones.point[i]) * zones.inward[i]).sum(axis=1)
        s = jnp.clip(depth / TYRE_WIDTH + 0.5, 0.0, 1.0)
        value = value + s * s * (3 - 2 * s) * (of_surface[:, i + 1] - value)
    return value
