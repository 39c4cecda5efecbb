"""Standard normal deviates as coordinates: their determinants, and the posterior that they are of."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro import handlers
from numpyro.infer.util import log_density
from retrodict.models import RUNGS
from retrodict.models.arrays import in_steps
from retrodict.models.standard_normal import AtDeviates

from retrodict.inference.density.compiled import programs_for
from retrodict.inference.fitting.about_peak import crashes_of, prepare, unresolved
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.prior_check import reference
from retrodict.inference.samplers import METHODS, Task
from retrodict.inference.transforms.parameters import Affine
from retrodict.inference.transforms.standard import Deviates, unbent
from retrodict.scene.records import Approach, Mark, Measured, Scene
from tests.models.test_barrier import against_wall
from tests.models.test_rungs import agrees
from tests.shared.scenes import DEGREE, collision


def departed(**changes) -> Scene:
    """Motion after the impact in place of any rest pose, as it is under the paper's numbers."""
    a = {
        "direction": Measured(2.81, 0.05),
        "speed": Measured(7.4, 0.3),
        "yaw_rate": Measured(0.61, 0.2),
    }
    b = {
        "direction": Measured(-0.83, 0.05),
        "speed": Measured(8.0, 0.3),
        "yaw_rate": Measured(9.9, 0.3),
    }
    scene = replace(collision(berm=False), rest={}, departure={"a": a, "b": b})
    return replace(scene, **changes)


def course_known() -> Scene:
    scene = departed()
    b = Approach(None, Measured(-0.2, DEGREE), Measured(0.0, DEGREE))
    return replace(scene, approach=scene.approach | {"b": b})


def roughly_departed() -> Scene:
    """What happened after the impact is known to so little that crashes of the prior fit it."""
    a = {"direction": Measured(2.81, 0.4), "speed": Measured(7.4, 2.0)}
    b = {"direction": Measured(-0.83, 0.4), "speed": Measured(8.0, 2.0)}
    return departed(departure={"a": a, "b": b})


IMPACTS = ("momentum", "planar-common", "planar-moment-common", "planar", "planar-moment")
SCENES = {
    "departed": departed(),
    "course known": course_known(),
    "interlocked": departed(contact=replace(departed().contact, interlocked=True)),
    "wall": against_wall(),
}
QUICK = {("momentum", "departed")}


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    return prepare(departed(), "planar-moment+spin")


@pytest.mark.parametrize(
    ("impact", "which"),
    [
        pytest.param(impact, which, marks=() if (impact, which) in QUICK else pytest.mark.slow)
        for impact in IMPACTS
        for which in SCENES
        if (impact, which) != ("momentum", "wall")
    ],
)
def test_density_of_deviates_is_the_models_times_the_determinant(impact: str, which: str) -> None:
    """The model's joint at the unknowns, and the slopes of these by the deviates: nothing cancels."""
    rung = RUNGS[f"{impact}+spin"]
    structure, data = rung.of_scene(SCENES[which])
    assert structure.transform == "standard"
    crashes = crashes_of(SCENES[which], rung.name)
    u = np.random.default_rng(3).normal(size=(60, structure.deviates))
    log_likelihood = crashes.at(u)[0]
    chosen = np.flatnonzero(np.isfinite(log_likelihood))[:10]
    assert len(chosen) == 10

    def unknowns(u: jax.Array) -> tuple[jax.Array, dict[str, jax.Array]]:
        trace = handlers.trace(AtDeviates(rung.model, u)).get_trace(structure, data)
        sites = {
            k: s["value"]
            for k, s in trace.items()
            if s["type"] == "sample" and not s["is_observed"]
        }
        return jnp.concatenate([jnp.atleast_1d(v) for v in sites.values()]), sites

    @jax.jit
    @jax.vmap
    def both(u: jax.Array) -> tuple[jax.Array, jax.Array]:
        slopes, sites = jax.jacfwd(unknowns, has_aux=True)(u)
        return slopes, log_density(rung.model, (structure, data), {}, sites)[0]

    slopes, joint = both(u[chosen])
    expected = joint + np.linalg.slogdet(slopes)[1]
    log_prior = jax.scipy.stats.norm.logpdf(u[chosen]).sum(axis=1)
    np.testing.assert_allclose(log_prior + log_likelihood[chosen], expected, atol=1e-6)


