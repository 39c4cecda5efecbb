"""The posterior given to samplers of others is ours: the same density, and the same draws by NumPyro."""

from __future__ import annotations

from functools import cache
from typing import Any, Literal

import jax
import numpy as np
import numpyro
import pytest
from numpyro import distributions as dist
from numpyro import handlers
from numpyro.diagnostics import effective_sample_size, split_gelman_rubin
from numpyro.infer import MCMC, NUTS
from numpyro.infer.util import log_density as log_joint

import retrodict as rd
from tests.shared.scenes import collision

MODEL = "planar-moment+spin"
SCENES = {
    "paper": ("examples/brach-1977/scene.toml", MODEL),
    "berm": ("examples/brach-1977-berm/scene.toml", MODEL),
    "delta-v": ("benchmarks/users/scenes/rear-end-delta-v.toml", MODEL),
    "slow": ("benchmarks/users/scenes/slow-side-22.toml", MODEL),
    "rolling": ("benchmarks/users/scenes/coasting.toml", "planar-common+wheels"),
}
Kind = Literal["auto", "deviates"]


def asked(found: dict[str, np.ndarray]) -> list[str]:
    """Quantities that are compared; of a model without friction or moment impulse of its own, fewer."""
    return [name for name in ("speed_b", "e", "e_m", "mu") if name in found]


@cache
def density(kind: Kind) -> rd.LogDensity:
    return rd.log_density(collision(berm=False), model=MODEL, coordinates=kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["auto", "deviates"])
def test_the_density_is_that_of_the_model_times_the_jacobian(kind: Kind) -> None:
    own, rng = density(kind), np.random.default_rng(0)
    model = rd.NumpyroModel(own)
    samples = handlers.trace(handlers.seed(model.plain, 0)).get_trace()
    latent = [k for k, s in samples.items() if s["type"] == "sample" and not s["is_observed"]]

    @jax.jit
    def three(w: jax.Array, sites: dict[str, jax.Array]) -> tuple[jax.Array, ...]:
        joint = log_joint(model.plain, (), {}, sites)[0]
        return own(w), joint + own.log_det(w), log_joint(model, (), {}, {"w": w})[0]

    for _ in range(3):
        w = 0.7 * rng.standard_normal(own.size)
        found = own.unknowns(w)
        value, *others = map(float, three(w, {name: found[name] for name in latent}))
        assert others == pytest.approx([value, value], abs=1e-9)


@pytest.mark.slow
def test_deviates_come_back_from_the_unknowns() -> None:
    own = density("deviates")
    w = np.random.default_rng(1).standard_normal((4, own.size))
    found = own.unknowns(w)
    for i, row in enumerate(w):
        back = own.coordinates({name: values[i] for name, values in found.items()})
        np.testing.assert_allclose(back, row, atol=1e-8)
    with pytest.raises(NotImplementedError, match="deviates"):
        density("auto").coordinates({})


@pytest.mark.slow
def test_the_slope_is_that_of_the_density_and_cut_where_it_is_steep() -> None:
    own, steepest = density("deviates"), 3.0
    w, step = 4 * np.random.default_rng(2).standard_normal(own.size), 1e-5
    ends = np.concatenate([w + step * np.eye(own.size), w - step * np.eye(own.size)])
    above, below = np.split(np.asarray(jax.jit(jax.vmap(own))(ends)), 2)
    exact = (above - below) / (2 * step)
    size = np.sqrt(np.mean(exact**2))
    assert size > steepest
    np.testing.assert_allclose(jax.jit(jax.grad(own))(w), exact * steepest / size, atol=1e-3)


def test_other_names_are_refused() -> None:
    with pytest.raises(ValueError, match="model is one of"):
        rd.log_density(collision(), model="some")
    with pytest.raises(ValueError, match="coordinates are one of"):
        rd.log_density(collision(), coordinates="some")  # type: ignore[arg-type]


