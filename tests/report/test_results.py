"""Printed results: rounded, marked or withheld."""

from retrodict.findings.sentences import MARK, WITHHELD
from retrodict.report.results import result_rows
from tests.report.conftest import found_of


def test_rows_of_a_failed_run_are_marked_or_withheld(failing):
    for row in result_rows(found_of(failing), "si"):
        printed = [row.median, row.mean, *row.intervals.values()]
        if row.name == "e_m":
            assert set(printed) == {WITHHELD}
        else:
            assert all(text.endswith(MARK) for text in printed)


def test_what_follows_from_a_failed_quantity_is_withheld(failing):
    found = found_of(failing)
    assert all(row.withheld for row in result_rows(found, "si", found.derived.values()))


def test_rows_of_a_good_run_are_bare_and_in_the_units_asked_for(outcome):
    found = found_of(outcome)
    speed = result_rows(found, "us")[0]
    assert (speed.unit, speed.mean) == ("mph", "42.9 ± 2.0")
    assert result_rows(found, "si")[0].mean == "19.2 ± 0.9"
    assert result_rows(found, "si", [found.derived["energy_lost"]])[0].unit == "kJ"


def test_no_digit_is_printed_that_the_monte_carlo_error_reaches(outcome):
    """2000 independent draws of sd 0.89: the limits are known to 0.06, the median to 0.025."""
    rows = {row.name: row for row in result_rows(found_of(outcome), "si")}
    speed = rows["speed_b"]
    assert (speed.mean, speed.last_digit) == ("19.2 ± 0.9", "0.1")
    assert 0.05 < float(speed.monte_carlo_error) < 0.1
    assert speed.intervals[95] == "17.4 to 21.0"
