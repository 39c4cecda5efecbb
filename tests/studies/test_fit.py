"""How a reconstruction explains what was measured."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy.special import expit
from scipy.stats import chi2

from retrodict.scene.records import Measured, Wheels
from retrodict.studies.fit import fit
from tests.report.conftest import make_outcome, make_scene
from tests.shared.scenes import rolls


def test_fit_of_a_linear_model_is_the_chi_square_of_least_squares() -> None:
    """Against weighted least squares: the minimum, and measurements less free unknowns."""
    rng = np.random.default_rng(3)
    scene = make_scene()
    evidence = scene.evidence()
    inputs = {k: m for k, m in scene.inputs().items() if m.sd > 0}
    free, p, m = 4, len(inputs), len(evidence)
    design = np.block(
        [
            [rng.normal(size=(m, free)), rng.normal(0, 0.3, (m, p))],
            [np.zeros((p, free)), np.eye(p)],
        ]
    )
    observed = np.concatenate([rng.normal(0, 3, m), np.zeros(p)])
    mean, minimum, *_ = np.linalg.lstsq(design, observed)
    covariance = np.linalg.inv(design.T @ design)
    draws = rng.multivariate_normal(mean, covariance, 20_000)
    miss = draws @ design[:m].T - observed[:m] + rng.normal(size=(20_000, m))
    idata = xr.DataTree.from_dict(
        {
            "/posterior": xr.Dataset(
                {k: ("draw", inputs[k].value + inputs[k].sd * x)
                 for k, x in zip(inputs, draws[:, free:].T, strict=True)}
            ),
            "/posterior_predictive": xr.Dataset(
                {k: ("draw", evidence[k].value + evidence[k].sd * x)
                 for k, x in zip(evidence, miss.T, strict=True)}
            ),
        }
    )  # fmt: skip
    found = fit(SimpleNamespace(scene=scene, idata=idata))
    assert found.chi_square == pytest.approx(float(minimum[0]), rel=0.03)
    assert found.freedom == pytest.approx(m - free, abs=0.15)  # four standard errors
    assert found.probability == pytest.approx(chi2.sf(found.chi_square, found.freedom))
    residual = (observed - design @ mean)[:m]
    for item, exact in zip(found.items, residual, strict=True):
        assert item.residual == pytest.approx(exact, abs=0.05)


def test_evidence_that_a_rung_does_not_use_is_listed_but_not_counted() -> None:
    outcome = make_outcome()
    all_of_it = fit(outcome)
    kept = outcome.idata["posterior_predictive"].to_dataset()
    kept = kept.drop_sel(item=["rest_y_b", "rest_heading_b"])
    outcome.idata["posterior_predictive"] = xr.DataTree(kept)
    fewer = fit(outcome)
    assert [i.name for i in fewer.items if not i.used] == ["rest_y_b", "rest_heading_b"]
    assert fewer.items[4].residual is None
    y, heading = all_of_it.items[4].residual, all_of_it.items[5].residual
    assert fewer.chi_square == pytest.approx(all_of_it.chi_square - y**2 - heading**2)


def test_a_wheel_of_which_nothing_is_known_or_learnt_frees_nothing() -> None:
    """Draws of its law alone, which only in logits is normal, are no degree of freedom."""
    bare, scene = make_outcome(), rolls(make_scene(), "b", (0.5,) * 4)
    b = scene.vehicles["b"]
    damaged = Measured(0.5, 0.425, "logitnormal")
    wheels = Wheels(damaged, *[Measured(1.0, 0.0, "logitnormal")] * 3, Measured(0.0))
    scene = replace(scene, vehicles=scene.vehicles | {"b": replace(b, wheels=wheels)})
    posterior = bare.idata["posterior"].to_dataset()
    draws = expit(1.7 * np.random.default_rng(0).normal(size=posterior["e"].shape))
    tree = bare.idata.copy()
    tree["posterior"] = xr.DataTree(
        posterior.assign(drag_front_left_b=(posterior["e"].dims, draws))
    )
    found, without = fit(replace(bare, scene=scene, idata=tree)), fit(bare)
    assert found.freedom == pytest.approx(without.freedom, abs=0.1)
    assert found.chi_square == pytest.approx(without.chi_square, abs=0.01)
