"""Reconstruction from end to end: what comes out, that it repeats, and when it is withheld."""

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.inference import Interrupted, Unanswerable
from retrodict.inference.fitting import regression
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.outcome import Outcome
from retrodict.inference.pointwise import by_item
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS, chains
from retrodict.options import DEFAULT_RUNG, RunOptions
from tests.shared.scenes import collision

SCENE = collision(share=0.0, interlocked=True)


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return reconstruct(SCENE, RunOptions(draws=500, seed=1))


def test_checks_pass_and_the_truth_is_inside(outcome: Outcome) -> None:
    """The scene is the run-out of SAE 770014's Table 3, so its Table 4 must lie within."""
    assert outcome.checks.passed, outcome.checks.reasons
    truth = {"speed_b": 19.3, "e": 0.10, "e_m": 0.70, "mu": 0.35}
    for name, value in truth.items():
        low, high = np.quantile(outcome.idata["posterior"][name], [0.05, 0.95])
        assert low < value < high, (name, low, value, high)


def test_tree_has_every_group_with_names_and_units(outcome: Outcome) -> None:
    tree = outcome.idata
    assert set(tree.children) >= {
        "posterior", "prior", "posterior_predictive", "prior_predictive", "log_likelihood",
        "log_prior", "sample_stats", "observed_data", "constant_data", "trajectories",
    }  # fmt: skip
    assert set(SCENE.reported()) <= set(tree["posterior"].data_vars)
    assert {"friction_road", "friction_berm", "speed_a", "Gamma"} <= set(
        tree["posterior"].data_vars
    )
    for group in ("posterior_predictive", "log_likelihood", "observed_data"):
        assert list(tree[group]["evidence"]["item"].values) == list(SCENE.evidence())
        assert set(by_item(tree, group).data_vars) == set(SCENE.evidence())
    assert tree["posterior"]["speed_b"].attrs["unit"] == "m/s"
    assert tree["posterior"]["omega_b"].attrs["unit"] == "rad/s"
    assert tree["posterior"]["Gamma"].attrs["unit"] == "rad"
    assert tree["posterior"]["e"].dims == ("chain", "draw")
    assert tree["posterior"]["e"].shape == (4, outcome.settings["draws"])
    assert tree["trajectories"]["path"].dims == ("run", "vehicle", "step", "pose")


