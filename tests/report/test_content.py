"""What a report says: the question that was asked, the answer first, and nothing that was not stated."""

from dataclasses import replace

import pytest

from retrodict import findings
from retrodict.findings.answers import Answered
from retrodict.findings.record import Cause
from retrodict.report.blocks import Picture, Table
from retrodict.report.content import content
from retrodict.report.figures.registry import FIGURES, Registered
from retrodict.scene.case import Attachment, Case
from tests.report.documents import (
    EVIL,
    EVIL_PRINTED,
    blocks,
    document_of,
    evil_outcome,
    section,
    text_of,
)
from tests.studies.made_up import ladder_of, step


@pytest.fixture(scope="module")
def good(outcome):
    return document_of(outcome)


def test_the_first_page_has_question_answer_scene_causes_verdict_and_assumptions(good):
    text = text_of(good.first)
    assert "How fast did vehicle B travel before the impact?" in text
    assert "with 95 % probability between 17.4 and 21.0 m/s (63 and 76 km/h; 39 and 47 mph)" in text
    assert "The measured quantities that contribute most" in text
    assert "Yes: every check of the draws was passed." in text
    assert "whether a measurement is wrong" in text
    assert "yaw inertia of A" in text_of(section(good, "Assumed rather than measured"))
    assert [b.caption for b in good.first if isinstance(b, Picture)] == ["Drawn to scale."]


def test_the_largest_causes_stand_on_the_first_page_with_their_shares(outcome):
    causes = (Cause("mass_a", 0.8042, 0.004), Cause("mass_b", 0.106, 0.02))
    text = text_of(document_of(outcome, causes={"speed_b": causes}).first)
    assert "impact speed of B: mass of A 80 %, mass of B 10 %" in text


def test_the_question_is_the_one_that_was_asked(outcome):
    def asked(*names):
        scene = replace(outcome.scene, question=names)
        return findings.compute(replace(outcome, scene=scene)).question

    assert asked("speed_a", "speed_b").startswith("How fast did vehicle A and vehicle B travel")
    assert asked("e") == (
        "What was the restitution e? The answer rests on what was measured, as listed below."
    )
    assert "restitution" not in asked("speed_b")


def test_results_stand_in_both_systems_and_once_where_they_are_the_same(good):
    si, us = (b for b in section(good, "Results").blocks if isinstance(b, Table))
    assert ("impact speed of B, m/s", "19.1", "19.2 ± 0.9") in [row[:3] for row in si.rows]
    assert ("impact speed of B, mph", "42.8", "42.9 ± 2.0") in [row[:3] for row in us.rows]
    assert "restitution e" in [row[0] for row in si.rows]
    assert "restitution e" not in [row[0] for row in us.rows]


@pytest.mark.parametrize(
    ("title", "wanted"),
    [
        ("Priors", "half-normal, scale 0.2, cut at 1"),
        ("Priors", "staged car crashes"),
        ("Left out", "secondary impacts, and crush as evidence"),
        ("Where they come from", "skid test"),
        ("Where they come from", "uncertainty assumed"),
        ("The investigator's remarks", "The weather was dry."),
        ("What the probability means", "ENFSI"),
        ("Numerical quality", "4 × 500"),
        (
            "Reproduction",
            "retrodict reconstruct scene.toml --model planar-moment+wheels --method nuts --chains 4 "
            "--draws 500 --warmup 500 --seed 20",
        ),
        ("Reproduction", "3.12.1"),
        ("The expert", "Compensation not stated"),
    ],
)
def test_the_report_holds_what_a_court_asks_for(good, title, wanted):
    assert wanted in text_of(section(good, title))


def test_the_scene_file_is_given_with_its_digest_and_whether_it_was_changed(outcome, good):
    found = findings.compute(outcome).scene_text
    text = text_of(section(good, "Reproduction"))
    assert found.sha256 in text
    assert found.text.strip() in text
    assert (
        "made from the values that were computed with" in text
    )  # the fixture's text is no scene's


@pytest.mark.slow
def test_a_run_out_s_own_error_stands_beside_the_measurement(good, rolled):
    missed = rolled.scene.evidence()["rest_x_b"].model_sd
    text = text_of(document_of(rolled))
    assert f"6.60 ± 0.30, run-out ± {missed:.2f}" in text
    assert "the run-out misses each coordinate of B's place by 4.0 %" in text
    assert "run-out ±" not in text_of(good)


def test_a_failed_run_withholds_its_answer_and_marks_every_result(failing, good):
    document = document_of(failing)
    text = text_of(document)
    assert "NOT TO BE RELIED ON" in text
    assert "its speed before impact is withheld" in text
    assert "R-hat of e_m is 1.050" in text_of(document.first)
    assert "with 95 % probability" not in text
    results = [b for b in blocks(section_of_results(document)) if isinstance(b, Table)]
    cells = [cell for table in results for row in table.rows for cell in row[1:]]
    assert len(cells) > 50
    assert [cell for cell in cells if not cell.endswith(("†", "withheld"))] == []
    assert "4094 ± 75†" in text_of(document_of(failing, "us"))
    assert "†" not in text_of(good)
    assert "What would narrow the answer" not in text


def section_of_results(document):
    return replace(document, first=(), sections=(section(document, "Results"),))


def test_a_sampler_that_was_replaced_stands_under_the_checks(outcome):
    note = "the first sampler, nuts, was not accepted (R-hat is 1.05) and was replaced by smc"
    document = document_of(replace(outcome, notes=(note,)))
    assert note in text_of(section(document, "Numerical quality"))
    assert note not in text_of(section(document, "Evidence"))


