"""What would narrow an answer: against closed forms, and against running again with it known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from retrodict.inference.reconstruct import reconstruct
from retrodict.options import RunOptions
from retrodict.scene.records import Measured
from retrodict.studies.narrowing import narrowing
from tests.shared.scenes import collision

ROAD = Measured(0.7, 0.1)
REST = Measured(12.0, 0.5)


def _outcome(robust: bool = False) -> SimpleNamespace:
    """speed_b = 20 + 3 u + 4 v + 12 w: the friction determines u, the rest v, and nothing w."""
    rng = np.random.default_rng(0)
    u, v, w = rng.standard_normal((3, 4, 100_000))
    error = rng.standard_t(4, v.shape) if robust else rng.standard_normal(v.shape)
    posterior = {
        "speed_b": 20 + 3 * u + 4 * v + 12 * w,
        "friction_road": 0.7 + 0.1 * u,
        "direction_b": np.angle(
            np.exp(1j * (np.pi + 0.1 * (u + v)))
        ),  # on either side of half a turn
        "Omega_b": -2 * v,
        **dict.fromkeys(("Vax", "Vay", "Vbx", "Vby"), 1 + 0 * w),
    }
    predicted = {
        "rest_x_b": 12 + 0.4 * v + REST.sd * error,
        "rest_y_b": 12 + 0.4 * u + REST.sd * error,
    }
    tree = {
        name: xr.Dataset({k: (("chain", "draw"), x) for k, x in group.items()})
        for name, group in (("/posterior", posterior), ("/posterior_predictive", predicted))
    }
    scene = SimpleNamespace(
        inputs=lambda: {"friction_road": ROAD},
        evidence=lambda: {"rest_x_b": REST, "rest_y_b": REST},  # one record may serve twice
        robust=robust,
    )
    return SimpleNamespace(idata=xr.DataTree.from_dict(tree), scene=scene)


@pytest.mark.parametrize("robust", [False, True])
def test_what_stays_is_the_conditional_variance(robust: bool) -> None:
    found = {each.name: each for each in narrowing(_outcome(robust), "speed_b")}
    exact = {
        "friction_road": np.hypot(4, 12),
        "Omega_b": np.hypot(3, 12),
        "rest_x_b": np.hypot(3, 12),
        "rest_y_b": np.hypot(4, 12),
        "direction_b": np.sqrt(169 - 7**2 / 2),
    }
    assert {name: found[name].sd for name in exact} == pytest.approx(exact, rel=0.01)
    assert found["friction_road"].measured is ROAD
    assert found["rest_x_b"].measured is REST
    assert found["Omega_b"].measured is None
    assert "speed_b" not in found


def test_the_most_narrowing_comes_first() -> None:
    sds = [each.sd for each in narrowing(_outcome(), "speed_b")]
    assert sds == sorted(sds)


@pytest.mark.slow
def test_running_again_with_it_known_says_the_same() -> None:
    """A's speed in SAE 770014's example, known exactly, at its posterior mean."""
    scene = collision()
    outcome = reconstruct(scene, RunOptions(method="importance", seed=1), pictured=False)
    found = {each.name: each.sd for each in narrowing(outcome, "speed_b")}
    speed = scene.approach["a"].speed
    assert speed is not None
    known = replace(speed, value=float(outcome.idata["posterior"]["speed_a"].mean()), sd=1e-6)
    approach = scene.approach | {"a": replace(scene.approach["a"], speed=known)}
    again = reconstruct(
        replace(scene, approach=approach), RunOptions(method="importance", seed=2), pictured=False
    )
    sd = float(again.idata["posterior"]["speed_b"].std())
    assert found["speed_a"] == pytest.approx(sd, rel=0.08)
    assert sd < 0.6 * float(outcome.idata["posterior"]["speed_b"].std())
