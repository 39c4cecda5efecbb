"""The answers in words and cells: the numbers of the studies, rounded to their errors."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from retrodict.findings.answers import ENFSI_SOURCE, verbal
from retrodict.findings.questions import WITHHELD, probability_by_points
from retrodict.findings.summary import summarise
from retrodict.result import Result
from retrodict.scene.asked import Comparison, Questions, read_proposition
from retrodict.scene.case import Case
from retrodict.scene.errors import SceneError
from retrodict.studies.probability import probability
from tests.report.conftest import fail, found_of


def answers(outcome, kind):
    return [each for each in found_of(outcome).questions if each.kind == kind]


def test_a_probability_is_printed_to_its_error(asked):
    first, never, *_ = answers(asked, "probability")
    share = float((asked.idata["posterior"]["speed_b"] > 45 * 0.44704).mean())
    assert first.title == (
        "Probability that the impact speed of B is above 20.12 m/s (72.42 km/h; 45 mph)"
    )
    value, error = map(float, re.findall(r"([\d.]+) %", first.sentences[0]))
    assert value == pytest.approx(100 * share, abs=error)
    assert error == pytest.approx(100 * first.numbers.error, rel=0.5)
    assert "the probability is below" in never.sentences[0]


def test_a_compound_names_each_of_its_quantities(asked):
    text = "speed_b > 45 mph and (e < 0.2 or speed_a - speed_b > 5 m/s)"
    questions = Questions(probabilities=(read_proposition(text),))
    made = replace(asked, scene=replace(asked.scene, questions=questions))
    (found,) = answers(made, "probability")
    assert found.title == (
        "Probability that the travelling speed of B before its skid is above 20.12 m/s (72.42 km/h; "
        "45 mph) and (the restitution e is below 0.2 or the impact speed of A, less the travelling "
        "speed of B before its skid, is above 5 m/s (18 km/h; 11.18 mph))"
    )
    summary = next(
        each["numbers"] for each in summarise(found_of(made))["questions"]
        if each["kind"] == "probability"
    )  # fmt: skip
    assert (summary["proposition"], summary["low"]) == (text, None)
    assert summary["quantity"] == "travelling_speed_b, e, speed_a"


def test_the_speed_of_a_car_that_skidded_is_asked_before_its_skid_unless_by_name(sparse):
    texts = ("speed_b > 20 m/s", "travelling_speed_b > 20 m/s", "impact_speed_b > 20 m/s")
    questions = Questions(probabilities=tuple(map(read_proposition, texts)))
    made = replace(sparse, scene=replace(sparse.scene, questions=questions))
    either, travelling, impact = answers(made, "probability")
    draws = sparse.idata["posterior"]
    assert either.numbers.value == travelling.numbers.value
    assert travelling.numbers.value == float((draws["travelling_speed_b"] > 20).mean())
    assert impact.numbers.value == float((draws["speed_b"] > 20).mean())
    assert "before its skid" in either.title
    assert impact.title.startswith("Probability that the impact speed of B")
    (beside,) = either.sentences[-1:]
    assert "which a speed limit is about" in beside
    assert f"{100 * impact.numbers.value:.0f}"[:2] in beside
    assert len(travelling.sentences) == len(impact.sentences) == len(either.sentences) - 1


def test_of_a_car_that_did_not_skid_the_speeds_are_one(outcome):
    texts = ("speed_b > 19 m/s", "travelling_speed_b > 19 m/s", "impact_speed_b > 19 m/s")
    questions = Questions(probabilities=tuple(map(read_proposition, texts)))
    made = replace(outcome, scene=replace(outcome.scene, questions=questions))
    assert len({each.numbers.value for each in answers(made, "probability")}) == 1


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (1, "none"), (1.9, "none"), (2, "weak"), (9.9, "weak"), (10, "moderate"),
        (100, "moderately strong"), (1000, "strong"), (9999, "strong"), (1e4, "very strong"),
        (1e6, "extremely strong"), (1e9, "extremely strong"),
    ],
)  # fmt: skip
def test_the_verbal_scale_is_that_of_enfsi(ratio, words):
    assert verbal(ratio) == words


def test_a_likelihood_ratio_names_the_prior_the_scale_and_what_is_favoured(asked):
    (found,) = answers(asked, "likelihood_ratio")
    assert found.numbers.value < 1  # the second is favoured, and stands first in the sentence
    said = " ".join(found.sentences)
    above, below = said.index("above 20.12 m/s"), said.index("below 17.88 m/s")
    assert above < below
    times = float(re.search(r"is ([\d.]+) times", said)[1])
    assert times * found.numbers.value == pytest.approx(1, rel=0.1)
    assert ENFSI_SOURCE in said
    assert "half-normal, scale 30 m/s" in said
    assert len(found.rows) == 2


def test_avoidability_says_what_was_assumed(asked):
    (found,) = answers(asked, "avoidability")
    said = " ".join(found.sentences)
    for words in ("one reaction time before the skid", "1.20 ± 0.30 s", "6.86 ± 0.69 m/s²"):
        assert words in said
    numbers = found.numbers
    assert numbers.avoided.value == pytest.approx(numbers.stopped.value + numbers.passed.value)


def test_a_question_that_cannot_be_answered_says_what_to_write(outcome, asked):
    made = replace(outcome, scene=replace(outcome.scene, questions=asked.scene.questions))
    (found,) = answers(made, "avoidability")
    assert found.numbers is None
    assert found.sentences[0].startswith("Not answered: ")
    assert "seen_time" in found.sentences[0]
    momentum = Questions(probabilities=(read_proposition("pdof_a > 3 deg"),))
    made = replace(outcome, scene=replace(outcome.scene, questions=momentum))
    (found,) = answers(made, "probability")
    assert "has no pdof_a" in found.sentences[0]


def test_a_withheld_result_answers_no_question(asked):
    for each in found_of(fail(asked)).questions:
        assert each.sentences == (WITHHELD,)
        assert (each.numbers, each.rows) == (None, ())


def test_a_table_has_a_cell_for_each_column(asked):
    found = found_of(asked).questions
    tables = [each for each in found if each.header]
    assert {each.kind for each in tables} >= {"time_distance", "one_at_a_time", "checks"}
    for each in tables:
        assert each.rows
        assert {len(row) for row in each.rows} == {len(each.header)}


def test_what_is_not_asked_is_not_answered(outcome):
    quiet = Questions(one_at_a_time=False, checks=False)
    made = replace(outcome, scene=replace(outcome.scene, questions=quiet))
    assert found_of(made).questions == ()


def test_a_notebook_asks_one_question(outcome):
    found = Result(outcome).probability("speed_b > 45 mph")
    exact = probability(outcome, read_proposition("speed_b > 45 mph"))
    assert found.numbers == exact
    with pytest.raises(ValueError, match="no unit"):
        Result(outcome).probability("speed_b > 45")


def test_named_checks_compare_what_was_measured(sparse, outcome):
    """A's recorded delta-v, forward, against what all else says of it."""
    (found,) = answers(sparse, "checks")
    check = next(c for c in found.numbers if c.name == "delta-v" and c.measured is not None)
    item = next(i for i in found_of(sparse).left_out if i.name == "departure_delta_v_forward_a")
    assert (check.measured, check.predicted) == (item.value, item.expected)
    assert check.off == pytest.approx((item.value - item.expected) / item.expected_sd)
    (without,) = answers(outcome, "checks")
    assert all(c.measured is None for c in without.numbers if c.name != "common velocity")
    assert {c.name for c in without.numbers} == {
        "common velocity", "delta-v", "PDOF", "energy", "Newton's third law",
    }  # fmt: skip


