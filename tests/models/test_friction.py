"""The prior of mu: its density against SciPy's, its draws against its density, where it ends."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from retrodict.models.friction import Friction
from scipy import integrate, stats

CRITICAL = (1e-3, 0.3, -1.0, 1.6, 5.0)
SCALE, MEDIAN = 0.2, 0.55


def friction(critical: float, interlocked: bool = False) -> Friction:
    return Friction(jnp.asarray(critical), jnp.asarray(SCALE), jnp.asarray(MEDIAN), interlocked)


def density(mu: float, critical: float) -> float:
    """By SciPy: sliding ends but for a half-normal share, or goes on and is cut at mu_c."""
    size, mu = abs(critical), mu * np.sign(critical)
    odds, other = (size / 2) ** 4, stats.fisk(5, scale=MEDIAN)
    ends = stats.halfnorm(scale=SCALE).pdf(1 - mu / size) / size
    goes_on = other.pdf(mu) / other.cdf(size) if mu < size else 0.0
    return (ends + odds * goes_on) / (1 + odds)


@pytest.mark.parametrize("critical", CRITICAL)
@pytest.mark.parametrize("share", [-0.1, 0.01, 0.4, 0.999, 1.001, 2.0])
def test_density_is_that_of_scipy(critical: float, share: float) -> None:
    mu = share * critical
    found = float(jnp.exp(friction(critical).log_prob(jnp.asarray(mu))))
    assert found == pytest.approx(density(mu, critical), rel=1e-9)


@pytest.mark.parametrize("interlocked", [False, True])
@pytest.mark.parametrize("critical", CRITICAL)
def test_draws_have_the_density(critical: float, interlocked: bool) -> None:
    law = friction(critical, interlocked)
    draws = np.sort(law.sample(jax.random.key(1), (4000,)) / critical)
    shares = np.linspace(-1.0, 12.0 if interlocked else 1.0, 20_001)
    by_share = np.exp(law.log_prob(jnp.asarray(shares * critical))) * abs(critical)
    cdf = integrate.cumulative_simpson(by_share, x=shares, initial=0.0)
    assert cdf[-1] == pytest.approx(1, abs=1e-3)
    assert stats.kstest(draws, lambda x: np.interp(x, shares, cdf)).pvalue > 1e-3


def test_nothing_reverses_the_sliding_unless_parts_interlock() -> None:
    for critical in CRITICAL:
        draws = friction(critical).sample(jax.random.key(2), (2000,))
        assert (draws / critical <= 1).all()
    draws = friction(0.3, interlocked=True).sample(jax.random.key(2), (2000,)) / 0.3
    assert 0.4 < (draws > 1).mean() < 0.6


@pytest.mark.parametrize("critical", [1e9, -1e9])
def test_where_no_friction_would_end_the_sliding_it_is_that_between_vehicles(
    critical: float,
) -> None:
    """SAE 970947: 0.55 as a rule, 0.3 to 1.0."""
    draws = np.sign(critical) * friction(critical).sample(jax.random.key(3), (20_000,))
    np.testing.assert_allclose(
        np.quantile(draws, [0.05, 0.5, 0.95]), [0.305, 0.55, 0.99], rtol=0.02
    )


@pytest.mark.slow
def test_without_sliding_there_is_no_friction_and_slopes_are_finite() -> None:
    law = friction(0.0)
    assert (jnp.abs(law.sample(jax.random.key(4), (10,))) < 1e-8).all()
    for critical in (*CRITICAL, 1e9):
        slopes = jax.grad(
            lambda c: friction(c).log_prob(0.3 * jnp.sign(c) * jnp.minimum(abs(c), 1))
        )
        assert jnp.isfinite(slopes(critical))
