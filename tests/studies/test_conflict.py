"""What each measurement says when left out, against conjugate normals in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from retrodict.scene.records import Measured
from retrodict.studies.conflict import conflicts

MEASURED = {"one": (19.0, 1.0), "two": (20.5, 1.0), "far": (26.0, 1.5), "wide": (18.0, 4.0)}
DRAWS = 400_000


@pytest.fixture(scope="module")
def found() -> dict:
    """Four measurements of one speed, prior 20 ± 10, from draws of their exact posterior."""
    mean, sd = posterior(MEASURED)
    rng = np.random.default_rng(0)
    speed = rng.normal(mean, sd, (4, DRAWS // 4))
    of_draw = {name: (("chain", "draw"), a) for name, a in predictions(speed, rng).items()}
    likelihood = {
        name: (("chain", "draw"), stats.norm.logpdf(value, speed, error))
        for name, (value, error) in MEASURED.items()
    }
    tree = xr.DataTree.from_dict(
        {
            "/posterior": xr.Dataset({"speed_b": (("chain", "draw"), speed)}),
            "/posterior_predictive": xr.Dataset(of_draw),
            "/log_likelihood": xr.Dataset(likelihood),
        }
    )
    scene = SimpleNamespace(
        robust=False,
        sought="speed_b",
        evidence=lambda: {k: Measured(*v) for k, v in MEASURED.items()},
    )
    return {item.name: item for item in conflicts(SimpleNamespace(idata=tree, scene=scene))}


def posterior(measured: dict) -> tuple[float, float]:
    """Mean and sd."""
    values, errors = np.array([(20.0, 10.0), *measured.values()]).T
    precision = np.sum(errors**-2)
    return float(np.sum(values / errors**2) / precision), float(precision**-0.5)


def predictions(speed: np.ndarray, rng: np.random.Generator) -> dict:
    return {k: speed + rng.normal(0, error, speed.shape) for k, (_, error) in MEASURED.items()}


@pytest.mark.parametrize("name", MEASURED)
def test_the_rest_says_what_it_would_say_alone(found: dict, name: str) -> None:
    item, (value, error) = found[name], MEASURED[name]
    mean, sd = posterior({k: v for k, v in MEASURED.items() if k != name})
    assert item.reliable
    assert item.expected == pytest.approx(mean, abs=0.05)
    assert item.expected_sd == pytest.approx(np.hypot(sd, error), rel=0.05)
    assert item.speed == pytest.approx(mean, abs=0.05)
    assert item.speed_sd == pytest.approx(sd, rel=0.05)
    exact = 2 * stats.norm.sf(abs(value - mean) / np.hypot(sd, error))
    assert item.probability == pytest.approx(exact, abs=0.02)


@pytest.mark.parametrize("name", MEASURED)
def test_an_error_is_believed_as_far_as_all_else_lets_it(found: dict, name: str) -> None:
    mean, _ = posterior(MEASURED)
    value, sd = MEASURED[name]
    shift, _ = np.array(posterior(MEASURED | {name: (value + sd, sd)})) - (mean, 0)
    assert found[name].moved == pytest.approx(shift, abs=0.02)
    assert found[name].believed == pytest.approx(shift / sd, abs=0.02)


@pytest.mark.parametrize("name", MEASURED)
def test_errors_of_drawing_are_those_of_independent_normals(found: dict, name: str) -> None:
    (_, sd), (_, error) = posterior(MEASURED), MEASURED[name]
    share = sd / error  # a prediction, in errors of the measurement, has a variance of 1 + share²
    of_square = np.sqrt(2 / DRAWS) * (1 + share**2)
    of_product = np.sqrt(((1 + share**2) * sd**2 + (share * sd) ** 2) / DRAWS)
    assert found[name].believed_error == pytest.approx(of_square, rel=0.05)
    assert found[name].moved_error == pytest.approx(of_product, rel=0.05)


def test_only_what_lies_far_out_disagrees(found: dict) -> None:
    assert [name for name, item in found.items() if item.disagrees] == ["far"]
