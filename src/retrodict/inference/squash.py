"""A smooth way from the whole line into an interval, which leaves alone what lies well inside."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax.scipy.special import log_ndtr, ndtr
from jaxtyping import Array

Levels = Array | np.ndarray | float

_FAR = -8.0  # where the normal distribution function's integral goes over into its series


def squash(level: Levels, softness: Levels, low: Levels, high: Levels) -> Array:
    """From the whole line into (low, high); the identity away from them.

    Its slope is the normal distribution function of the distance to a bound in units of the
    softness, so that a density which a bound cuts short falls off beyond it as fast as a normal
    one. (The logistic function's slower fall cost importance sampling a third of all scenes.)
    """
    up = _ramp((level - low) / softness) - _ramp((level - high) / softness)
    return jnp.asarray(low + softness * up)


def log_squash_slope(level: Levels, softness: Levels, low: Levels, high: Levels) -> Array:
    """Log of squash's derivative."""
    above, below = (level - low) / softness, (level - high) / softness
    turn = above + below > 0  # to the side where the difference does not cancel
    more = log_ndtr(jnp.where(turn, -below, above))
    return more + jnp.log(-jnp.expm1(log_ndtr(jnp.where(turn, -above, below)) - more))


def _ramp(u: Levels) -> Array:
    """The integral of the normal distribution function up to u: near 0, then near u."""
    u = jnp.asarray(u)
    density = jnp.exp(-(u**2) / 2) / np.sqrt(2 * np.pi)
    far = jnp.minimum(u, _FAR) ** -2  # where the sum below would cancel
    tail = density * far * (1 - far * (3 - far * (15 - far * (105 - far * 945))))
    return jnp.where(u < _FAR, tail, density + u * ndtr(jnp.maximum(u, _FAR)))
