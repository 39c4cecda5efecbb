"""Tables on a terminal: as such where they fit, else a few lines for each row."""

from __future__ import annotations

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

_ENDLESS = 10_000  # columns: as wide as anything gets


def print_table(console: Console, table: Table) -> None:
    """Print a table; where the terminal is too narrow for it, its rows one below the other.

    Args:
        console: where to.
        table: whose cells are texts.
    """
    endless = console.options.update(width=_ENDLESS)
    if Measurement.get(console, endless, table).minimum <= console.width:
        console.print(table)
        return
    if table.title:
        console.print(table.title)
    headings = [str(column.header).replace("\n", " ") for column in table.columns]
    for row, (name, *cells) in zip(
        table.rows, zip(*(column.cells for column in table.columns), strict=True), strict=True
    ):
        style = str(row.style or "")
        console.print(Text(str(name).replace("\n", " "), style=f"bold {style}"))
        for heading, cell in zip(headings[1:], cells, strict=True):
            lines = str(cell).split("\n")
            whole = [heading, *(f"  {line}" for line in lines)]
            if len(lines) == 1 or "%" not in lines[0]:
                whole = [f"{heading}: {' '.join(lines)}"]
            for line in whole:
                console.print(Text(f"  {line}", style=style))
