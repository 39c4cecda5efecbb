"""Nothing is lost at the bounds: the posterior is that of coordinates without constraints."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro.infer.util import log_density
from retrodict.models import RUNGS, parts

from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.transforms import layout
from retrodict.inference.transforms.choice import Coordinates
from retrodict.mechanics import closing_speed, inverse_log_det
from retrodict.options import DEFAULT_RUNG, RunOptions
from retrodict.studies.calibration import design
from tests.shared.random_scenes import scene
from tests.shared.scenes import at_rest


# e leans on 0; e_m on 1
@pytest.mark.slow
@pytest.mark.parametrize("seed", [205, 206])
def test_nuts_agrees_with_importance_sampling_that_rejects_at_the_bounds(seed: int) -> None:
    """q itself, drawn from a normal and cut off where e or e_m is out of bounds."""
    crash, _ = scene(np.random.default_rng(seed))
    found = reconstruct(crash, RunOptions(draws=1500))
    posterior = prepare(crash, DEFAULT_RUNG, Coordinates.SOLVED_BACK)
    structure, data, transform = posterior.programs.structure, posterior.data, posterior.transform

    @jax.jit
    @jax.vmap
    def evaluate(q: jax.Array) -> tuple[jax.Array, parts.Values]:
        sites = transform.solve_back(structure, data, q)
        after, x = layout.separation_at(structure, data, transform.regressions, q)
        scale = layout.friction_scale(structure, data, x)
        slopes = layout.reduced(structure, data, transform.regressions, q)[1]
        log_det = 6 * jnp.log(scale) + jnp.linalg.slogdet(slopes)[1].sum()
        bodies, approach_a = parts.bodies(x), parts.approach_of_a(x)
        log_det += inverse_log_det(after, approach_a, bodies)[2]
        inside = (sites["e"] > 0) & (sites["e"] < 1) & (jnp.abs(sites["e_m"]) < 1)
        held = {**sites, "e": jnp.clip(sites["e"], 1e-9, 1), "e_m": jnp.clip(sites["e_m"], -1, 1)}
        joint, _ = log_density(RUNGS[DEFAULT_RUNG].model, (structure, data), {}, held)
        return jnp.where(inside, joint + log_det - jnp.log(sites["speed_b"]), -jnp.inf), sites

    wide, count = 1.15, 20_000
    w = wide * np.random.default_rng(1).standard_normal((count, transform.whitening.size))
    log_weight, sites = evaluate(jnp.array(transform.whitening.transform(w)))
    log_weight = np.asarray(log_weight) + (w**2).sum(axis=1) / (2 * wide**2)
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    effective = min(1 / (weight**2).sum(), found.checks.min_ess_bulk)
    assert effective > 1000
    for name in ("speed_b", "e", "e_m", "mu"):
        order = np.argsort(sites[name])
        share = np.cumsum(weight[order])
        for level in (0.05, 0.5, 0.95):
            limit = np.asarray(sites[name])[order][np.searchsorted(share, level)]
            below = float(np.mean(found.idata["posterior"][name].values < limit))
            # five standard errors of both
            error = np.sqrt(2 * level * (1 - level) / effective)
            assert below == pytest.approx(level, abs=5 * error), (name, level)


@pytest.mark.slow
def test_nuts_does_not_diverge_where_e_m_is_wide() -> None:
    """While bounds were quotients, in 440 of 2000 draws; so did one random crash in five."""
    crash, _ = scene(np.random.default_rng(28))
    found = reconstruct(crash, RunOptions(model=DEFAULT_RUNG, draws=500))
    assert found.settings["method"] == "nuts"
    assert found.checks.divergences == 0
    assert float(found.idata["posterior"]["e_m"].std()) > 0.2


@pytest.mark.slow
def test_a_level_is_held_whatever_the_spin_by_the_force_alone() -> None:
    """As measured, this crash's spin and that by the force alone have opposite signs: e_m = -3."""
    rest = {"a": (-17.091, 4.382, 0.117), "b": (-29.75, 21.617, -8.343)}
    found = reconstruct(
        at_rest(design(), rest), RunOptions(model="planar+spin", method="importance")
    )
    assert found.checks.passed, found.checks.reasons
    draws = found.idata["posterior"].to_dataset()
    assert float((draws["Omega_b"] - draws["Omega_a"]).max()) < 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [229, 449])
def test_vehicles_close_in_where_as_measured_they_would_part(seed: int) -> None:
    """Where the measured values leave B so slow, or so fast, that an impulse would have to pull."""
    crash, truth = scene(np.random.default_rng(seed))
    posterior = prepare(crash, DEFAULT_RUNG, Coordinates.SOLVED_BACK)
    structure, data = posterior.programs.structure, posterior.data
    xi = np.zeros(len(structure.uncertain))
    x = parts.from_standard(structure, data, xi)
    sites = posterior.in_rest_poses.solve_back(
        structure,
        data,
        np.concatenate([np.zeros(len(structure.rest_components)), xi]),
    )
    direction = jnp.stack([jnp.cos(sites["direction_b"]), jnp.sin(sites["direction_b"])])
    of_b = jnp.append(sites["speed_b"] * direction, sites["omega_b"])
    before = jnp.concatenate([parts.approach_of_a(x), of_b])
    assert closing_speed(before, parts.bodies(x)) < 0
    found = reconstruct(crash, RunOptions(method="importance"))
    assert found.checks.passed, found.checks.reasons
    low, high = np.quantile(found.idata["posterior"]["speed_b"], [0.005, 0.995])
    assert low < truth["speed_b"] < high
