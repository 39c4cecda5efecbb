"""Tables as CSV: cells come back as they were, and no text of a scene is a formula."""

import csv
import io

import pandas as pd
import pytest

from retrodict.interchange.tables import csv_text, table_csv


def cells(*row):
    (found,) = csv.reader(io.StringIO(table_csv([], [row]).decode("utf-8-sig")))
    return found


@pytest.mark.parametrize(
    "text",
    [
        "=1+1",
        "+cmd|' /C calc'!A0",
        "-2+3",
        "@SUM(A1)",
        "\t=1",
        "\r=1",
        "\n=1",
        '  =HYPERLINK("http://x")',
        "＝1",
        "−=",
    ],
)
def test_what_begins_as_a_formula_is_marked_as_text(text):
    (cell,) = cells(text)
    begins = text.lstrip(" ")[0] != "−"  # a true minus sign begins none
    assert cell == (f"'{text}" if begins else text)


def test_numbers_stay_numbers():
    assert cells("−3.2", "+0.6", "-1e-3", -2.5, 0.1 + 0.2, 7, None, "−3.2 ± 0.4") == [
        "-3.2", "+0.6", "-1e-3", "-2.5", "0.30000000000000004", "7", "", "−3.2 ± 0.4",
    ]  # fmt: skip


def test_separators_quotes_and_breaks_come_back():
    row = ['a, "b"; c', "two\nlines", "μ ± ½"]
    assert cells(*row) == row


def test_spreadsheets_see_the_encoding_and_other_readers_skip_its_mark():
    content = table_csv(["name", "μ"], [["x", 1.5]])
    assert content.startswith(b"\xef\xbb\xbf")
    frame = pd.read_csv(io.BytesIO(content))
    assert list(frame.columns) == ["name", "μ"]
    assert frame["μ"][0] == 1.5


@pytest.mark.parametrize("text", ["=1+1", "+1+1", "-a", "@SUM(A1)", " =1", "＝1"])
def test_no_cell_of_rows_by_name_is_a_formula(text: str) -> None:
    assert csv_text(["a", "b"], [{"a": text, "b": "-1.5"}]) == f"a,b\n'{text},-1.5\n"
