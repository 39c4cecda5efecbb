"""Tables as CSV, in which no cell is a formula."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

_MINUS = "\N{MINUS SIGN}"
# what a spreadsheet takes for the beginning of a formula (OWASP, CSV injection), wide forms included
_BEGINS_A_FORMULA = tuple("=+-@\t\r\n＝＋－＠")
Cell = str | float | int | bool | None


def table_csv(header: Sequence[str], rows: Iterable[Sequence[Cell]]) -> bytes:
    """A table as CSV.

    Args:
        header: names of the columns; empty for none.
        rows: cells. None is left empty, numbers keep all digits, and texts that begin as a formula would
            get an apostrophe in front, by which spreadsheets know a text.

    Returns:
        The file, in UTF-8 with the mark at its beginning that spreadsheets need to see that.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\r\n")
    for row in [header, *rows] if header else rows:
        writer.writerow([_plain(cell) for cell in row])
    return text.getvalue().encode("utf-8-sig")


def csv_text(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """A table as CSV, with a header.

    Args:
        columns: names of the columns, in order.
        rows: values by column; a missing value is left empty. A text that a spreadsheet would take for
            a formula gets an apostrophe in front, which marks it as text.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(
        {k: no_formula(v) if isinstance(v, str) else v for k, v in row.items()} for row in rows
    )
    return text.getvalue()


def no_formula(text: str) -> str:
    """A text that no spreadsheet takes for a formula: with an apostrophe in front where one would.

    Args:
        text: text of a cell; a number stays a number.
    """
    number = text.replace(_MINUS, "-")
    try:
        float(number)
    except ValueError:
        return f"'{text}" if text.lstrip(" ").startswith(_BEGINS_A_FORMULA) else text
    return number


def _plain(cell: Cell) -> str:
    if cell is None:
        return ""
    return no_formula(cell) if isinstance(cell, str) else repr(cell)
