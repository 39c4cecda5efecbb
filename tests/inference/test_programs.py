"""The compiled density: exact in its value, near enough in its gradient to steer by."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro.infer.util import log_density
from retrodict.models import RUNGS

from retrodict.inference import coordinates
from retrodict.inference.posterior import Posterior, prepare
from tests.scenes import collision

RUNG = "planar-moment-wheels"


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    return prepare(collision(share=0.0), RUNG)


def test_the_value_is_the_models_and_the_gradient_is_close_to_its(posterior: Posterior) -> None:
    structure, data, chart = posterior.programs.structure, posterior.data, posterior.chart

    def potential(w: jax.Array) -> jax.Array:
        """By the run-outs themselves, differentiated."""
        sites, log_det, _ = coordinates.locate(structure, data, chart, w)
        return -log_density(RUNGS[RUNG].model, (structure, data), {}, sites)[0] - log_det

    exact = jax.jit(jax.value_and_grad(potential))
    rng = np.random.default_rng(0)
    apart = []
    for w in rng.normal(size=(20, chart.centre.size)):
        value, gradient = posterior.potential(w)
        expected, slope = exact(jnp.array(w))
        # the bend's determinant comes from difference quotients, which keep ten digits or so
        assert value == pytest.approx(float(expected), abs=1e-8)
        apart.append(np.linalg.norm(gradient - slope) / np.linalg.norm(slope))
    assert np.median(apart) < 0.05
