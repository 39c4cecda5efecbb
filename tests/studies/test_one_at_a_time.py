"""The effect of each measurement, against conjugate normals in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from retrodict.scene.measured import Measured
from retrodict.studies.one_at_a_time import one_at_a_time

# deviates of all that is uncertain are normal, and the speed is linear in them
FRICTION, MASS, REST = Measured(0.7, 0.1), Measured(1500.0, 60.0, "lognormal"), Measured(12.0, 0.5)


@pytest.fixture(scope="module")
def outcome():
    """Deviates x, of friction, mass and another, all N(0, 1); 12 + 0.4 (x1 + x3) is measured."""
    rng = np.random.default_rng(0)
    slope = np.array([0.4, 0.0, 0.4])
    covariance = np.linalg.inv(np.eye(3) + np.outer(slope, slope) / REST.sd**2)
    x = rng.multivariate_normal(np.zeros(3), covariance, (4, 100_000))
    scale = np.sqrt(np.log1p((MASS.sd / MASS.value) ** 2))
    draws = {
        "speed_b": 20 + x @ [3.0, -2.0, 4.0],
        "friction_road": FRICTION.value + FRICTION.sd * x[..., 0],
        "mass_a": MASS.value * np.exp(scale * x[..., 1] - scale**2 / 2),
    }
    predicted = REST.value + x @ slope + rng.normal(0, REST.sd, x.shape[:2])
    tree = {
        "/posterior": xr.Dataset({k: (("chain", "draw"), v) for k, v in draws.items()}),
        "/posterior_predictive": xr.Dataset({"rest_x_b": (("chain", "draw"), predicted)}),
    }
    scene = SimpleNamespace(
        inputs=lambda: {"friction_road": FRICTION, "mass_a": MASS, "track_a": Measured(1.5)},
        evidence=lambda: {"rest_x_b": REST},
        robust=False,
    )
    return SimpleNamespace(idata=xr.DataTree.from_dict(tree), scene=scene)


def posterior_mean(friction: float = 0.0, mass: float = 0.0, rest: float = 0.0) -> float:
    """Of the speed, with each measurement so many standard deviations off."""
    slope = np.array([0.4, 0.0, 0.4])
    precision = np.eye(3) + np.outer(slope, slope) / REST.sd**2
    right = np.array([friction, mass, 0.0]) + slope * rest / REST.sd
    return float(np.array([3.0, -2.0, 4.0]) @ np.linalg.solve(precision, right))


@pytest.mark.parametrize(
    ("name", "shift"), [("friction_road", "friction"), ("mass_a", "mass"), ("rest_x_b", "rest")]
)
def test_the_answer_moves_as_the_posterior_mean_does(outcome, name, shift):
    found = {each.name: each for each in one_at_a_time(outcome, "speed_b")}[name]
    assert found.moved == pytest.approx(posterior_mean(**{shift: 1.0}), abs=4 * found.error)
    assert 0 < found.error < 0.05


def test_the_largest_effect_comes_first_and_exact_inputs_have_none(outcome):
    found = one_at_a_time(outcome, "speed_b")
    assert [abs(each.moved) for each in found] == sorted(
        (abs(each.moved) for each in found), reverse=True
    )
    assert "track_a" not in [each.name for each in found]


def test_heavy_tails_have_no_such_derivative(outcome):
    robust = SimpleNamespace(
        idata=outcome.idata, scene=SimpleNamespace(**vars(outcome.scene) | {"robust": True})
    )
    assert {each.name for each in one_at_a_time(robust, "speed_b")} == {"friction_road", "mass_a"}
