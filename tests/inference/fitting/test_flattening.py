"""Coordinates bent with a posterior: a bijection that keeps volume but for its axes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.inference.fitting.about_peak import crashes_of
from retrodict.inference.fitting.flattening import flattened
from retrodict.inference.fitting.search import peaks
from retrodict.inference.transforms.parameters import Flattening, Quadratic
from retrodict.inference.transforms.standard import unbent
from tests.shared.scenes import collision

SIZE, ITEMS = 7, 3


def flattening(seed: int) -> Flattening:
    """Three entries shifted by quadratics of the other four."""
    rng = np.random.default_rng(seed)
    linear, quadratic = np.zeros((ITEMS, SIZE)), np.zeros((ITEMS, SIZE, SIZE))
    linear[:, ITEMS:] = rng.normal(size=(ITEMS, SIZE - ITEMS))
    own = rng.normal(size=(ITEMS, SIZE - ITEMS, SIZE - ITEMS))
    quadratic[:, ITEMS:, ITEMS:] = own + own.swapaxes(1, 2)
    flat = unbent(rng.normal(size=SIZE), rng.normal(size=(SIZE, SIZE)), ITEMS)
    return flat._replace(bend=Quadratic(rng.normal(size=ITEMS), linear, quadratic))


@pytest.mark.parametrize("seed", range(3))
def test_the_inverse_leads_back(seed: int) -> None:
    flat, v = flattening(seed), 3 * np.random.default_rng(9).normal(size=(50, SIZE))
    np.testing.assert_allclose(flat.inverse(flat.deviates(v, np)), v, atol=1e-9)
    u = flat.deviates(v, np)
    np.testing.assert_allclose(flat.deviates(flat.inverse(u), np), u, atol=1e-9)
    np.testing.assert_allclose(flat.inverse(u[0]), v[0], atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_log_determinant_is_that_of_the_jacobian(seed: int) -> None:
    flat = flattening(seed)
    for v in 2 * np.random.default_rng(8).normal(size=(5, SIZE)):
        slopes = jax.jacfwd(flat.deviates)(jnp.asarray(v))
        assert float(flat.log_volume) == pytest.approx(np.linalg.slogdet(slopes)[1], abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_jax_and_numpy_agree(seed: int) -> None:
    flat, v = flattening(seed), 2 * np.random.default_rng(7).normal(size=(20, SIZE))
    own = flat.deviates(v, np)
    assert isinstance(own, np.ndarray)
    np.testing.assert_allclose(flat.deviates(jnp.asarray(v)), own, atol=1e-12)
    np.testing.assert_allclose(flat.deviates(jnp.asarray(v[0])), own[0], atol=1e-12)


@pytest.mark.slow
def test_a_flattening_about_a_peak_makes_the_posterior_flat() -> None:
    """The paper's scene: of draws of a standard normal more are effective than without the bend."""
    crashes = crashes_of(collision(share=0.0), "planar-moment+spin")
    peak = peaks(crashes, seed=0)[0]
    flat = flattened(crashes, peak, seed=0)
    np.testing.assert_array_equal(flat.peak, peak.u)
    v = np.random.default_rng(0).normal(size=(2000, peak.u.size))

    def effective(flat: Flattening) -> float:
        u = flat.deviates(v, np)
        log_weight = crashes.at(u)[0] - np.square(u).sum(axis=1) / 2 + np.square(v).sum(axis=1) / 2
        weight = np.exp(log_weight - log_weight.max())
        return float(weight.sum() ** 2 / np.square(weight).sum()) / len(v)

    straight = unbent(flat.peak, flat.axes, flat.bend.constant.size)
    bent = effective(flat)
    assert bent > 0.5
    assert bent > effective(straight) + 0.1
