"""Tables on narrow terminals: nothing is cut off, whatever the width."""

import io

import pytest
from rich.console import Console
from rich.table import Table
from rich.text import Text

from retrodict.report.layout import print_table

CELLS = [
    "impact speed of B, m/s",
    "19.0",
    "50 %: 18.6 to 19.8\n90 %: 17.6 to 20.5",
    "43\n/ 23",
]


def printed(width: int) -> str:
    table = Table(title=Text("a title"))
    table.add_column("quantity")
    for heading in ("median", "shortest\nintervals", "ESS bulk\n/ tail"):
        table.add_column(heading, no_wrap=True)
    table.add_row(*map(Text, CELLS), style="red")
    console = Console(file=io.StringIO(), width=width, color_system=None)
    print_table(console, table)
    return console.file.getvalue()


@pytest.mark.parametrize("width", [20, 40, 60, 80, 120])
def test_no_number_is_cut_at_any_width(width: int) -> None:
    text = printed(width)
    assert "…" not in text
    for part in ("a title", "19.0", "18.6 to", "20.5", "43", "23"):
        assert part in " ".join(text.split())
    assert max(map(len, text.splitlines())) <= width


def test_a_table_that_fits_is_one_and_one_that_does_not_is_a_list() -> None:
    assert "┃ quantity" in printed(80)
    narrow = printed(40)
    assert "┃" not in narrow
    assert "  median: 19.0\n" in narrow
    assert "  shortest intervals\n    50 %: 18.6 to 19.8\n" in narrow
    assert "  ESS bulk / tail: 43 / 23\n" in narrow
