"""Smooth map of the real line to the values above zero.

It is close to the identity away from zero. Its slope is the normal distribution function of
the distance to a bound in units of the softness, so that a density which a bound truncates falls off
beyond it as fast as a normal one. (The logistic function's slower fall cost importance
sampling a third of all scenes.)
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.special import log_ndtr, ndtr
from jaxtyping import Array, Float
from scipy import special  # scipy.stats takes long to import

Levels = Array | np.ndarray | float

_FAR = -8.0  # where the normal distribution function's integral goes over into its series


def soft_lower_bound(level: Levels, softness: Levels) -> tuple[Array, Array]:
    """Map of the real line to above zero, the identity away from zero; and the log of its slope."""
    rise, log_slope = _ramp(jnp.asarray(level / softness))
    return jnp.asarray(softness * rise), log_slope


def soft_lower_bound_inverse(level: float, softness: float) -> float:
    """Approximate inverse of `soft_lower_bound`; its result is limited to 60 times the softness."""
    before = np.linspace(-6.0, 60.0, 2000)
    return softness * float(np.interp(level / softness, raised(before), before))


def raised(level: float | np.ndarray) -> Any:
    """`soft_lower_bound` of a softness of one, in NumPy."""
    return np.exp(-(level**2) / 2) / np.sqrt(2 * np.pi) + level * special.ndtr(level)


def softness_for(sd: Levels, level: Levels) -> Levels:
    """Softness of the bound of a quantity of standard deviation `sd`, whose bounded value is `level`.

    A normal truncated at zero, wherever its mean, is then close to a normal again in the unbounded
    coordinate: importance sampling from a normal wastes 3 % of its draws at most. A softness equal to
    `sd` would waste 40 % where the truncation is far above the mean.
    """
    return sd * np.clip(1.3 - 0.3 * level / sd, 0.6, 1.25)


@jax.custom_jvp
def _ramp(u: Float[Array, "*any"]) -> tuple[Array, Array]:
    """The integral of the normal distribution function up to u, and log of its slope there."""
    # near 0, then near u
    density = jnp.exp(-(u**2) / 2) / np.sqrt(2 * np.pi)
    far = jnp.minimum(u, _FAR) ** -2  # where the sum below would cancel
    tail = density * far * (1 - far * (3 - far * (15 - far * (105 - far * 945))))
    return jnp.where(u < _FAR, tail, density + u * ndtr(jnp.maximum(u, _FAR))), log_ndtr(u)


@_ramp.defjvp
def _(primals: tuple[Any], tangents: tuple[Any]) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    (u,), (du,) = primals, tangents
    rise, log_slope = _ramp(u)
    share = jnp.exp(-(u**2) / 2 - log_slope) / np.sqrt(2 * np.pi)
    return (rise, log_slope), (ndtr(u) * du, share * du)
