"""ArviZ on a result as it is: statistics against what is known otherwise, and plots without gaps."""

from pathlib import Path

import arviz as az
import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from scipy import stats

import retrodict as rd
from retrodict.inference.pointwise import by_item

matplotlib.use("agg")

SCENE = Path(__file__).parents[1] / "examples" / "brach-1977" / "scene.toml"
MODEL = "planar-moment+wheels"
UNKNOWNS = ["speed_b", "e", "e_m", "mu"]
COEFFICIENTS = ["e", "e_m", "mu"]


@pytest.fixture(scope="module")
def result() -> rd.Result:
    return rd.reconstruct(SCENE, model=MODEL, method="importance", seed=3)


@pytest.fixture(scope="module")
def simpler() -> rd.Result:
    return rd.reconstruct(SCENE, model="planar+wheels", method="importance", seed=3)


@pytest.fixture(
    scope="module",
    params=["importance", *(pytest.param(m, marks=pytest.mark.slow) for m in ("nuts", "smc"))],
)
def idata(request: pytest.FixtureRequest, result: rd.Result) -> xr.DataTree:
    if request.param == "importance":
        return result.idata
    return rd.reconstruct(SCENE, model=MODEL, method=request.param, seed=3).idata


def test_summary_says_what_the_findings_say(result: rd.Result) -> None:
    table = az.summary(result.idata, var_names=UNKNOWNS, round_to="none")
    for name in UNKNOWNS:
        assert table.loc[name, "mean"] == pytest.approx(result.findings.quantities[name].mean)
        assert table.loc[name, "r_hat"] <= 1.01


def test_loo_is_that_of_the_items(idata: xr.DataTree, result: rd.Result) -> None:
    """No item is fitted better without it than with it, and Pareto k are those of the report."""
    found = az.loo(idata, pointwise=True)
    assert found.n_data_points == len(result.scene.evidence())
    inside = np.log(np.exp(idata["log_likelihood"]["evidence"]).mean(("chain", "draw")))
    assert (found.elpd_i < inside).all()
    assert found.elpd == pytest.approx(float(found.elpd_i.sum()))


@pytest.mark.slow
def test_compare_ranks_models_of_one_scene(result: rd.Result, simpler: rd.Result) -> None:
    table = az.compare({"moment": result.idata, "no moment": simpler.idata})
    assert set(table.index) == {"moment", "no moment"}
    assert table["weight"].sum() == pytest.approx(1, abs=0.02)


def test_log_priors_are_those_of_the_scene(idata: xr.DataTree, result: rd.Result) -> None:
    """Of each unknown against SciPy, from the numbers that the scene states."""
    found, draws, priors = idata["log_prior"], idata["posterior"], result.scene.priors
    speed = stats.halfnorm(scale=priors["speed_b"].numbers[0])
    np.testing.assert_allclose(found["speed_b"], speed.logpdf(draws["speed_b"]))
    spin = stats.norm(scale=priors["omega_b"].numbers[0])
    np.testing.assert_allclose(found["omega_b"], spin.logpdf(draws["omega_b"]))
    fast, slow, decay = priors["e"].numbers
    scale = fast + (slow - fast) * np.exp(-draws["closing_speed"] / decay)
    e = stats.truncnorm(0, 1 / scale, scale=scale)
    np.testing.assert_allclose(found["e"], e.logpdf(draws["e"]))
    loc, sd = priors["e_m"].numbers
    e_m = stats.truncnorm((-1 - loc) / sd, (1 - loc) / sd, loc, sd)
    np.testing.assert_allclose(found["e_m"], e_m.logpdf(draws["e_m"]))
    mass = result.scene.inputs()["mass_a"]
    location, scale = mass.location_and_scale
    deviate = (np.log(draws["mass_a"]) - location) / scale
    np.testing.assert_allclose(
        found["inputs"].sel(input="mass_a"), stats.norm.logpdf(deviate), atol=1e-9
    )


def test_power_scaling_follows_the_priors_that_matter(idata: xr.DataTree) -> None:
    """Rest poses determine the speed, and only its prior the coefficient that nothing measured."""
    table = az.psense_summary(idata, var_names=UNKNOWNS, prior_var_names=COEFFICIENTS)
    assert list(table.index) == UNKNOWNS
    assert (table[["prior", "likelihood"]] >= 0).all(axis=None)
    inputs = az.psense_summary(
        idata, ["speed_b"], prior_var_names=["inputs"], prior_coords={"input": ["speed_a"]}
    )
    assert inputs.loc["speed_b", "prior"] > 0


def axes_of(collection: object) -> int:
    """Number of axes with something drawn in them."""
    figure = collection.viz["figure"].item()  # type: ignore[attr-defined]
    plt.close(figure)
    return sum(axes.has_data() for axes in figure.axes)


PLOTS = {
    "trace": (lambda t: az.plot_trace(t, var_names=UNKNOWNS), 4),
    "pair": (lambda t: az.plot_pair(t, var_names=UNKNOWNS), 10),
    "forest": (lambda t: az.plot_forest(t, var_names=COEFFICIENTS), 1),
    "prior_posterior": (lambda t: az.plot_prior_posterior(t, var_names=UNKNOWNS), 4),
    "ppc_dist": (az.plot_ppc_dist, 1),
    "prior_ppc_dist": (lambda t: az.plot_ppc_dist(t, group="prior_predictive"), 1),
    "ppc_interval": (az.plot_ppc_interval, 1),
    "loo_pit": (az.plot_loo_pit, 1),
    "psense_dist": (
        lambda t: az.plot_psense_dist(t, var_names=UNKNOWNS, prior_var_names=COEFFICIENTS),
        8,
    ),
}


@pytest.mark.parametrize("name", PLOTS)
def test_a_plot_fills_its_panels(name: str, idata: xr.DataTree) -> None:
    plot, panels = PLOTS[name]
    assert axes_of(plot(idata)) >= panels


def test_predictions_of_an_item_are_in_its_unit(result: rd.Result) -> None:
    x = by_item(result.idata, "posterior_predictive")["rest_x_b"]
    measured = result.scene.evidence()["rest_x_b"]
    assert abs(float(x.mean()) - measured.value) < 2 * measured.sd


@pytest.mark.slow
@pytest.mark.parametrize("method", ["monte-carlo", "linear"])
def test_draws_of_no_posterior_are_refused_where_a_posterior_is_needed(method: str) -> None:
    found = rd.reconstruct(SCENE, model=MODEL, method=method, draws=100).idata
    assert "log_prior" not in found.children
    with pytest.raises(TypeError, match="log likelihood not found"):
        az.loo(found)
    assert axes_of(az.plot_ppc_dist(found)) == 1
