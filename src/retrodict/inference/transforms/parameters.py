"""The parts of transforms: trees of arrays with their maps, which programs take as arguments."""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

REACH = 4.0  # saturation of the quadratic's arguments (standard deviations), so that it cannot fold

Numbers = Array | np.ndarray
Q = Float[Array, " q"]
Located = tuple[dict[str, Array], Float[Array, ""], Q]
"""A value for each of the model's sample sites, the log determinant of the map there, and q."""


class Affine(NamedTuple):
    """The bijection w -> q: from a standard normal's coordinates to those about a mode.

    Args:
        centre: q at w = 0, shape (q,).
        spread: q's change per w, shape (q, w); no column changes a held level, to first order.
        log_volume: log |det| of the matrix of the spread and the directions of the held levels.
    """

    centre: Float[Numbers, " q"]
    spread: Float[Numbers, "q w"]
    log_volume: Float[Numbers, ""]

    @classmethod
    def about(cls, centre: Float[np.ndarray, " q"], spread: Float[np.ndarray, "q q"]) -> Affine:
        """The bijection of a centre and a spread that holds no level."""
        return cls(centre, spread, np.array(np.linalg.slogdet(spread)[1]))

    @property
    def size(self) -> int:
        """Number of entries of w."""
        return self.spread.shape[1]

    def transform_and_log_det(self, w: Float[Array, " w"]) -> tuple[Q, Float[Array, ""]]:
        """q at w, and log |d q / d w|."""
        q = jnp.asarray(self.centre) + times(self.spread, w)
        return q, jnp.asarray(self.log_volume)

    def transform(self, w: Float[np.ndarray, "*any w"]) -> Float[np.ndarray, "*any q"]:
        """q at points w, in NumPy."""
        return np.asarray(self.centre) + w @ np.asarray(self.spread).T

    def inverse(self, q: Float[np.ndarray, "points q"]) -> Float[np.ndarray, "points w"]:
        """Points w at points q, where no level is held."""
        return np.linalg.solve(np.asarray(self.spread), (q - np.asarray(self.centre)).T).T


class Quadratic(NamedTuple):
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
        """Value of the quadratic at x."""
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


Regressions = tuple[Quadratic, Quadratic]
"""Velocities of A and B after the impact, over sqrt(friction), by (z, shaping inputs)."""


class Constraints(NamedTuple):
    """Constraints that keep q within what the impact model bounds, and at what it holds.

    Args:
        centre: q that margins are linear about, shape (q,).
        side: sign of each bounded level's denominator (1 for others): the branch, shape (levels,).
        order: order in which margins are constrained, as indices into `rest_pose.margins`; the arrays
            below follow it, shape (m,).
        margin: margins at the centre, shape (m,).
        slope: derivatives of the margins by q, shape (m, q).
        along: direction of q for each margin that moves it at rate 1 and none before it, shape (m, q).
        across: such a direction of the motion for each margin: velocities after the impact over
            sqrt(friction), then the deviate of A's speed where that is linear in it, shape (m, v + 1).
        softness: scale over which each margin approaches zero, shape (m,).
        kept: softness of the share of the sliding at zero, which is also the unit of its entry of q.
    """

    centre: Float[Numbers, " q"]
    side: Float[Numbers, " levels"]
    order: Int[Numbers, " m"]
    margin: Float[Numbers, " m"]
    slope: Float[Numbers, "m q"]
    along: Float[Numbers, "m q"]
    across: Float[Numbers, "m v+1"]
    softness: Float[Numbers, " m"]
    kept: Float[Numbers, ""]


class ResponseSurface(NamedTuple):
    """Predictions along a vehicle's path to rest: a quadratic of its velocity and shaping inputs.

    Args:
        centre: velocity after the impact at the surface's origin, m/s and rad/s, shape (v,).
        unit: scale of each velocity component, m/s and rad/s, shape (v,).
        surface: quadratic whose values are the items of `Structure.on_way_of`.
    """

    centre: Float[Numbers, " v"]
    unit: Float[Numbers, " v"]
    surface: Quadratic

    def __call__(self, velocity: Float[Array, " v"], shape: Float[Array, " inputs"]) -> Array:
        """Predictions of the items, shape (items,)."""
        off = (velocity - jnp.asarray(self.centre)) / jnp.asarray(self.unit)
        return self.surface(jnp.concatenate([off, shape]))


class Flattening(NamedTuple):
    """The bijection v -> deviates: a shear of the directions that evidence pins, then axes.

    Args:
        peak: deviates at v = 0 without the shear, shape (n,).
        axes: derivatives of the deviates by v, the columns that are pinned the most first, shape (n, n).
        bend: shift of the first entries of v, as a function of the later ones, which are not shifted.
        log_volume: log |det axes|.
    """

    peak: Float[Numbers, " n"]
    axes: Float[Numbers, "n n"]
    bend: Quadratic
    log_volume: Float[Numbers, ""]

    def deviates(self, v: Float[Any, "*any n"], xp: ModuleType = jnp) -> Float[Any, "*any n"]:
        """Deviates at points v, in JAX or in NumPy."""
        sheared = v + self._shift(v, xp)
        return self.peak + sheared @ self.axes.T

    def inverse(self, deviates: Float[np.ndarray, "*any n"]) -> Float[np.ndarray, "*any n"]:
        """Points v at deviates."""
        off = np.asarray(deviates) - np.asarray(self.peak)
        # points as columns, for one factorisation: with an axis of their own each would have its own
        columns = np.linalg.solve(np.asarray(self.axes), off.reshape(-1, off.shape[-1]).T)
        sheared = columns.T.reshape(off.shape)
        return sheared - self._shift(sheared, np)

    def _shift(self, v: Float[Any, "*any n"], xp: ModuleType) -> Float[Any, "*any n"]:
        """Shift of v, a function of the entries that are not shifted."""
        s, (constant, linear, quadratic) = saturated(v, xp), self.bend
        items, n = linear.shape
        # one product of matrices for all points
        by_s = (s @ xp.reshape(quadratic, (items * n, n)).T).reshape(*s.shape[:-1], items, n)
        shift = constant + v @ linear.T + (by_s * s[..., None, :]).sum(axis=-1)
        rest = v.shape[-1] - self.bend.constant.shape[0]
        return xp.concatenate([shift, xp.zeros((*v.shape[:-1], rest))], axis=-1)