def test_effects_are_sorted_and_their_table_is_short(outcome):
    (found,) = answers(outcome, "one_at_a_time")
    moved = np.abs([each.moved for each in found.numbers])
    assert list(moved) == sorted(moved, reverse=True)
    assert len(found.rows) == 12
    assert found.rows[0][0] != found.rows[1][0]


def test_a_case_s_questions_are_answered_after_the_scene_s(asked):
    result = Result(asked)
    found = result.findings_for(Case(questions={"exceeds": "speed_b > 30 mph"})).questions
    assert found[:-1] == result.findings.questions
    assert found[-1].title.endswith("above 13.41 m/s (48.28 km/h; 30 mph)")
    with pytest.raises(SceneError, match=r"case file: questions\.exceeds"):
        result.findings_for(Case(questions={"exceeds": "speed_b > 30"}))


def test_a_bound_is_printed_without_powers_of_ten(outcome):
    pair = [read_proposition(t) for t in ("speed_b > 18 m/s", "speed_b < 10 m/s")]
    asked = Questions(comparisons=(Comparison(*pair),))
    (found,) = answers(
        replace(outcome, scene=replace(outcome.scene, questions=asked)), "likelihood_ratio"
    )
    assert found.numbers.bound == "at least"
    (printed,) = re.findall(r"is at least (\d+) times", found.sentences[0])
    assert float(printed) == pytest.approx(found.numbers.value, rel=0.05)


def test_a_session_too_answers_for_both_speeds_of_a_vehicle_that_skidded() -> None:
    speeds = {"travelling_speed_a": np.full(400, 19.7), "speed_a": np.linspace(13.0, 17.0, 400)}
    estimate = SimpleNamespace(
        scene=SimpleNamespace(travelled=("a",), alone=False),
        quantities=speeds,
        checks=SimpleNamespace(passed=True, min_ess_bulk=400.0, pareto_k=0.2),
        weighted=SimpleNamespace(mean=lambda holds: (holds.mean(), 0.02)),
    )
    found = probability_by_points(estimate, read_proposition("speed_a > 35 mph"))
    assert found.title.startswith("Probability that the travelling speed of A before its skid")
    assert "the probability is 34 %" in found.sentences[1]
    assert found.in_units("us").title.endswith("is above 35 mph (15.65 m/s; 56.33 km/h)")
    at_impact = probability_by_points(estimate, read_proposition("impact_speed_a > 35 mph"))
    assert len(at_impact.sentences) == 1
