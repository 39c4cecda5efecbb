"""Priors: the defaults against what was published, and overrides."""

from __future__ import annotations

import math

import pytest

from retrodict.scene import SceneError, parse_scene
from retrodict.scene.priors import default_priors
from retrodict.scene.write import scene_toml
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


FAMILIES = {
    "e": (
        {"family": "beta", "alpha": 2, "beta": 9},
        ("beta", (2.0, 9.0), "beta, α = 2, β = 9"),
    ),
    "e_m": (
        {"family": "normal", "mean": 0.8, "sd": 0.1},
        ("normal", (0.8, 0.1), "normal, 0.8 ± 0.1, cut to -1 to 1"),
    ),
    "mu": (
        {"family": "uniform", "low": 0.3, "high": 0.7},
        (
            "uniform",
            (0.3, 0.7),
            "friction that the contact can exert: uniform from 0.3 to 0.7; |μ| is that friction, or "
            "|μ_c| where sliding ends before",
        ),
    ),
    "speed_b": (
        {"family": "lognormal", "mean": "40 mph", "sd": "5 mph"},
        (
            "lognormal",
            (40 * MPH, 5 * MPH),
            "log-normal, mean 17.9, sd 2.24 m/s, cut at 0",
        ),
    ),
}


@pytest.mark.parametrize("name", FAMILIES)
def test_a_prior_of_a_family_is_read_said_and_written_again(name):
    written, (family, numbers, text) = FAMILIES[name]
    plain = parse_scene(SCENE, "bend")
    scene = plain.change({f"priors.{name}": written | {"source": "a survey"}})
    prior = scene.priors[name]
    assert (prior.family, prior.text, prior.source) == (family, text, "a survey")
    assert prior.numbers == pytest.approx(numbers)
    assert prior.reason.startswith("the user's own, written in the scene file, in place of: ")
    assert default_priors()[name].text in prior.reason
    again = parse_scene(scene_toml(scene), "bend").priors[name]
    assert again.family == family
    assert again.numbers == pytest.approx(numbers)


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ({"family": "gamma", "mean": 0.1, "sd": 0.1}, 'write family = "normal", "lognormal"'),
        (
            {"family": "beta", "alpha": 2},
            'beta: missing; a prior of family = "beta" has alpha and beta',
        ),
        ({"family": "beta", "alpha": 2, "beta": 3, "sd": 1}, "leave this out"),
        ({"mean": 0.1}, 'is not said; write family = "normal" or family = "lognormal"'),
        (
            {"family": "uniform", "low": 0.5, "high": 0.1},
            "high = 0.1: not above low; exchange them",
        ),
        ({"family": "lognormal", "mean": 0, "sd": 0.1}, "write a mean above 0"),
        ({"family": "fixed", "value": 1.2}, "between 0 and 1"),
        ({"family": "normal", "mean": "0.1 ± 0.1", "sd": 0.1}, "no uncertainty is used here"),
    ],
)
def test_a_family_that_cannot_be_used_is_refused_with_what_to_write(written, said):
    with pytest.raises(SceneError) as caught:
        parse_scene(SCENE, "bend").change({"priors.e": written | {"source": "a survey"}})
    assert said in str(caught.value)


def test_a_prior_of_a_speed_that_is_measured_is_refused():
    fixed = {"family": "fixed", "value": "20 m/s", "source": "a survey"}
    with pytest.raises(SceneError, match=r"vehicles.A.approach.speed is measured"):
        parse_scene(SCENE, "bend").change({"priors.speed_a": fixed})
