"""The report of a validation: table, remarks, files and chart."""

import csv
import io
import json

import matplotlib.image
import pytest
from rich.console import Console

from retrodict.report.figures.drawing import ORANGE
from retrodict.report.figures.validation import errors_figure, validation_figure
from retrodict.report.validation import (
    cells,
    groups,
    narrowing_lines,
    print_validation,
    remark_lines,
    table_lines,
    write_validation,
)
from retrodict.studies.narrowing import Narrowed
from retrodict.studies.validation import Score, Validation
from tests.studies.made_up import summary

SAID = "an answer <b>|withheld</b>"


@pytest.fixture
def validation() -> Validation:
    """Three speeds: one inside, one outside its 95 % interval, one withheld."""
    return Validation(
        (
            Score(
                *("one", "speed_a", 10.0, "low", summary(10.5, 1.0)),
                published={"P": 11.176},
                below=0.3,
                groups={"kind": "barrier"},
                seconds=12.0,
                narrowed=(Narrowed("Omega_b", None, 0.525), Narrowed("mass_a", None, 0.84)),
            ),
            Score("one", "speed_b", 10.0, "low", summary(12.5, 1.0), note="a remark"),
            Score("two", "speed_b", 20.0, "full", summary(20.0, 1.0), (SAID,)),
        ),
        "auto",
        "nuts",
    )


def test_numbers_are_printed_in_the_units_asked(validation):
    row = cells(validation.scores[0], "us")
    assert row["true"] == "22.37"  # 10 / 0.44704
    assert row["published"] == "P 25.00"
    assert row["error"] == "5.0 %"
    assert row["sd"] == "9.5 %"  # of the median
    assert row["90 %"].endswith("*")
    assert not cells(validation.scores[1])["95 %"].endswith("*")


def test_a_withheld_answer_has_no_number_in_the_table(validation):
    row = cells(validation.scores[2])
    assert row["median ± sd"] == row["50 %"] == row["95 %"] == "withheld"
    assert row["checks"] == "FAILED"
    assert row["error"] == row["sd"] == "–"


def test_coverage_is_that_of_answers_that_count(validation):
    said = "\n".join(remark_lines(validation))
    assert "The 90 % interval holds the truth in 1 of 2 (95 % limits" in said
    assert "one: a remark" in said


def test_groups_have_their_own_rows(validation):
    everything, barrier = groups(validation)
    assert (everything["group"], everything["speeds"], everything["answered"]) == ("all", "3", "2")
    assert (barrier["group"], barrier["speeds"]) == ("kind: barrier", "1")
    assert everything["90 %"] == "1 (1% to 99%)"  # Clopper & Pearson: 0.0126 to 0.9874
    assert everything["median error"] == "15.0 %"  # of 5 and 25 %
    assert barrier["rms error/sd"] == "0.50"


def test_errors_over_sd_and_shares_are_drawn_of_answers_that_count(validation):
    left, right = errors_figure(validation).axes
    points = [line for line in left.lines if line.get_marker() == "o"]
    assert sorted(x for line in points for x in line.get_xdata()) == [0.5, 2.5]
    (steps,) = [line for line in right.lines if line.get_drawstyle() == "steps-post"]
    assert list(steps.get_xdata()) == [0.0, 0.3, 1.0]


def test_what_would_narrow_an_answer_is_printed_next_to_its_sd(validation):
    said = "\n".join(narrowing_lines(validation))
    assert (
        "one: the sd of the impact speed of A is 9.5 %; known exactly, the yaw rate of B after "
        "impact would leave 5.0 %, the mass of A 8.0 %."
    ) in said


def test_what_users_write_is_text_in_markdown_and_terminal(validation):
    said = "\n".join(remark_lines(validation))
    assert r"\<b\>\|withheld\</b\>" in said
    rows = table_lines(validation)
    assert len({row.count("|") for row in rows}) == 1
    out = io.StringIO()
    print_validation(validation, Console(file=out, width=120))
    assert SAID in out.getvalue()


def test_files_hold_the_numbers(validation, tmp_path):
    write_validation(validation, tmp_path)
    content = json.loads((tmp_path / "validation.json").read_text())
    assert content["coverage"]["50"] == pytest.approx(
        {"inside": 1, "of": 2, "low": 0.0126, "high": 0.9874}, abs=1e-4
    )
    assert [score["passed"] for score in content["scores"]] == [True, True, False]
    assert content["scores"][2]["answer"]["median"] == 20.0
    rows = list(csv.DictReader(io.StringIO((tmp_path / "validation.csv").read_text())))
    assert [row["90_inside"] for row in rows] == ["True", "False", "False"]
    assert "| one | A | 10.00 | 10.5 ± 1.0 |" in (tmp_path / "validation.md").read_text()
    assert (tmp_path / "validation.svg").read_text().startswith("<?xml")
    assert matplotlib.image.imread(tmp_path / "validation.png").shape[0] > 200
    assert (tmp_path / "validation-errors.svg").read_text().startswith("<?xml")
    assert {(g["group"], g["label"]) for g in content["groups"]} == {("kind", "barrier")}
    assert content["scores"][0]["below"] == 0.3


def test_each_row_of_the_chart_holds_its_truth_and_none_an_answer_withheld(validation):
    (axes,) = validation_figure(validation, "si").axes
    truths = [line.get_xydata()[0] for line in axes.lines if line.get_color() == ORANGE]
    assert [tuple(at) for at in truths] == [(10.0, 0.0), (10.0, 1.0), (20.0, 2.0)]
    bars = [line.get_ydata()[0] for line in axes.lines if line.get_solid_capstyle() == "butt"]
    assert bars == [0, 0, 0, 1, 1, 1]
    assert [text.get_text() for text in axes.texts] == ["withheld"]


def test_nothing_finished_is_drawn_and_reported_as_such(tmp_path):
    write_validation(Validation((), "auto", "nuts", complete=False), tmp_path)
    assert "Interrupted: cases are missing." in (tmp_path / "validation.md").read_text()
