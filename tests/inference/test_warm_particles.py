"""A changed scene whose vehicle rolls: particles that moved on say what particles from nothing say."""

from dataclasses import replace

import numpy as np
import pytest

from retrodict.inference.points import Estimate
from retrodict.inference.warm import WarmPoints
from retrodict.inference.warm_particles import WarmParticles, warm
from retrodict.scene.records import Measured, Scene
from tests.shared.scenes import collision, rolls

SCENE = rolls(collision(share=0.0, berm=False), "b", (0.3, 0.3, 0.1, 0.1))
RUNG = "planar-moment+wheels"
OWN = ("speed_b", "e", "e_m", "mu")


@pytest.fixture(scope="module")
def kept() -> WarmParticles:
    return WarmParticles(SCENE, RUNG)


def _speed_of_a(speed: float) -> Scene:
    approach = replace(SCENE.approach["a"], speed=Measured(speed, 0.894))
    return replace(SCENE, approach=SCENE.approach | {"a": approach})


def _mean(found: Estimate, name: str) -> tuple[float, float]:
    return found.weighted.mean(found.quantities[name])


def test_answers_are_those_of_particles_from_nothing(kept: WarmParticles) -> None:
    """A two standard deviations slower: means within five standard errors, by eight populations each."""
    scene = _speed_of_a(18.3)
    assert kept.fits(scene)
    found, fresh = kept.estimate(scene), WarmParticles(scene, RUNG, seed=1).estimate(scene)
    assert found.checks.passed, found.checks.reasons
    assert found.evaluations < fresh.evaluations / 2
    before = kept.estimate(SCENE)
    assert abs(_mean(found, "speed_b")[0] - _mean(before, "speed_b")[0]) > 0.5
    for name in OWN:
        (one, error), (other, its_error) = _mean(found, name), _mean(fresh, name)
        assert abs(one - other) < 5 * np.hypot(error, its_error), name
        sd, sure = (each.weighted.sd(each.quantities[name])[0] for each in (found, fresh))
        assert sd == pytest.approx(sure, rel=0.15)


def test_the_way_is_chosen_by_the_scene(kept: WarmParticles) -> None:
    assert not kept.fits(collision(share=0.0))
    assert isinstance(warm(collision(share=0.0, interlocked=True), RUNG), WarmPoints)
