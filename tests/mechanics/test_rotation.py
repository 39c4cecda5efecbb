"""Our cosine and sine against NumPy's."""

import jax
import numpy as np

from retrodict.mechanics.rotation import cos_sin


def test_they_are_numpys_to_an_ulp_or_two() -> None:
    rng = np.random.default_rng(0)
    quarters = np.arange(-2000, 2001) * np.pi / 2
    angle = np.concatenate([rng.uniform(-1e3, 1e3, 20000), quarters, quarters + np.pi / 4, [0.0]])
    found = jax.jit(cos_sin)(angle)
    np.testing.assert_allclose(found, [np.cos(angle), np.sin(angle)], rtol=0, atol=4e-16)
    far = rng.uniform(-6e6, 6e6, 20000)
    np.testing.assert_allclose(cos_sin(far), [np.cos(far), np.sin(far)], rtol=0, atol=2e-15)


def test_derivatives_are_theirs() -> None:
    angle = np.random.default_rng(1).uniform(-30, 30, 100)
    _, slopes = jax.jvp(cos_sin, (angle,), (np.ones(100),))
    np.testing.assert_allclose(slopes, [-np.sin(angle), np.cos(angle)], atol=1e-15)
    second = jax.vmap(jax.grad(jax.grad(lambda a: cos_sin(a)[0])))(angle)
    np.testing.assert_allclose(second, -np.cos(angle), atol=1e-15)
