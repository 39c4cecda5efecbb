"""The report of the ladder: table, files, chart and the report's section."""

import csv
import io
import json
from dataclasses import replace

import matplotlib.image
import pytest
from matplotlib.text import Text
from rich.console import Console

from retrodict import findings
from retrodict.findings.summary import summarise
from retrodict.report.figures.ladder import distance, ladder_figure
from retrodict.report.html import render
from retrodict.report.ladder import write_ladder
from retrodict.report.terminal import print_ladder, print_summary
from retrodict.studies.comparison import Step
from tests.report.conftest import make_outcome, make_scene
from tests.report.documents import document_of
from tests.studies.made_up import ladder_of, step

EVIL = "[red]<script>alert(1)</script>\x1b[31m"


@pytest.fixture
def ladder():
    return ladder_of(step("low", 21.0, 0.9), step("middle", 19.1), step("full", 19.0))


def printed(ladder, units="si", width=80):
    out = io.StringIO()
    print_ladder(ladder, Console(file=out, width=width), units)
    return out.getvalue()


def test_table_lists_every_rung_in_the_units_asked_for(ladder) -> None:
    assert "21.00│" in printed(ladder)
    assert "± 0.90│" in printed(ladder)
    assert "± 2.0│" in printed(ladder, "us")
    assert "…" not in printed(ladder)  # nothing is cut on a narrow terminal
    assert "│ low    │ 21.00 ± 0.90 │" in printed(ladder, width=140)
    assert "middle is the simplest model" in printed(ladder)
    assert "full shifts the impact speed of B" in printed(ladder)


def test_the_summary_of_a_run_says_who_chose_its_model(ladder) -> None:
    out = io.StringIO()
    print_summary(findings.compute(make_outcome(make_scene()), ladder), Console(file=out, width=80))
    assert "model: middle is the simplest model" in out.getvalue()


def test_a_stranger_s_text_is_neither_markup_nor_an_escape_sequence(ladder) -> None:
    ladder = replace(ladder, scene=replace(ladder.scene, title=EVIL))
    text = printed(ladder)
    assert "[red]" in text
    assert "\x1b" not in text


def test_files_are_written_whole_and_hold_the_numbers(ladder, tmp_path) -> None:
    not_run = Step("none", (), verdict="needs rest heading")
    write_ladder(replace(ladder, steps=(not_run, *ladder.steps)), tmp_path)
    names = {"ladder.json", "ladder.csv", "ladder.png", "ladder.svg"}
    assert {p.name for p in tmp_path.iterdir()} == names
    data = json.loads((tmp_path / "ladder.json").read_text())
    assert data["choice"] == "middle"
    assert data["steps"][1]["answers"]["speed_b"]["median"] == 21.0
    assert data["steps"][1]["fit"]["items"][1]["residual"] is None
    rows = list(csv.DictReader((tmp_path / "ladder.csv").open()))
    assert [row["speed_b_median"] for row in rows] == ["", "21.0", "19.1", "19.0"]
    assert [row["chosen"] for row in rows] == ["False", "False", "True", "False"]
    assert matplotlib.image.imread(tmp_path / "ladder.png")[..., :3].std() > 0.05
    assert "<svg" in (tmp_path / "ladder.svg").read_text()


def test_what_is_not_finite_is_no_number_in_json(tmp_path) -> None:
    odd = ladder_of(step("low", 19.0, log_evidence_sd=float("nan")))
    write_ladder(odd, tmp_path)
    assert json.loads((tmp_path / "ladder.json").read_text())["steps"][0]["log_evidence_sd"] is None


def test_chart_names_every_rung_and_rings_the_choice(ladder) -> None:
    figure = ladder_figure(ladder)
    words = {text.get_text() for text in figure.findobj(Text)}
    assert {"low", "middle", "full"} <= words
    rings = [line for line in figure.axes[0].lines if line.get_markersize() == 13]
    assert len(rings) == 1
    (x,), (y,) = rings[0].get_data()
    assert x == ladder.step("middle").seconds
    assert y == pytest.approx(0.1)


def test_distance_is_in_the_fullest_rung_s_standard_deviations() -> None:
    assert distance(step("low", 19.0, 0.5), step("full", 21.0, 4.0)) == 0.5


def test_report_and_summary_state_the_choice_and_the_others(ladder, outcome) -> None:
    hostile = replace(ladder, reason=EVIL)
    page = render(document_of(outcome, ladder=hostile)).decode()
    assert "Comparison of models" in page
    assert "21.0 ± 0.9" in page  # no more digits than of the speed itself
    assert "<script" not in page
    assert "Comparison of models" not in render(document_of(outcome)).decode()
    assert summarise(findings.compute(outcome, ladder))["ladder"]["choice"] == "middle"
    assert summarise(findings.compute(outcome))["ladder"] is None
