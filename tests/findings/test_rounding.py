import math

import pytest

from retrodict.findings.rounding import format_range, format_value, format_with_sd


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (19.1640, 0.8864, "19.16 ± 0.89"),
        (42.868, 1.983, "42.9 ± 2.0"),
        (1857.3, 40.2, "1857 ± 40"),
        (1857.3, 123.0, "1860 ± 120"),
        (389_532.0, 23_511.0, "390000 ± 24000"),
        (0.10132, 0.0996, "0.10 ± 0.10"),  # an uncertainty that rounds up to a new digit
        (12.0, 9.96, "12 ± 10"),
        (-3.7049, 0.321, "−3.70 ± 0.32"),
        (-0.0004, 0.05, "0.000 ± 0.050"),  # no minus on a zero
        (1.52, 0.0, "1.52"),  # exact
        (2.0, math.nan, "2"),
        (math.nan, 1.0, "–"),
        (None, None, "–"),
    ],
)
def test_a_value_is_rounded_to_two_digits_of_its_uncertainty(value, sd, text):
    assert format_with_sd(value, sd) == text


def test_fewer_decimals_are_taken_off_both_numbers():
    assert format_with_sd(19.164, 0.8864, 1) == "19.2 ± 0.9"


def test_an_interval_uses_the_decimals_of_the_uncertainty():
    assert format_range((-1.2345, 20.6), 1) == "−1.2 to 20.6"
    assert format_range((None, 2.0), 1) == "–"


def test_a_number_without_decimals_keeps_six_digits():
    assert format_value(4.986876640, None) == "4.98688"
