"""Priors: the defaults against what was published, and overrides."""

from __future__ import annotations

import math

import pytest

from retrodict.scene import parse_scene
from retrodict.scene.priors import default_priors
from tests.shared.scene_file import SCENE, without

MPH = 0.44704


def scale_of_e(closing: float) -> float:
    fast, slow, over = default_priors()["e"].numbers
    return fast + (slow - fast) * math.exp(-closing / over)


def cipriani(closing: float) -> float:
    """Restitution of collinear low-speed tests (Cipriani 2002, as PyCrash codes it)."""
    decades = math.log10(closing)
    return 0.47477 - 0.26139 * decades + 0.03382 * decades**2 - 0.11639 * decades**3


@pytest.mark.parametrize("closing", [1.0, 2.0, 5.0, 10.0])
def test_the_prior_of_e_has_the_size_of_low_speed_tests(closing):
    # a half-normal's scale is its root mean square; the fit's own spread is about 0.07
    assert scale_of_e(closing) == pytest.approx(math.hypot(cipriani(closing), 0.07), abs=0.04)


def test_the_prior_of_e_has_the_size_of_crashes_at_40_mph():
    # 21 small-overlap tests: mean 0.091, sd 0.100, largest 0.279
    assert scale_of_e(40 * MPH) == pytest.approx(math.hypot(0.091, 0.100), abs=0.01)
    assert 2 * scale_of_e(40 * MPH) > 0.279


def test_the_prior_of_mu_allows_every_crash_of_the_21():
    # least, mean and largest share of the critical mu; root mean square of what is missing
    scale, _ = default_priors()["mu"].numbers
    assert 1.5 * scale > 1 - 0.718
    assert math.hypot(1 - 0.953, 0.078) < scale


def test_a_scene_may_say_that_parts_interlocked():
    text = SCENE.replace("[impact]", "[impact]\ninterlocked = true")
    assert parse_scene(text, "bend").contact.interlocked
    assert not parse_scene(SCENE, "bend").contact.interlocked


def test_every_default_names_its_grade_and_states_its_numbers():
    for name, prior in default_priors().items():
        assert prior.grade in "ABC"
        assert (prior.grade == "C") == prior.source.startswith("judgement"), name
        assert prior.reason
        assert not prior.overridden
        assert all(f"{number:.3g}" in prior.text for number in prior.numbers), name


def test_an_override_changes_its_own_numbers_in_si_and_names_the_default():
    priors = parse_scene(SCENE, "bend").priors
    speed = priors["speed_b"]
    assert speed.numbers == pytest.approx((40 * MPH,))
    assert speed.text == "half-normal, scale 17.9 m/s"
    assert default_priors()["speed_b"].text in speed.reason
    assert (speed.source, speed.grade, speed.overridden) == ("a survey", "C", True)
    assert priors["e"].numbers == pytest.approx((0.2, 0.6, 12 * MPH))
    assert priors["mu"] == default_priors()["mu"]


def test_numbers_that_are_not_written_stay():
    text = without("slow", "over")
    assert parse_scene(text, "bend").priors["e"].numbers == (
        0.2,
        *default_priors()["e"].numbers[1:],
    )


def test_the_source_of_a_number_is_kept_beside_the_table_s():
    text = SCENE.replace("fast = 0.2", 'fast = { value = 0.2, source = "a test" }')
    assert parse_scene(text, "bend").priors["e"].source == "bumper beams met; a test"
