"""The density: exact in its value, near enough in its gradient to steer by; compiled once."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro.infer.util import log_density
from retrodict.models import RUNGS
from retrodict.models.arrays import steps_of

from retrodict.inference.density.log_density import Target
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.fitting.posterior import Posterior
from retrodict.studies.calibration import design
from tests.shared.scenes import at_rest, collision, rolls

RUNG, HELD = "planar-moment+wheels", "planar+spin"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    return prepare(collision(share=0.0, interlocked=True), RUNG)


@pytest.fixture(scope="module")
def wide() -> Posterior:
    """Of a crash that leaves e open, from 0.3 to 0.9."""
    rest = {"a": (-17.637, -0.541, 6.038), "b": (-28.639, -3.063, -1.607)}
    return prepare(at_rest(design(), rest), HELD)


@pytest.fixture(scope="module")
def rolling() -> Posterior:
    return prepare(rolls(collision(share=0.0), "b", (0.9, 0.3, 0.2, 0.2)), RUNG)


@cache
def differentiated(target: Target) -> Callable[..., tuple[jax.Array, jax.Array]]:
    """The potential and its gradient, by one program for all tests of a structure."""
    return jax.jit(jax.value_and_grad(target.potential))


def steered(posterior: Posterior, w: np.ndarray) -> tuple[jax.Array, jax.Array]:
    """The potential and its gradient at a point."""
    program = differentiated(posterior.programs.target)
    return program(w, posterior.data, posterior.transform)


@pytest.mark.parametrize(
    ("named", "near"),
    [
        ("posterior", 0.05),
        ("wide", 0.05),
        ("rolling", 0.1),
    ],
)
def test_the_value_is_the_models_and_the_gradient_is_close_to_its(
    named: str, near: float, request: pytest.FixtureRequest
) -> None:
    posterior: Posterior = request.getfixturevalue(named)
    structure, data, transform = posterior.programs.structure, posterior.data, posterior.transform

    @jax.jit
    def potential(w: jax.Array) -> jax.Array:
        """The model's own, its run-outs without surrogates."""
        sites, log_det, _ = transform.transform_and_log_det(structure, data, w)
        return -log_density(RUNGS[structure.rung].model, (structure, data), {}, sites)[0] - log_det

    rng, n = np.random.default_rng(0), posterior.size
    apart, h = [], 0.02
    for w in rng.normal(size=(20, n)):
        value, gradient = steered(posterior, w)
        assert value == pytest.approx(float(potential(jnp.array(w))), abs=1e-9)
        ends = [potential(jnp.array(w + h * step)) for step in (*np.eye(n), *-np.eye(n))]
        slope = (np.array(ends[:n]) - np.array(ends[n:])) / (2 * h)
        apart.append(np.linalg.norm(gradient - slope) / np.linalg.norm(slope))
    assert np.median(apart) < near


def test_a_gradient_is_cut_only_where_it_is_steeper_than_at_draws(posterior: Posterior) -> None:
    """NUTS leaps from where the potential is 50 to where it is thousands by a gradient that is not."""
    target, n = posterior.programs.target, posterior.size
    both = [jax.jit(jax.value_and_grad(f)) for f in (target.potential, target.steered)]
    rng, longest = np.random.default_rng(0), 3.0 * n**0.5
    for far, cut in ((1.0, False), (6.0, True)):
        for w in far * rng.normal(size=(5, n)):
            (value, slope), (same, shorter) = (
                f(w, posterior.data, posterior.transform) for f in both
            )
            assert same == value
            size = np.linalg.norm(slope)
            assert (size > longest) == cut
            np.testing.assert_allclose(shorter, slope * min(1.0, longest / size))


def test_slopes_and_curvatures_by_differences_are_the_gradients(posterior: Posterior) -> None:
    """A mode is sought by them, and chains and unsampled start from them."""
    h, n = 0.02, posterior.size
    for w in np.random.default_rng(2).normal(size=(3, n)):
        exact = steered(posterior, w)[1]
        np.testing.assert_allclose(posterior.potential(w)[1], exact, atol=0.02 * n**0.5)
        ends = [
            [steered(posterior, w + sign * h * step)[1] for step in np.eye(n)] for sign in (1, -1)
        ]
        rows = (np.array(ends[0]) - np.array(ends[1])) / (2 * h)
        np.testing.assert_allclose(posterior.potential.curvature(w), (rows + rows.T) / 2, atol=0.1)


def test_a_scene_that_takes_more_steps_compiles_nothing(posterior: Posterior) -> None:
    scene = collision(share=0.0, interlocked=True)
    sharp = {v: replace(p, x=replace(p.x, sd=p.x.sd / 30)) for v, p in scene.rest.items()}
    other = prepare(replace(scene, rest=sharp), RUNG)
    steps = [steps_of(p.programs.structure, p.data) for p in (posterior, other)]
    assert steps[0] < steps[1]
    assert other.programs is posterior.programs
