"""Priors of the user's own: each family is SciPy's, and a posterior under it is that by quadrature."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from retrodict.models.model import RUNGS
from retrodict.models.priors import Beta, Cut, deviate, given, quantile
from scipy import stats

from retrodict.inference.modes import ModeSearch
from retrodict.inference.points import answer
from tests.shared import wall_by_hand as by_hand

# one family by default
FAMILIES = {
    name: name if name == "lognormal" else pytest.param(name, marks=pytest.mark.slow)
    for name in by_hand.FAMILIES
}
PROBABILITIES = np.array([1e-6, 1e-3, 0.02, 0.3, 0.5, 0.8, 0.97, 0.999, 1 - 1e-6])


@pytest.mark.slow
@pytest.mark.parametrize("family", ["normal", "lognormal", "uniform", "beta"])
def test_quantiles_are_those_of_scipy_and_come_back(family: str) -> None:
    priors = by_hand.FAMILIES[family]
    structure, data = RUNGS[by_hand.MODEL].of_scene(by_hand.scene(priors))
    for name, (own, numbers) in priors.items():
        law = given(name, structure, data)
        assert law is not None
        expected = by_hand.law(name, own, numbers)(PROBABILITIES)
        u = jnp.asarray(stats.norm.ppf(PROBABILITIES))
        found = jax.vmap(lambda x, law=law: quantile(law, x))(u)
        np.testing.assert_allclose(found, expected, rtol=1e-8, err_msg=name)
        np.testing.assert_allclose(deviate(law, found), u, atol=1e-6, err_msg=name)
        # the density is the slope of the probability
        inner = found[1:-1]
        slope = jax.vmap(jax.grad(lambda x, law=law: quantile(law, x)))(u[1:-1])
        density = np.exp(np.asarray(law.log_prob(inner)))
        np.testing.assert_allclose(
            density * slope, stats.norm.pdf(np.asarray(u[1:-1])), rtol=1e-6, err_msg=name
        )


def test_a_cut_law_has_no_probability_beyond_its_bounds() -> None:
    from numpyro import distributions as dist

    law = Cut(dist.LogNormal(jnp.log(0.5), 1.0), 0.0, 1.0)
    assert float(law.log_prob(jnp.array(1.01))) == -math.inf
    assert float(law.cdf(jnp.array(1.0))) == 1.0
    draws = np.asarray(law.sample(jax.random.key(0), (4000,)))
    assert draws.max() <= 1
    assert stats.kstest(draws, lambda x: np.asarray(law.cdf(jnp.asarray(x)))).pvalue > 1e-3


def test_a_beta_has_the_quantiles_that_its_own_class_lacks() -> None:
    found = Beta(0.7, 3.0).icdf(jnp.asarray(PROBABILITIES))
    np.testing.assert_allclose(found, stats.beta(0.7, 3.0).ppf(PROBABILITIES), rtol=1e-9)


@pytest.mark.parametrize("family", FAMILIES.values())
def test_a_posterior_is_that_by_quadrature(family: str) -> None:
    """Weighted points, and crashes of the prior weighted by the evidence, against the closed form."""
    priors = by_hand.FAMILIES[family]
    scene = by_hand.scene(priors)
    expected = by_hand.posterior(scene, priors)
    estimate = answer(scene, by_hand.MODEL)
    assert estimate.checks.passed, estimate.checks.reasons
    reference = ModeSearch(scene, 0).reference(by_hand.MODEL)
    assert reference.effective > 100
    asked = [name for name, (own, _) in priors.items() if own != "fixed"]
    assert scene.reported() == tuple(asked)
    for name in asked:
        values = estimate.quantities[name]
        for found, error, exact in (
            (*estimate.weighted.mean(values), expected.mean[name]),
            (*estimate.weighted.sd(values), expected.sd[name]),
        ):
            assert found == pytest.approx(exact, abs=5 * error + 1e-3 * expected.sd[name]), name
        crashes = reference.quantities[name]
        mean = reference.weights @ crashes
        error = math.sqrt(np.sum((reference.weights * (crashes - mean)) ** 2))
        assert mean == pytest.approx(expected.mean[name], abs=5 * error), name
    for name in priors.keys() - set(asked):  # a friction that is fixed is |mu| up to |mu_c|
        mean, error = estimate.weighted.mean(estimate.quantities[name])
        assert mean == pytest.approx(expected.mean[name], abs=5 * error + 1e-9), name
