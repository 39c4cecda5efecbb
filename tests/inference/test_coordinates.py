"""The coordinates: a bijection whose determinant is exact, with e and e_m inside their bounds."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.inference import coordinates
from retrodict.inference.posterior import Posterior, prepare
from tests.scenes import collision

OWN = ("speed_b", "direction_b", "omega_b", "e", "mu", "e_m")


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    return prepare(collision(share=0.0), "planar-moment-wheels")


def test_log_determinant_is_that_of_automatic_differentiation(posterior: Posterior) -> None:
    structure = posterior.programs.structure

    def unknowns(w: jax.Array) -> jax.Array:
        sites, _ = coordinates.locate(structure, posterior.data, posterior.chart, w)
        return jnp.stack([sites[name] for name in (*structure.names, *OWN)])

    jacobian, locate = jax.jit(jax.jacfwd(unknowns)), jax.jit(
        lambda w: coordinates.locate(structure, posterior.data, posterior.chart, w)[1]
    )
    rng = np.random.default_rng(0)
    for w in 1.5 * rng.normal(size=(20, posterior.chart.centre.size)):
        expected = np.linalg.slogdet(np.array(jacobian(jnp.array(w))))[1]
        assert float(locate(jnp.array(w))) == pytest.approx(expected, rel=1e-6)


def test_e_and_e_m_stay_within_bounds_however_far_out(posterior: Posterior) -> None:
    rng = np.random.default_rng(1)
    w = jnp.array(rng.normal(size=(500, posterior.chart.centre.size)) * 4)
    sites, log_det = posterior.programs("locate", posterior.data, posterior.chart, w)
    found = np.isfinite(np.array(log_det))
    assert found.mean() > 0.9  # beyond, the density is zero
    for name, (low, high) in zip(("e", "e_m"), coordinates.BOUNDS, strict=True):
        values = np.array(sites[name])[found]
        assert (values > low).all() and (values < high).all()


def test_squash_is_the_identity_away_from_the_bounds() -> None:
    softness = jnp.array([0.01, 0.02])
    level = jnp.array([0.5, -0.3])
    np.testing.assert_allclose(coordinates.squash(level, softness), level, atol=1e-6)
    far = np.array(coordinates.squash(jnp.array([-0.05, 1.1]), softness))
    assert 0 < far[0] < 1e-4
    assert 1 - 1e-3 < far[1] < 1


def test_the_posterior_is_near_a_standard_normal_in_its_coordinates(posterior: Posterior) -> None:
    """Importance sampling from a standard normal wastes few draws: what makes NUTS quick."""
    rng = np.random.default_rng(3)
    w = rng.normal(size=(300, posterior.chart.centre.size))
    log_weight = np.array([0.5 * (row**2).sum() - posterior.potential(row)[0] for row in w])
    weight = np.exp(log_weight - log_weight.max())
    assert weight.sum() ** 2 / (weight**2).sum() > 0.5 * len(w)


def test_gradient_agrees_with_differences(posterior: Posterior) -> None:
    w = 0.5 * np.random.default_rng(4).normal(size=posterior.chart.centre.size)
    _, gradient = posterior.potential(w)
    h = 1e-4
    for i in range(w.size):
        up, down = w.copy(), w.copy()
        up[i] += h
        down[i] -= h
        slope = (posterior.potential(up)[0] - posterior.potential(down)[0]) / (2 * h)
        assert gradient[i] == pytest.approx(slope, rel=1e-4, abs=1e-4)
