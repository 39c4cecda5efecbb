"""Friction of the ground under a wheel: one surface everywhere, others beyond edges or in polygons."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

# A tyre straddles an edge over about its own width, so friction passes from one surface to the
# next over this length (m); it also keeps the rest pose differentiable in the edge's place.
TYRE_WIDTH = 0.2


_TINY = 1e-18  # m²: a point on the outline has a derivative too

Polygon = Float[Array | np.ndarray, "corners 2"]
# one number for each surface in order; a number where there is but one
Coefficients = Float[Array | np.ndarray, " surfaces"] | Sequence[float] | float
# one number for each polygon in order; a number where all have the same
Insets = Float[Array | np.ndarray, " polygons"] | Sequence[float] | float


class Zone(NamedTuple):
    """A half-plane: every point p with (p - point) @ inward > 0.

    Args:
        point: a point of the edge, m, shape (zones, 2).
        inward: unit normal of the edge, into the zone, shape (zones, 2).
    """

    point: Float[Array | np.ndarray, "zones 2"]
    inward: Float[Array | np.ndarray, "zones 2"]


NO_ZONES = Zone(np.zeros((0, 2)), np.zeros((0, 2)))


def friction(
    x: Float[Array, " wheels"],
    y: Float[Array, " wheels"],
    speed: Float[Array, " wheels"],
    coefficients: Coefficients,
    speed_dependence: Coefficients | None,
    zones: Zone,
    polygons: tuple[Polygon, ...] = (),
    insets: Insets = 0.0,
) -> Float[Array, " wheels"]:
    """Sliding friction at each wheel: f exp(-c v) of the surface it is on.

    Args:
        x: x coordinate of each wheel, m.
        y: y coordinate of each wheel, m.
        speed: slip speed of each wheel, m/s.
        coefficients: f of the surface that lies everywhere, then of each zone, then of each
            polygon; later ones cover. A number where there is no other.
        speed_dependence: c of the same surfaces, s/m; None where friction does not depend on speed.
        zones: half-planes with a friction of their own.
        polygons: corners of each polygon, m, shape (corners, 2).
        insets: distance of each polygon's outline inwards of its corners, m.

    Returns:
        Friction of each wheel, passing smoothly over a tyre's width at an edge.
    """

    f = jnp.atleast_1d(jnp.asarray(coefficients))
    c = None if speed_dependence is None else jnp.atleast_1d(jnp.asarray(speed_dependence))

    def of_surface(i: int) -> Array:
        return f[i] if c is None else f[i] * jnp.exp(-c[i] * speed)

    depths = [(x - px) * nx + (y - py) * ny for (px, py), (nx, ny) in zip(*zones, strict=True)]
    inset = jnp.broadcast_to(jnp.asarray(insets), (len(polygons),))
    depths += [depth_in(polygon, x, y) - inset[i] for i, polygon in enumerate(polygons)]
    value = jnp.broadcast_to(of_surface(0), speed.shape)
    for i, depth in enumerate(depths, start=1):
        s = jnp.clip(depth / TYRE_WIDTH + 0.5, 0.0, 1.0)
        value = value + s * s * (3 - 2 * s) * (of_surface(i) - value)
    return value


def depth_in(
    polygon: Polygon, x: Float[Array, " points"], y: Float[Array, " points"]
) -> Float[Array, " points"]:
    """Distance of each point to the polygon's outline, m; negative outside."""
    x, y, polygon = x[:, None], y[:, None], jnp.asarray(polygon)
    (from_x, from_y), (to_x, to_y) = polygon.T, jnp.roll(polygon, -1, axis=0).T
    side_x, side_y = to_x - from_x, to_y - from_y
    along = ((x - from_x) * side_x + (y - from_y) * side_y) / (side_x**2 + side_y**2)
    along = jnp.clip(along, 0.0, 1.0)
    away2 = (x - from_x - along * side_x) ** 2 + (y - from_y - along * side_y) ** 2
    # a ray to the right of a point inside crosses the outline an odd number of times
    spans = (from_y > y) != (to_y > y)
    x_by_y = side_x / jnp.where(side_y == 0, 1.0, side_y)
    crossings = (spans & (x < from_x + x_by_y * (y - from_y))).sum(axis=1)
    return jnp.sqrt(away2.min(axis=1) + _TINY) * jnp.where(crossings % 2 == 1, 1.0, -1.0)
