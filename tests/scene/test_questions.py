"""What a `[questions]` table may ask, and what is refused with one line that says what to write."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ConfigDict, TypeAdapter
from typing_extensions import TypedDict

from retrodict.scene import parse_scene
from retrodict.scene.asked import ASKABLE, Proposition, Questions, read_proposition
from retrodict.scene.errors import SceneError
from retrodict.scene.quantities import describe
from retrodict.scene.questions import questions_from
from retrodict.scene.units import QuantityError
from retrodict.scene.write import scene_text, scene_toml
from tests.shared.scene_file import SCENE

MPH = 0.44704


@pytest.mark.parametrize(
    ("text", "name", "low", "high"),
    [
        ("speed_b > 45 mph", "speed_b", 45 * MPH, math.inf),
        ("speed_b>=72 km/h", "speed_b", 20.0, math.inf),
        ("delta_v_a at most 30 ft/s", "delta_v_a", -math.inf, 9.144),
        ("omega_b below -60 deg/s", "omega_b", -math.inf, -math.pi / 3),
        ("e > 0.2", "e", 0.2, math.inf),
        ("energy_lost above 100 kJ", "energy_lost", 1e5, math.inf),
        ("40 mph < speed_b <= 50 mph", "speed_b", 40 * MPH, 50 * MPH),
        ("speed_b  between 40 mph and 50 mph", "speed_b", 40 * MPH, 50 * MPH),
    ],
)
def test_a_proposition_is_read_in_any_unit(text, name, low, high):
    found = read_proposition(text)
    assert (found.name, found.text) == (name, " ".join(text.split()))
    assert (found.low, found.high) == pytest.approx((low, high))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("speed_b > 45", "no unit"),
        ("speed_b > 45 kg", "does not measure a speed"),
        ("speed_b > 45 ± 2 mph", "no uncertainty"),
        ("mass_a > 1000 kg", "not a reported quantity"),
        ("50 mph < speed_b < 40 mph", "the smaller limit first"),
        ("speed_b", "not a proposition"),
        ("speed_b > 1 > 2", "not a quantity"),
        ("__import__('os').system('id') > 3", "not a proposition"),
        ("speed_b > \x1b[31m45 mph", "not a quantity"),
        ("speed_b > " + "9" * 200, "not a proposition"),
        (45, "not a proposition"),
        ("speed_b at most 0 mph", 'of a vehicle that stood write "speed_b < 1 mph"'),
        ("speed_a - e > 1 m/s", "no quantity"),
        ("speed_a - speed_a > 1 m/s", "no quantity"),
        ("speed_a - mass_b > 1 m/s", "mass_b is not a reported quantity"),
        ("speed_a > 1 m/s and", "not a proposition"),
        ("or speed_a > 1 m/s", "not a proposition"),
        ("(speed_a > 1 m/s", "not closed"),
        ("speed_a > 1 m/s) or e > 0.1", 'stands where "and" or "or" has to'),
        ("speed_a > 1 m/s (\x1b[31m)", 'stands where "and" or "or" has to'),
        ("()", "not a proposition"),
        ("(" * 6 + "e > 0.1" + ")" * 6, "parentheses within each other"),
        (" or ".join(["e > 0.1"] * 13), "ask several questions"),
        ("(" * 5000, "not a proposition"),
    ],
)
def test_what_is_no_proposition_is_refused_in_one_line(text, words):
    with pytest.raises(QuantityError, match=words) as found:
        read_proposition(text)
    assert "\n" not in str(found.value)
    assert str(found.value).isprintable()


def test_a_difference_and_a_sum_of_quantities_are_read():
    less, both = map(read_proposition, ("speed_a - speed_b > 10 mph", "speed_a+speed_b<90 km/h"))
    assert (less.names, less.sign, less.low) == (("speed_a", "speed_b"), -1, 10 * MPH)
    assert (both.names, both.sign, both.high) == (("speed_a", "speed_b"), 1, 25.0)
    skidded = less.meant(("a",))
    assert skidded.names == ("travelling_speed_a", "speed_b")


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("speed_a > 1 m/s and e < 0.5", lambda v, e: v > 1 and e < 0.5),
        ("speed_a > 1 m/s OR e < 0.5", lambda v, e: v > 1 or e < 0.5),
        ("e > 0.9 or e < 0.1 and speed_a > 1 m/s", lambda v, e: e > 0.9 or (e < 0.1 and v > 1)),
        ("(e > 0.9 or e < 0.1) and speed_a > 1 m/s", lambda v, e: (e > 0.9 or e < 0.1) and v > 1),
        ("speed_a between 1 m/s and 2 m/s and e < 0.5", lambda v, e: 1 < v < 2 and e < 0.5),
        ("e<0.5 and(0.5 m/s<speed_a<1.5 m/s)", lambda v, e: e < 0.5 and 0.5 < v < 1.5),
        ("((speed_a > 2 m/s)) or (e > 0.5 and (e < 0.7 or speed_a < 1 m/s))",
         lambda v, e: v > 2 or (e > 0.5 and (e < 0.7 or v < 1))),
    ],
)  # fmt: skip
def test_propositions_are_joined_as_python_joins_them(text, holds):
    rng = np.random.default_rng(0)
    draws = {"speed_a": rng.uniform(0, 3, 500), "e": rng.uniform(0, 1, 500)}
    found = read_proposition(text)
    assert found.joined
    wanted = [holds(*each) for each in zip(draws["speed_a"], draws["e"], strict=True)]
    assert found.holds_for(draws.__getitem__).tolist() == wanted
    assert read_proposition(found.text) == found
    assert set(found.names) == {"speed_a", "e"}


WORDS = ["speed_a", "speed_b", "e", ">", "<", "at most", "between", "and", "or", "(", ")", "-", "+"]
WORDS += ["10 mph", "0.2", "20 m/s", "± 1", "\x1b", "²", "__class__", "9" * 30]


@settings(max_examples=2000, deadline=None)
@given(st.lists(st.sampled_from(WORDS) | st.text(max_size=6), max_size=40).map(" ".join))
def test_any_text_is_a_proposition_or_refused_in_one_line(text):
    try:
        found = read_proposition(text)
    except QuantityError as error:
        said = str(error)
    else:
        assert isinstance(found, Proposition)
        assert read_proposition(found.text) == found
        said = found.text
    assert said.isprintable()


def test_every_reported_quantity_may_be_asked():
    assert {"speed_b", "delta_v_a", "Omega_b", "energy_lost", "closing_speed"} < set(ASKABLE)
    units = {"speed": "m/s", "yaw rate": "rad/s", "energy": "kJ", "angle": "deg", "number": ""}
    for name in ASKABLE:
        assert read_proposition(f"{name} > 1 {units[describe(name)[1]]}".rstrip()).name == name


FULL = {
    "exceeds": [
        "speed_b > 45 mph",
        "delta_v_a > 30 km/h",
        "e < 0.2 and (mu > 1 or speed_a - speed_b > 1 mph)",
    ],
    "between": "40 mph < speed_b < 50 mph",
    "likelihood_ratio": [{"first": "speed_b at most 45 mph", "second": "speed_b at least 55 mph"}],
    "avoidable": [
        {
            "vehicle": "B",
            "limit": "45 mph",
            "reaction": "1.5 ± 0.3 s",
            "deceleration": "0.7 ± 0.07 g",
            "seen_time": "2.5 ± 0.3 s",
        }
    ],
    "time_distance": "3 s",
    "corners": True,
}


def test_a_table_is_read_whole():
    found = questions_from(FULL, "case.toml")
    names = [("speed_b",), ("delta_v_a",), ("e", "mu", "speed_a", "speed_b"), ("speed_b",)]
    assert [each.names for each in found.probabilities] == names
    (ratio,) = found.comparisons
    assert (ratio.first.high, ratio.second.low) == pytest.approx((45 * MPH, 55 * MPH))
    (avoidance,) = found.avoidance
    assert avoidance.vehicle == "b"
    assert avoidance.deceleration.value == pytest.approx(0.7 * 9.80665)
    assert (found.time_distance, found.corners, found.checks) == (3.0, True, True)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"exceeds": "speed_c > 3 m/s"}, 'questions.exceeds = "speed_c > 3 m/s": speed_c is not'),
        ({"exceeds": "1 m/s < speed_b < 2 m/s"}, "write it under between"),
        ({"between": "speed_b < 2 m/s"}, "write it under exceeds"),
        ({"between": "e > 0.1 and e < 0.2"}, "is several propositions; write it under exceeds"),
        (
            {"likelihood_ratio": [{"first": "e > 0.1 or e < 0", "second": "e < 1"}]},
            "is several propositions; write one",
        ),
        (
            {"likelihood_ratio": [{"first": "speed_a - speed_b < 5 m/s", "second": "e < 1"}]},
            "not two propositions",
        ),
        ({"exceed": "speed_b > 3 m/s"}, 'unknown key; did you mean "exceeds"?'),
        ({"likelihood_ratio": [{"first": "e > 1", "second": "e < 1"}]}, "not two propositions"),
        (
            {"likelihood_ratio": [{"first": "speed_b < 5 m/s", "second": "speed_b < 4 m/s"}]},
            "both may hold at once",
        ),
        ({"avoidable": [{"vehicle": "C"}]}, "questions.avoidable[0].vehicle"),
        ({"time_distance": "3 m"}, "does not measure a time"),
        ({"corners": "yes"}, "questions.corners"),
    ],
)
def test_what_does_not_fit_is_named_with_its_place(change, line):
    with pytest.raises(SceneError) as found:
        questions_from(change, "case.toml")
    assert line in str(found.value)
    assert all(each.startswith("case.toml: questions") for each in str(found.value).splitlines())


def test_a_scene_without_questions_asks_the_default():
    assert parse_scene(SCENE, "example").questions == Questions()


def test_a_scene_file_may_ask():
    asked = SCENE + '\n[questions]\nexceeds = "speed_b > 45 mph"\n'
    (found,) = parse_scene(asked, "example").questions.probabilities
    assert found.low == pytest.approx(45 * MPH)


def test_questions_survive_being_written_anew():
    asked = questions_from(FULL, "case.toml")
    scene = replace(parse_scene(SCENE, "example"), questions=asked)
    assert parse_scene(scene_toml(scene), "example").questions == asked
    assert scene_text(scene).as_written  # a question changes nothing that was measured
    record = TypedDict("record", {"questions": Questions})  # noqa: UP013 - it takes a configuration
    record.__pydantic_config__ = ConfigDict(ser_json_inf_nan="strings")  # as results are stored
    stored = TypeAdapter(record)
    assert stored.validate_json(stored.dump_json({"questions": asked})) == {"questions": asked}
