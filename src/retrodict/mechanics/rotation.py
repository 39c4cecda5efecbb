"""Vectorised cosine and sine."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

# pi/2 in two parts, the first of 33 bits, so that a quarter turn's multiples subtract without loss
_QUARTER, _REST = 1.57079632673412561417e00, 6.07710050650619224932e-11
# minimax polynomials on a quarter turn about zero, in powers of the angle's square, from the
# highest (Cody and Waite, Software Manual for the Elementary Functions, 1980; values as in fdlibm)
# fmt: off
_SINE = (
    1.58969099521155010221e-10, -2.50507602534068634195e-08, 2.75573137070700676789e-06,
    -1.98412698298579493134e-04, 8.33333333332248946124e-03, -1.66666666666666324348e-01,
)
_COSINE = (
    -1.13596475577881948265e-11, 2.08757232129817482790e-09, -2.75573143513906633035e-07,
    2.48015872894767294178e-05, -1.38888888888741095749e-03, 4.16666666666666019037e-02,
)
# fmt: on


@jax.custom_jvp
def cos_sin(angle: Float[Array, "*any"]) -> tuple[Float[Array, "*any"], Float[Array, "*any"]]:
    """Cosine and sine, to an ulp or two up to a million turns.

    XLA calls the C library for each number, which took two thirds of the time of a batch of run-outs
    (`python -m benchmarks` charts the run-out).

    Args:
        angle: angle, rad, of any shape.

    Returns:
        (cosine, sine).
    """
    turns = jnp.round(angle * (2 / jnp.pi))
    x = (angle - turns * _QUARTER) - turns * _REST
    z = x * x
    sine = x + x * z * _polynomial(_SINE, z)
    cosine = 1 - z / 2 + z * z * _polynomial(_COSINE, z)
    quarter = turns - 4 * jnp.floor(turns / 4)
    odd = (quarter == 1) | (quarter == 3)
    c, s = jnp.where(odd, sine, cosine), jnp.where(odd, cosine, sine)
    return jnp.where((quarter == 1) | (quarter == 2), -c, c), jnp.where(quarter >= 2, -s, s)


@cos_sin.defjvp
def _(
    primals: tuple[Array], tangents: tuple[Array]
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    c, s = cos_sin(*primals)
    return (c, s), (-s * tangents[0], c * tangents[0])


def _polynomial(coefficients: tuple[float, ...], z: Array) -> Array:
    value = jnp.full_like(z, coefficients[0])
    for coefficient in coefficients[1:]:
        value = value * z + coefficient
    return value
