"""The numbers that a transform is made of: records of arrays, which programs take as arguments."""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

REACH = 4.0  # the quadratic's arguments saturate here (standard deviations), so it cannot fold

Numbers = Array | np.ndarray
Q = Float[Array, " q"]


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


class Constraints(NamedTuple):
    """How q is constrained so that what the impact model bounds or holds is so.

    Args:
        side: sign of each bounded level's denominator (1 for others): the branch, shape (levels,).
        order: in which margins are constrained, as places in `margins`; all that follows has this order,
            shape (m,).
        margin: at the centre, shape (m,).
        slope: by q there, shape (m, q).
        along: for each a direction of q that moves it at rate 1 there and none before it, shape (m, q).
        across: for each a direction of the motion (velocities after the impact over sqrt(friction), then
            the deviate of A's speed where that is linear in it) that does, shape (m, v + 1).
        softness: over which zero is approached, shape (m,).
        kept: softness of the share of the sliding at zero, and what its entry of q is counted in.
    """

    side: Float[Numbers, " levels"]
    order: Int[Numbers, " m"]
    margin: Float[Numbers, " m"]
    slope: Float[Numbers, "m q"]
    along: Float[Numbers, "m q"]
    across: Float[Numbers, "m v+1"]
    softness: Float[Numbers, " m"]
    kept: Float[Numbers, ""]


class ResponseSurface(NamedTuple):
    """What a vehicle passes on its way to rest: a quadratic of its velocity and shaping inputs.

    Args:
        centre: velocity after the impact from which it counts, m/s and rad/s, shape (v,).
        unit: in which it counts, shape (v,).
        surface: the quadratic, whose values are those of `Structure.on_way_of`.
    """

    centre: Float[Numbers, " v"]
    unit: Float[Numbers, " v"]
    surface: Quadratic

    def __call__(self, velocity: Float[Array, " v"], shape: Float[Array, " inputs"]) -> Array:
        """The items, shape (items,)."""
        off = (velocity - jnp.asarray(self.centre)) / jnp.asarray(self.unit)
        return self.surface(jnp.concatenate([off, shape]))


class Flattening(NamedTuple):
    """The bijection v -> deviates: a shear of the directions that evidence pins, then axes.

    Args:
        peak: deviates at v = 0 without the shear, shape (n,).
        axes: columns, change of the deviates by v, those that are pinned the most first, shape (n, n).
        bend: shift of the first entries of v, by later ones that are not shifted themselves.
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
        sheared = np.linalg.solve(np.asarray(self.axes), off[..., None])[..., 0]
        return sheared - self._shift(sheared, np)

    def _shift(self, v: Float[Any, "*any n"], xp: ModuleType) -> Float[Any, "*any n"]:
        """Shift by the entries of v that are not shifted."""
        s, (constant, linear, quadratic) = saturated(v, xp), self.bend
        items, n = linear.shape
        # one product of matrices for all points
        by_s = (s @ xp.reshape(quadratic, (items * n, n)).T).reshape(*s.shape[:-1], items, n)
        shift = constant + v @ linear.T + (by_s * s[..., None, :]).sum(axis=-1)
        rest = v.shape[-1] - self.bend.constant.shape[0]
        return xp.concatenate([shift, xp.zeros((*v.shape[:-1], rest))], axis=-1)


class TransformParameters(NamedTuple):
    """The numbers of the bijection w -> q -> the model's unknowns, and of the slopes beside it.

    Args:
        regressions: the quadratics for A and B.
        constraints: on what the impact model bounds or holds.
        centre: q at w = 0, shape (q,).
        spread: q's change per w, shape (q, w); no column changes what is held, to first order.
        log_volume: log |det| of the spread and the directions of what is held together.
        responses: of each of `rest_pose.with_response_surface`.
        flattening: of standard normal deviates, where these are coordinates.
    """

    regressions: tuple[Quadratic, Quadratic]
    constraints: Constraints
    centre: Float[Numbers, " q"]
    spread: Float[Numbers, "q w"]
    log_volume: Float[Numbers, ""]
    responses: tuple[ResponseSurface, ...]
    flattening: Flattening | None = None


_NO_REGRESSIONS = (Quadratic(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0, 0))),) * 2
_NO_CONSTRAINTS = Constraints(
    *(np.zeros(0), np.zeros(0, int), np.zeros(0)),
    *(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0))),
    *(np.zeros(0), np.ones(())),
)


def plain(centre: Float[np.ndarray, " q"], spread: Float[np.ndarray, "q w"]) -> TransformParameters:
    """A transform without regressions or constraints: w counts from the centre along the spread."""
    volume = np.array(np.linalg.slogdet(spread)[1])
    return TransformParameters(_NO_REGRESSIONS, _NO_CONSTRAINTS, centre, spread, volume, ())


def unwhitened(
    parameters: TransformParameters, w: Float[Array, " w"]
) -> tuple[Q, Float[Array, ""]]:
    """q at w, and log |d q / d w|."""
    q = jnp.asarray(parameters.centre) + times(parameters.spread, w)
    return q, jnp.asarray(parameters.log_volume)
