"""One vehicle alone: skids and run-outs, against v0² = v² + 2 f g s with its errors."""

import numpy as np
import pytest

import retrodict as rd
from retrodict.constants import GRAVITY
from tests.scene.test_alone import SKID


def draws(text, name="travelling_speed_a"):
    found = rd.reconstruct(rd.parse_scene(text, "skid"), method="importance")
    assert found.checks.passed
    return found, np.ravel(found.idata["posterior"][name])


def closed_form(speed=(0.0, 0.2), length=(30.0, 0.5), friction=(0.72, 0.05), count=200_000):
    """Draws of the speed before the skid; a straight slide takes all tyres as alike."""
    rng = np.random.default_rng(0)

    def lognormal(mean, sd):
        scale = np.sqrt(np.log1p((sd / mean) ** 2))
        return mean * np.exp(scale * rng.standard_normal(count) - scale**2 / 2)

    held = lognormal(*friction)
    end = speed[0] + speed[1] * rng.standard_normal(count)
    return np.sqrt(end**2 + 2 * GRAVITY * held * lognormal(*length))


def same(found, exact):
    assert found.mean() == pytest.approx(exact.mean(), abs=0.1 * exact.std())
    assert found.std() == pytest.approx(exact.std(), rel=0.08)


def test_a_skid_to_a_stop():
    same(draws(SKID)[1], closed_form())


def test_a_skid_that_ends_at_a_known_speed():
    same(draws(SKID.replace('"0 mph"', '"12 ± 1 m/s"'))[1], closed_form(speed=(12.0, 1.0)))


@pytest.mark.slow
def test_a_run_out_of_a_measured_length_is_the_same_as_a_skid_to_a_stop():
    text = SKID.replace(
        'approach = { skid = "30 ± 0.5 m", speed = "0 mph" }', 'rest = { distance = "30 ± 0.5 m" }'
    )
    same(draws(text)[1], closed_form(speed=(0.0, 0.0)))


def test_how_probable_it_is_that_the_speed_was_above_a_limit():
    found, _ = draws(SKID + '[questions]\nexceeds = "speed_a > 20 m/s"\n')
    share = found.probability("speed_a > 20 m/s").numbers.value
    assert share == pytest.approx((closed_form() > 20).mean(), abs=0.03)
