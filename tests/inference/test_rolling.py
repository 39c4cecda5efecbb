"""Crashes whose vehicles roll: draws against weights in other coordinates; sessions."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.modes import ModeSearch
from retrodict.inference.points import Estimate
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers.importance import log_evidence
from retrodict.inference.samplers.psis import log_mean
from retrodict.inference.transforms.choice import Coordinates
from retrodict.live import Session
from retrodict.options import RunOptions
from retrodict.scene import load_scene
from retrodict.scene.records import Measured
from tests.shared.scenes import collision, rolls

pytestmark = pytest.mark.slow
ROLLING = rolls(collision(berm=False), "b", (0.9, 0.9, 0.8, 0.3))
UNCOUNTED = replace(
    ROLLING, rest={v: replace(rest, turns_known=False) for v, rest in ROLLING.rest.items()}
)


@pytest.mark.parametrize("method", ["importance", "smc"])
def test_draws_agree_with_weights_in_rest_pose_coordinates(method: str) -> None:
    rung = "momentum+wheels"
    found = reconstruct(ROLLING, RunOptions(model=rung, method=method, seed=2), pictured=False)
    assert found.checks.passed, found.checks.reasons
    assert found.settings["method"] == method
    pinned = prepare(ROLLING, rung)
    assert not pinned.programs.structure.in_deviates
    w = np.random.default_rng(0).standard_normal((8000, pinned.size)) * 1.1
    height, quantities = pinned.evaluate(w)
    log_weight = height - stats.norm.logpdf(w, 0, 1.1).sum(axis=1)
    evidence, error = log_mean(log_weight)
    assert error < 0.2
    attributes = found.idata["sample_stats"].attrs
    sure = np.hypot(error, attributes["log_evidence_sd"])
    assert attributes["log_evidence"] == pytest.approx(evidence, abs=4 * sure)
    weights = np.exp(log_weight - log_weight.max())
    mean = weights @ quantities["speed_b"] / weights.sum()
    draws = found.idata["posterior"]["speed_b"].values
    assert draws.mean() == pytest.approx(mean, abs=0.2 * draws.std())


def test_every_number_of_turns_is_found_though_few_crashes_of_the_prior_come_near() -> None:
    """Neither rotation was written. The part of the true one has the evidence that it has if written."""
    known, open_ = (ModeSearch(scene, 2) for scene in (ROLLING, UNCOUNTED))
    found = {
        tuple(each.turns.values()): each
        for each in open_.solutions("momentum+wheels", Coordinates.DEVIATES)
    }
    assert {(0, 1), (0, 0), (0, -1), (0, -2), (0, -3), (0, -4), (-1, -2), (1, -2)} <= found.keys()
    (alone,) = known.solutions("momentum+wheels", Coordinates.DEVIATES)
    one, other = (
        log_evidence(each.posterior, np.random.default_rng(0)) for each in (alone, found[0, 0])
    )
    assert one.value == pytest.approx(other.value, abs=4 * np.hypot(one.error, other.error))


def test_a_car_that_rolled_in_a_bend_did_not_slide_with_a_spin() -> None:
    """A may have slid there at 20 m/s with a spin, or rolled there in a bend at 14.

    The latter misses the rest pose by some three standard deviations with all inputs at their means,
    and by none with others. It is what happened.
    """
    scene = load_scene(Path(__file__).parents[1] / "data" / "valley.toml")
    found = reconstruct(scene, RunOptions(method="importance"), pictured=False)
    assert found.checks.passed, found.checks.reasons
    assert float(found.idata["posterior"]["Omega_a"].min()) > -1


def test_a_session_answers_a_changed_scene_as_one_of_its_own() -> None:
    """A slower by two standard deviations: means within five standard errors."""
    free = rolls(collision(share=0.0, berm=False), "b", (0.3, 0.3, 0.1, 0.1))
    approach = replace(free.approach["a"], speed=Measured(18.3, 0.894))
    scene = replace(free, approach=free.approach | {"a": approach})
    rung = "planar-moment+wheels"
    kept = Session(free, rung)
    before = kept.answer.estimate
    after, fresh = kept.update(scene).estimate, Session(scene, rung, seed=1).answer.estimate

    def speed(found: Estimate) -> tuple[float, float]:
        return found.weighted.mean(found.quantities["speed_b"])

    for found in (before, after, fresh):
        assert found.checks.passed, found.checks.reasons
    assert abs(speed(after)[0] - speed(fresh)[0]) < 5 * np.hypot(speed(after)[1], speed(fresh)[1])
    assert abs(speed(after)[0] - speed(before)[0]) > 0.2