def sampled(
    model: object, draws: int, warmup: int = 300, chains: int = 4
) -> tuple[dict[str, np.ndarray], int]:
    """Draws by chain of a NumPyro model by NUTS as it comes, and the number of divergences."""
    kernel = NUTS(model, target_accept_prob=0.9)  # type: ignore[arg-type]
    mcmc = MCMC(kernel, num_warmup=warmup, num_samples=draws, num_chains=chains, progress_bar=False)
    mcmc.run(jax.random.key(0))
    found = {k: np.asarray(v) for k, v in mcmc.get_samples(group_by_chain=True).items()}
    return found, int(mcmc.get_extra_fields()["diverging"].sum())


def agree(found: dict[str, np.ndarray], result: rd.Result) -> None:
    for name in asked(found):
        sure = result.idata["posterior"][name].values
        draws = found[name]
        size = min(effective_sample_size(draws), draws.size)
        error = sure.std() * np.sqrt(1 / size + 1 / result.checks.min_ess_bulk)
        assert abs(draws.mean() - sure.mean()) < 4.5 * error, name
        assert draws.std() == pytest.approx(sure.std(), abs=4.5 * error), name


@pytest.mark.slow
def test_nuts_of_numpyro_and_a_witness_of_the_users_own() -> None:
    """A witness of the speed of B: draws with it are those without, weighted by its likelihood."""
    model = rd.NumpyroModel(density("auto"))
    result = rd.reconstruct(collision(berm=False), model=MODEL, method="importance")
    sure = result.idata["posterior"]["speed_b"].values
    said = float(sure.mean() + sure.std())

    def with_witness() -> None:
        numpyro.sample("witness", dist.Normal(model()["speed_b"], sure.std()), obs=said)

    found, divergences = sampled(with_witness, 250, warmup=150, chains=1)
    assert divergences <= 3
    weights = np.exp(-0.5 * ((sure - said) / sure.std()) ** 2)
    expected = np.average(sure, weights=weights)
    assert expected - sure.mean() > 0.3 * sure.std()
    assert found["speed_b"].mean() == pytest.approx(expected, abs=0.25 * sure.std())


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_nuts_of_numpyro_draws_what_reconstruct_does(name: str) -> None:
    file, model = SCENES[name]
    found, divergences = sampled(rd.numpyro_model(file, model=model), 1000)
    for quantity in asked(found):
        assert split_gelman_rubin(found[quantity]) < 1.01, quantity
        assert effective_sample_size(found[quantity]) > 400, quantity
    assert divergences <= 0.005 * 4000
    agree(found, rd.reconstruct(file, model=model, method="importance"))


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_nuts_of_blackjax_draws_what_reconstruct_does(name: str) -> None:
    blackjax = pytest.importorskip("blackjax")
    file, model = SCENES[name]
    own = rd.log_density(file, model=model)
    nuts = blackjax.nuts(own, step_size=0.3, inverse_mass_matrix=own.inverse_mass_matrix)

    def step(state: Any, key: jax.Array) -> tuple[Any, tuple[jax.Array, jax.Array]]:
        state, info = nuts.step(key, state)
        return state, (state.position, info.is_divergent)

    def chain(key: jax.Array) -> tuple[jax.Array, jax.Array]:
        begin = nuts.init(own.start)
        return jax.lax.scan(step, begin, jax.random.split(key, 1200))[1]

    w, diverged = jax.jit(jax.vmap(chain))(jax.random.split(jax.random.key(0), 4))
    found = {k: np.asarray(v) for k, v in own.unknowns(w[:, 200:]).items()}
    for quantity in asked(found):
        assert split_gelman_rubin(found[quantity]) < 1.01, quantity
        assert effective_sample_size(found[quantity]) > 400, quantity
    assert diverged[:, 200:].mean() <= 0.005
    agree(found, rd.reconstruct(file, model=model, method="importance"))
