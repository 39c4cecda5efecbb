import io
from dataclasses import replace

import pytest
from rich.console import Console

from retrodict.report.terminal import print_summary
from tests.report.conftest import found_of


def printed(outcome, units="si", width=140):
    out = io.StringIO()
    print_summary(found_of(outcome), Console(file=out, width=width), units)
    return out.getvalue()


def line_of(text, start):
    return next(line for line in text.splitlines() if start in line)


@pytest.mark.parametrize(
    ("units", "expected"), [("si", "19.2 ± 0.9"), ("us", "42.9 ± 2.0")]
)  # fmt: skip
def test_results_are_printed_in_the_units_asked_for(outcome, units, expected):
    line = line_of(printed(outcome, units), "impact speed of B")
    assert expected in line
    assert "1613 / 1783" in line


def test_a_good_run_says_that_its_checks_passed(outcome):
    text = printed(outcome)
    assert "Checks passed: 0 divergences, R-hat at most 1.002" in text
    assert "NOT TO BE RELIED ON" not in text
    assert "†" not in text


def test_a_failed_run_is_marked_and_gives_its_reasons(failing):
    text = printed(failing)
    assert "NOT TO BE RELIED ON" in text
    assert "19.2 ± 0.9†" in line_of(text, "impact speed of B")
    assert "R-hat of e_m is 1.050" in text
    line = line_of(text, "impact moment coefficient")
    assert line.count("withheld") == 5
    assert "0.70" not in line


def test_every_interval_fits_on_a_narrow_terminal(outcome):
    text = printed(outcome, width=80)
    for wanted in ("50 %: 18.6 to 19.8", "90 %: 17.7 to 20.6", "95 %: 17.4 to 21.0"):
        assert wanted in text
    assert max(map(len, text.splitlines())) <= 80
    assert "…" not in text  # no label is cut


def test_unknown_speeds_of_both_and_before_a_skid_are_printed(outcome, sparse):
    text = printed(sparse)
    line_of(text, "impact speed of A, m/s")
    line_of(text, "impact speed of B, m/s")
    line_of(text, "travelling speed of B before its skid, m/s")
    narrow = printed(sparse, width=80)
    assert max(map(len, narrow.splitlines())) <= 80
    assert "…" not in narrow
    assert "speed of A" not in printed(outcome)


def test_an_interrupted_run_says_so(outcome):
    assert "interrupted" in printed(replace(outcome, complete=False))


def test_texts_of_the_scene_are_neither_markup_nor_escape_sequences(outcome):
    scene = replace(outcome.scene, title="[bold]Title[/bold] [/] \x1b[31mred\u202e")
    checks = replace(outcome.checks, flags=("[link=http://x]flag[/link]",))
    text = printed(replace(outcome, scene=scene, checks=checks))
    assert "[bold]Title[/bold] [/]" in text
    assert "[link=http://x]flag[/link]" in text
    assert "\x1b" not in text
    assert "\u202e" not in text


def test_what_was_asked_is_answered_below_the_answer(asked):
    text = " ".join(printed(asked).split())
    assert "Probability that the impact speed of B is above 20.12 m/s" in text
    assert "with a Monte Carlo error of" in text
    assert "Would the impact have been avoided" in text
    assert "Effect of each measurement" not in text  # that nobody asked for it, a report has it
    narrow = printed(asked, width=80)
    assert max(map(len, narrow.splitlines())) <= 80
    assert "…" not in narrow
