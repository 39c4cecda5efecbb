"""A bound that a recorder measured before it stopped, against quadrature."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro.infer.util import log_density
from retrodict.models.at_least import AtLeast, AtMost
from scipy import integrate, stats

from retrodict.scene.records import FREEDOM, Measured
from tests.models.test_evidence import RUNG, SITES, trace_of
from tests.shared.scenes import collision

LAWS = {False: stats.norm, True: stats.t(FREEDOM)}
PLACES = [-9.0, -3.0, 2.0, 11.5, 12.0, 13.0, 25.0]


@pytest.mark.parametrize("kind", [AtLeast, AtMost])
@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize("bound", [12.0, -12.0])
@pytest.mark.parametrize("quantity", PLACES)
def test_the_likelihood_integrates_over_what_the_recorder_lost(
    quantity: float, bound: float, robust: bool, kind: type[AtLeast]
) -> None:
    """∫ p(b | q − u) du over all u ≥ 0, and the mean of q − u under it (of normal errors).

    At most: of q + u.
    """
    sd, sign = 1.3, np.sign(bound) if kind is AtLeast else -np.sign(bound)

    def density(lost: float) -> float:
        return LAWS[robust].pdf((sign * quantity - lost - sign * bound) / sd) / sd

    middle = max(0.0, sign * (quantity - bound))
    spans = [(0.0, middle), (middle, middle + 30 * sd), (middle + 30 * sd, np.inf)]
    total = sum(integrate.quad(density, *span, epsabs=0, limit=200)[0] for span in spans)
    law = kind(quantity, sd, bound, robust)
    assert float(law.log_prob(jnp.asarray(bound))) == pytest.approx(np.log(total), abs=1e-6)
    if not robust:
        moments = [integrate.quad(lambda u: u * density(u), *s, epsabs=0)[0] for s in spans[:2]]
        expected = sign * (sign * quantity - sum(moments) / total)
        assert float(law.mean) == pytest.approx(expected, abs=1e-6)


def test_the_slope_by_the_bound_is_the_residual_over_the_variance() -> None:
    def log_likelihood(bound: jax.Array) -> jax.Array:
        return AtLeast(11.0, 0.7, bound, False).log_prob(bound)

    slope = jax.grad(log_likelihood)(jnp.asarray(12.0))
    mean = AtLeast(11.0, 0.7, 12.0, False).mean
    assert float(slope) == pytest.approx(float(mean - 12.0) / 0.7**2)


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize("quantity", [-1e8, -1e3, 1e3, 1e8])
def test_far_away_it_and_its_slopes_are_finite(quantity: float, robust: bool) -> None:
    def log_likelihood(q: jax.Array) -> jax.Array:
        return AtLeast(q, 1.0, 12.0, robust).log_prob(jnp.asarray(12.0))

    value, slope = jax.value_and_grad(log_likelihood)(jnp.asarray(quantity))
    assert np.isfinite([value, slope]).all()


@pytest.mark.slow
def test_a_scene_weighs_each_component_from_zero_outwards() -> None:
    bounds = {
        "delta_v_at_least": Measured(9.0, 1.0),
        "delta_v_forward_at_least": Measured(-11.0, 1.5),
        "delta_v_left_at_least": Measured(-2.0, 0.5),
    }
    bare = collision(share=0.0, berm=False)
    scene = replace(bare, departure={"a": bounds})
    trace = trace_of(scene)
    full = {name.removesuffix("_at_least"): m for name, m in bounds.items()}
    predicted = trace_of(replace(bare, departure={"a": full}))
    sites = {k: jnp.asarray(v) for k, v in SITES.items()}
    for name, bound in bounds.items():
        q = float(predicted[f"departure_{name.removesuffix('_at_least')}_a"]["fn"].mean)
        beyond = np.sign(bound.value) * (q - bound.value) / bound.sd
        found = trace[f"departure_{name}_a"]
        assert float(found["fn"].log_prob(found["value"])) == pytest.approx(
            stats.norm.logcdf(beyond)
        ), name

    def density(of) -> float:
        structure, data = RUNG.of_scene(of)
        at = sites | {"measured": jnp.zeros(len(structure.uncertain))}
        return float(log_density(RUNG.model, (structure, data), {}, at)[0])

    items = [trace[f"departure_{name}_a"] for name in bounds]
    likelihood = sum(float(each["fn"].log_prob(each["value"])) for each in items)
    assert density(scene) - density(bare) == pytest.approx(likelihood)