@pytest.mark.slow
def test_log_determinant_is_that_of_the_map(posterior: Posterior) -> None:
    """From w to deviates, whitened by draws as well, in JAX and in NumPy."""
    rng = np.random.default_rng(0)
    whitened = posterior.whitened_by(rng.normal(size=(500, posterior.size)) * 1.3 + 0.2)
    structure, data = posterior.programs.structure, posterior.data
    for each in (posterior, whitened):
        located = partial(each.transform.transform_and_log_det, structure, data)
        for w in rng.normal(size=(3, each.size)):
            _, log_det, u = located(jnp.asarray(w))
            slopes = jax.jacfwd(located)(jnp.asarray(w))[2]
            assert float(log_det) == pytest.approx(np.linalg.slogdet(slopes)[1], abs=1e-9)
            np.testing.assert_allclose(each.deviates(w[None])[0], u, atol=1e-10)
            np.testing.assert_allclose(each.at_deviates(np.asarray(u)[None])[0], w, atol=1e-8)
    w = rng.normal(size=(4, posterior.size))
    there = posterior.converted_to(whitened, w)
    np.testing.assert_allclose(whitened.deviates(there), posterior.deviates(w), atol=1e-8)


@pytest.mark.slow
def test_the_compiled_density_and_its_gradient_are_those_of_batches(posterior: Posterior) -> None:
    """NUTS differentiates a program of its own, of a fixed number of steps."""
    fixed = posterior.differentiable()
    program = jax.jit(jax.value_and_grad(fixed.programs.target.potential))
    h, n = 1e-4, posterior.size
    for w in np.random.default_rng(1).normal(size=(3, n)):
        value, gradient = program(jnp.asarray(w), fixed.data, fixed.transform)
        assert value == pytest.approx(-fixed.log_density(w[None])[0], abs=1e-7)
        ends = -fixed.log_density(w + h * np.concatenate([np.eye(n), -np.eye(n)]))
        slope = (ends[:n] - ends[n:]) / (2 * h)
        np.testing.assert_allclose(gradient, slope, rtol=1e-3, atol=1e-3)


@pytest.mark.slow
def test_the_posterior_is_near_a_standard_normal_in_its_coordinates(posterior: Posterior) -> None:
    """Importance sampling from a standard normal wastes few draws."""
    w = np.random.default_rng(3).normal(size=(1000, posterior.size))
    log_weight = posterior.log_density(w) + (w**2).sum(axis=1) / 2
    weight = np.exp(log_weight - log_weight.max())
    assert weight.sum() ** 2 / (weight**2).sum() > 0.3 * len(w)


@pytest.mark.slow
@pytest.mark.parametrize("rung", ["planar-common+spin", "momentum+spin", "planar-moment+spin"])
def test_the_posterior_agrees_with_weights_in_the_models_unknowns(rung: str) -> None:
    agrees(departed(), rung)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["importance", "nuts"])
def test_the_posterior_is_that_of_weighted_crashes_of_the_prior(method: str) -> None:
    """Which need no coordinates, and cannot miss a part of it."""
    scene, rung = roughly_departed(), "planar-moment+spin"
    names = ("speed_b", "e", "e_m", "mu")
    sure = reference(crashes_of(scene, rung), names, seed=0)
    assert sure.effective > 300
    found = prepare(scene, rung)
    drawn = METHODS[method].draw(Task(found, 4, 1000, 300, 0, lambda *_: None))
    assert not drawn.faults
    known = drawn.known(found)
    for name in names:
        values = sure.quantities[name]
        mean = sure.weights @ values
        sd = np.sqrt(sure.weights @ (values - mean) ** 2)
        error = np.sqrt(1 / sure.effective + 1 / 1000)
        assert known[name].mean() == pytest.approx(mean, abs=4 * sd * error), name
        assert known[name].std() == pytest.approx(sd, rel=4 * error), name


@pytest.mark.slow
@pytest.mark.parametrize(("steps", "few"), [(3, True), (48, False)])
def test_steps_too_few_for_a_mark_are_seen(steps: int, few: bool) -> None:
    """No rest pose was measured: only the mark's distance from the path is informative."""
    scene = departed(marks={"b": (Mark(3.0, -4.0, 0.1, "centre"),)})
    structure, data = in_steps(*RUNGS["planar-moment+spin"].of_scene(scene), steps)
    found = prepare(scene, "planar-moment+spin")
    peak = found.deviates(np.zeros((1, found.size)))[0]
    n = peak.size
    flat = unbent(peak, np.eye(n), found.in_deviates.flattening.bend.constant.size)
    transform = Deviates(Affine.about(np.zeros(n), 0.01 * np.eye(n)), flat)
    coarse = Posterior(programs_for(structure), data, transform, np.zeros(2), 0.0, 0.0)
    assert (unresolved(coarse) > RESOLVED) is few


@pytest.mark.slow
def test_crashes_of_vehicles_that_part_have_no_density() -> None:
    crashes = crashes_of(departed(), "planar-moment+spin")
    u = np.random.default_rng(0).normal(size=(1000, crashes.size))
    log_likelihood, quantities = crashes.at(u)
    parting = quantities["closing_speed"] < 0
    assert parting.any()
    assert (log_likelihood[parting] == -np.inf).all()
    assert np.isfinite(log_likelihood[~parting]).all()