def test_posterior_keeps_the_laws_of_the_impact(outcome: Outcome) -> None:
    """Momentum along x and y (eqs 19, 20) in every draw, from quantities stored apart."""
    p = outcome.idata["posterior"]
    m_a, m_b = SCENE.vehicles["a"].mass.value, SCENE.vehicles["b"].mass.value
    before_x = -m_a * p["speed_a"] + m_b * p["vbx"]
    np.testing.assert_allclose(before_x, m_a * p["Vax"] + m_b * p["Vbx"], rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(
        m_b * p["vby"], m_a * p["Vay"] + m_b * p["Vby"], rtol=1e-9, atol=1e-6
    )


def test_predictions_lie_where_the_trajectories_end(outcome: Outcome) -> None:
    ends = outcome.idata["trajectories"]["path"].isel(step=-1).sel(vehicle="b", pose="x")
    assert float(abs(ends.mean() - SCENE.rest["b"].x.value)) < 0.15
    starts = outcome.idata["trajectories"]["path"].isel(step=0).sel(vehicle="b", pose="x")
    np.testing.assert_allclose(starts, -0.653, atol=1e-9)


def test_nuts_agrees_with_importance_sampling(outcome: Outcome) -> None:
    """An independent route to the same posterior: weighted draws from a Student-t (5) at the mode."""
    posterior = prepare(SCENE, DEFAULT_RUNG)
    programs, n = posterior.programs, posterior.size
    rng = np.random.default_rng(7)
    w = rng.normal(size=(4000, n)) / np.sqrt(rng.chisquare(5, size=(4000, 1)) / 5)
    density = jax.jit(
        jax.vmap(lambda w: programs.target.log_density(w, posterior.data, posterior.transform))
    )
    log_weight = np.array(density(jnp.asarray(w)))
    log_weight += 0.5 * (5 + n) * np.log1p((w**2).sum(axis=1) / 5)  # less the t's log density
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    effective = 1 / (weight**2).sum()
    assert effective > 400
    quantities = posterior.evaluate(w)[1]
    for name in ("speed_b", "e", "e_m", "mu", "omega_b"):
        values = quantities[name]
        mean = (weight * values).sum()
        sd = np.sqrt((weight * (values - mean) ** 2).sum())
        nuts = outcome.idata["posterior"][name].values
        # four standard errors of both: ESS of NUTS is above 1000 here
        assert nuts.mean() == pytest.approx(mean, abs=4 * sd * np.sqrt(1 / effective + 1 / 1000)), (
            name
        )
        assert nuts.std() == pytest.approx(
            sd, rel=4 * np.sqrt(0.5 / effective + 0.5 / 1000) * 1.5
        ), name


@pytest.mark.slow
def test_same_seed_same_draws_other_seed_others(outcome: Outcome) -> None:
    again = reconstruct(SCENE, RunOptions(draws=500, seed=1)).idata["posterior"]["speed_b"].values
    np.testing.assert_array_equal(again, outcome.idata["posterior"]["speed_b"].values)
    other = reconstruct(SCENE, RunOptions(draws=500, seed=2)).idata["posterior"]["speed_b"].values
    assert not np.array_equal(again, other)


def test_a_rest_pose_out_of_reach_is_refused_with_the_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where no start comes near, here because none is a number, the vehicle is named."""
    monkeypatch.setattr(
        regression, "_about", lambda likely, starts: np.full((starts, *likely.shape), np.nan)
    )
    with pytest.raises(Unanswerable, match="vehicle A: no velocities after the impact"):
        prepare(SCENE, DEFAULT_RUNG)


@pytest.mark.parametrize("method", sorted(set(METHODS) - {"nuts"}))
def test_resume_is_refused_by_name_where_there_are_no_chains(method: str, tmp_path: Path) -> None:
    file = tmp_path / "chains.npz"
    file.write_bytes(b"of a run of nuts")
    with pytest.raises(ValueError, match=f"the method {method} has no chains to go on with"):
        reconstruct(SCENE, RunOptions(method=method), resume=file)
    assert file.read_bytes() == b"of a run of nuts"


@pytest.mark.slow
def test_interrupt_keeps_the_draws_says_so_and_resumes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Ctrl-C in the middle of sampling, and before anything was drawn."""
    done_so_far = 0

    def watch(stage: str, done: int, _: int) -> None:
        nonlocal done_so_far
        done_so_far = done if stage == "sampling" else 0

    def interrupted_from(count: int):
        def wait(futures: dict, **options: Any):
            if done_so_far >= count:
                raise KeyboardInterrupt
            return original(futures, **options)

        return wait

    original = chains.wait
    monkeypatch.setattr(chains, "wait", interrupted_from(2500))
    cut = reconstruct(SCENE, RunOptions(draws=100_000), progress=watch)
    assert not cut.complete
    assert not cut.checks.passed
    assert "interrupted" in cut.checks.reasons[0]
    assert 4 <= cut.idata["posterior"].sizes["draw"] < 100_000

    monkeypatch.setattr(chains, "wait", original)
    file = tmp_path / "chains.npz"
    assert cut.unfinished is not None
    file.write_bytes(cut.unfinished)
    drawn = cut.idata["posterior"].sizes["draw"] + 200
    resumed = reconstruct(SCENE, RunOptions(draws=drawn), resume=file)
    whole = reconstruct(SCENE, RunOptions(draws=drawn))
    for name in ("speed_b", "mu"):
        np.testing.assert_array_equal(
            resumed.idata["posterior"][name], whole.idata["posterior"][name]
        )
    with pytest.raises(ValueError, match="made with seed 0, not 1"):
        reconstruct(SCENE, RunOptions(seed=1), resume=file)

    monkeypatch.setattr(chains, "wait", interrupted_from(0))
    with pytest.raises(Interrupted):
        reconstruct(SCENE, RunOptions(draws=100_000), progress=watch)