def test_what_nothing_cross_checks_is_said_in_a_sentence(outcome):
    found = findings.compute(outcome)
    unreliable = tuple(replace(item, pareto_k=2.0) for item in found.left_out)
    text = text_of(section(document_of(outcome, left_out=unreliable), "Each item left out"))
    assert text.count("Nothing cross-checks") == 1
    assert "rest of A, x; rest of A, y" in text
    assert "–" not in text


def test_models_that_were_not_run_are_named_in_a_sentence(outcome):
    not_run = {"answers": {}, "fit": None, "verdict": "does not answer e"}
    left = replace(step("middle", 19.0), name="other", **not_run)
    ladder = ladder_of(step("low", 19.0), step("full", 19.1))
    ladder = replace(ladder, steps=(*ladder.steps, left, replace(left, name="third")))
    part = section(document_of(outcome, ladder=ladder), "Comparison of models")
    assert "Not run: other, third: does not answer e." in text_of(part)
    assert not any(isinstance(b, Table) and "third" in text_of(b.rows) for b in part.blocks)


def test_no_more_digits_are_printed_beside_a_result_than_of_it(outcome):
    """The speed is printed as 19.2 ± 0.9: the sd that a known input would leave has one decimal too."""
    (table,) = (
        b
        for b in section(document_of(outcome), "What would narrow the answer").blocks
        if isinstance(b, Table)
    )
    assert "(now 0.9)" in table.header[-1]
    assert {len(row[-1].partition(".")[2]) for row in table.rows} == {1}


def test_evidence_of_every_kind_is_registered(sparse):
    document = document_of(sparse)
    fit = text_of(section(document, "Measured and predicted"))
    for wanted in (
        "direction of travel of A after impact, deg 140.0 ± 8.0 (heavy-tailed)",
        "delta-v of A along its heading, m/s −13.0 ± 1.0 (heavy-tailed)",
        "mark 1 of B, distance from its path, m 0.00 ± 0.20 (heavy-tailed)",
        "mark 2 of B, direction of travel there, deg −55.0 ± 6.0 (heavy-tailed)",
        "end of rotation of B, heading, deg −50.0 ± 5.0 (heavy-tailed)",
        "stops sliding sideways and begins to roll",
        "mark 1 of B: x = 2.00 m, y = −1.50 m, front left wheel",
        "mark 2 of B: x = 4.50 m, y = −5.00 m, centre of gravity",
    ):
        assert wanted in fit
    assert "skid of B up to impact, m 12.00 ± 0.50 (lognormal)" in text_of(document)
    assert "mark 1 of B: x = 6.56 ft, y = −4.92 ft" in text_of(document_of(sparse, "us"))
    assert "rest of A" not in text_of(document)


def test_a_case_is_printed_and_nothing_else(outcome):
    photo = Attachment("b.jpg", "ab" * 32, 12, title="rest of B", by="B. Officer")
    case = Case(
        number="17/26",
        examiner="A. Examiner",
        propositions=("at most 45 mph",),
        attachments=(photo,),
    )
    document = document_of(outcome, case=case)
    assert document.author == "A. Examiner"
    assert "Case number 17/26" in text_of(document.first)
    assert "Instructed by not stated" in text_of(document.first)
    register = text_of(section(document, "Register"))
    assert "ab" * 32 in register
    assert "by B. Officer; how: not stated; when: not stated; source: not stated" in register
    assert "Propositions compared at most 45 mph" in text_of(section(document, "The expert"))


def test_questions_put_are_answered_on_the_first_page_and_in_full_with_their_figure(outcome):
    put = Answered(
        "probability",
        "Was B faster than 45 mph?",
        ("With probability 0.91 ± 0.01.", "Of 2000 draws."),
        ("Speed", "Probability"),
        (("45 mph", "0.91"),),
        "extra",
    )
    extra = Registered(None, "Exceedance", "What was found.")
    found = replace(findings.compute(outcome), questions=(put,))
    document = content(found, {"extra": b"PNG"}, {"extra": extra})
    assert "Was B faster than 45 mph?: With probability" not in text_of(document.first)
    assert "Was B faster than 45 mph? With probability 0.91 ± 0.01." in text_of(document.first)
    part = section(document, "Was B faster than 45 mph?")
    assert "Of 2000 draws." in text_of(part)
    assert [type(b).__name__ for b in part.blocks][-2:] == ["Table", "Picture"]


def test_every_figure_has_a_place(outcome):
    images = dict.fromkeys(FIGURES, b"PNG")
    document = content(findings.compute(outcome), images, FIGURES)
    pictures = [b for b in blocks(document) if isinstance(b, Picture)]
    assert sorted(p.title for p in pictures) == sorted(f.title for f in FIGURES.values())
    assert [p.number for p in pictures] == [str(n) for n in range(1, len(FIGURES) + 1)]


def test_characters_that_do_not_print_are_written_as_codes(outcome):
    document = document_of(evil_outcome(outcome, EVIL))
    assert document.title == EVIL_PRINTED
    assert "\x1b" not in text_of(document)


def test_missing_groups_do_not_break_the_report(outcome, drop):
    bare = outcome
    for group in ("prior", "posterior_predictive", "trajectories", "sample_stats"):
        bare = drop(bare, group)
    assert "17.4 and 21.0 m/s" in text_of(document_of(bare))
