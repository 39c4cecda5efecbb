"""All unknowns of a model as standard normal deviates: a bijection, whatever the model and the scene."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array
from numpyro import handlers
from retrodict.models import RUNGS, parts, rungs_for
from retrodict.models.arrays import Data, Structure
from retrodict.models.friction import Friction
from retrodict.models.standard_normal import AtDeviates, DeviatesOf, sizes
from scipy import integrate, stats

from retrodict.scene.records import Scene
from tests.models.test_barrier import against_wall
from tests.models.test_friction import CRITICAL, friction
from tests.shared.scenes import collision, rolls

Unknowns = dict[str, np.ndarray]

DRAWS = 500
FULL = "planar-moment+spin"
JOINED = replace(collision(), contact=replace(collision().contact, together=True))
STRUCTURES: dict[str, tuple[Scene, str]] = {
    name: (scene, name) for scene in (collision(), JOINED) for name in rungs_for(scene)
}
STRUCTURES |= {
    f"{name} against a wall": (against_wall(), f"{name}+spin")
    for name in ("planar-common", "planar-moment-common", "planar", "planar-moment")
}
STRUCTURES |= {
    f"{name} interlocked": (collision(interlocked=True), f"{name}+spin")
    for name in ("planar", "planar-moment")
}
STRUCTURES |= {
    "interlocked against a wall": (
        replace(against_wall(), contact=replace(against_wall().contact, interlocked=True)),
        FULL,
    ),
    "nothing measured is uncertain": (collision(share=0.0), FULL),
    "wheels that roll": (rolls(collision(), "b", (0.9, 0.3, 0.2, 0.2)), "planar-moment+wheels"),
}
# the others: -m slow
SOME = [name if name == FULL else pytest.param(name, marks=pytest.mark.slow) for name in STRUCTURES]


def drawn(scene: Scene, rung: str) -> tuple[np.ndarray, np.ndarray, Unknowns, Unknowns]:
    """Of draws of the prior: which are allowed, their deviates, and the unknowns there and back.

    Of the impact alone: in a run-out nothing is sampled.
    """
    structure, data = RUNGS[rung].of_scene(scene)

    def model(structure: Structure, data: Data) -> None:
        x = parts.measured(structure, data)
        own = parts.as_recorded(structure, data, x)
        RUNGS[rung].impact.forward_model(structure, own, x)

    def unknowns(trace: dict) -> dict[str, Array]:
        return {
            k: s["value"]
            for k, s in trace.items()
            if s["type"] == "sample" and not s["is_observed"]
        }

    @jax.vmap  # compiled operation by operation, which structures share
    def one(key: Array) -> tuple[Array, Array, dict, dict]:
        trace = handlers.trace(handlers.seed(model, key)).get_trace(structure, data)
        values = unknowns(trace)
        allowed = jnp.ones((), bool)
        if parts.CLOSE_IN in trace:
            site = trace[parts.CLOSE_IN]
            allowed = jnp.isfinite(site["fn"].log_prob(site["value"]))
        there = DeviatesOf(model, values)
        there(structure, data)
        u = jnp.concatenate(there.deviates)
        back = handlers.trace(AtDeviates(model, u)).get_trace(structure, data)
        return allowed, u, values, unknowns(back)

    allowed, u, values, back = one(jax.random.split(jax.random.key(0), DRAWS))
    assert u.shape == (DRAWS, structure.deviates)
    assert list(values) == list(back)
    values, back = jax.tree.map(np.asarray, (values, back))
    return np.asarray(allowed), np.asarray(u), values, back


@pytest.mark.parametrize("which", SOME)
def test_crashes_have_deviates_and_come_back_from_them(which: str) -> None:
    allowed, u, values, back = drawn_of(which)
    assert 0.2 < allowed.mean() <= 1
    assert np.isfinite(u[allowed]).all()
    for name, value in values.items():
        np.testing.assert_allclose(
            back[name][allowed], value[allowed], rtol=1e-6, atol=1e-6, err_msg=name
        )


@pytest.mark.parametrize("which", SOME)
def test_deviates_of_the_prior_are_standard_normal(which: str) -> None:
    _, u, *_ = drawn_of(which)
    for i, column in enumerate(u.T):
        assert stats.kstest(column, stats.norm.cdf).pvalue > 1e-4, i
    # nor do they depend on each other
    apart = np.corrcoef(u.T) - np.eye(u.shape[1])
    assert np.abs(apart).max() < 5 / np.sqrt(DRAWS)


@pytest.mark.parametrize("rung", rungs_for(collision()))
def test_the_whole_model_samples_what_its_impact_does(rung: str) -> None:
    structure, data = RUNGS[rung].of_scene(collision())
    found: dict[str, int] = {}

    def trace(key: Array) -> Array:
        whole = handlers.trace(handlers.seed(RUNGS[rung].model, key)).get_trace(structure, data)
        for name, site in whole.items():
            if site["type"] == "sample" and not site["is_observed"]:
                found[name] = int(np.prod(site["value"].shape))
        return key

    jax.eval_shape(trace, jax.random.key(0))
    assert list(found.items()) == list(sizes(RUNGS[rung].impact, structure, data).items())
    assert structure.deviates == sum(found.values())


_KNOWN: dict[str, tuple] = {}


def drawn_of(which: str) -> tuple:
    """`drawn` of a structure, once for all tests."""
    if which not in _KNOWN:
        _KNOWN[which] = drawn(*STRUCTURES[which])
    return _KNOWN[which]


PROBABILITIES = jnp.array([1e-6, 1e-3, 0.02, 0.3, 0.5, 0.8, 0.97, 0.999, 1 - 1e-6])


@pytest.mark.parametrize("interlocked", [False, True])
@pytest.mark.parametrize("critical", CRITICAL)
def test_friction_has_the_probability_that_it_is_the_quantile_of(
    critical: float, interlocked: bool
) -> None:
    law = friction(critical, interlocked)
    mu = law.icdf(PROBABILITIES)
    assert (np.diff(np.asarray(mu) * np.sign(critical)) > 0).all()
    np.testing.assert_allclose(law.cdf(mu), PROBABILITIES, rtol=1e-9, atol=1e-12)
    again = law.icdf(law.cdf(mu))
    np.testing.assert_allclose(again, mu, rtol=1e-6)


@pytest.mark.parametrize("interlocked", [False, True])
@pytest.mark.parametrize("critical", CRITICAL)
def test_probabilities_of_friction_are_integrals_of_its_density(
    critical: float, interlocked: bool
) -> None:
    law = friction(critical, interlocked)
    shares = np.linspace(-2.5, 12.0 if interlocked else 1.0, 40_001)
    density = np.exp(law.log_prob(jnp.asarray(shares * critical))) * abs(critical)
    by_integral = integrate.cumulative_simpson(density, x=shares, initial=0.0)
    np.testing.assert_allclose(law.cdf(jnp.asarray(shares * critical)), by_integral, atol=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize("interlocked", [False, True])
@pytest.mark.parametrize("critical", CRITICAL)
def test_slopes_of_a_quantile_of_friction_are_those_of_differences(
    critical: float, interlocked: bool
) -> None:
    """By the probability, by the friction that ends the sliding, and by the prior's numbers."""

    def quantile(x: Array) -> Array:
        return Friction(x[1], x[2], x[3], interlocked).icdf(x[0])

    x = np.array([[p, critical, 0.2, 0.55] for p in (1e-3, 0.3, 0.8, 0.99)])
    slopes = jax.vmap(jax.jacfwd(quantile))(jnp.asarray(x))
    np.testing.assert_allclose(
        jax.vmap(jax.grad(quantile))(jnp.asarray(x)), slopes, rtol=1e-9, atol=1e-20
    )
    for i, step in enumerate(1e-4 * np.abs(x).T):
        moved = step[:, None] * np.eye(4)[i]
        before, after = (jax.vmap(quantile)(jnp.asarray(x + k * moved)) for k in (-1, 1))
        by_difference = (after - before) / (2 * step)
        scale = np.abs(before).max() / np.abs(x[:, i])  # of a relative change
        np.testing.assert_allclose(
            slopes[:, i] / scale, by_difference / scale, rtol=1e-3, atol=1e-5, err_msg=str(i)
        )
