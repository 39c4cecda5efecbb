"""Tables on a terminal: as such where they fit, else a few lines for each row."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text


def print_table(console: Console, table: Table) -> None:
    """Print a table; where the terminal is too narrow for it, its rows one below the other.

    Args:
        console: rich console to print on.
        table: rich table whose cells are texts.
    """
    names = table.columns[0]
    # without this rich would shrink the column of names
    words = [word for cell in names.cells for word in str(cell).split()]
    names.min_width = max(map(len, words), default=None)
    cut = any("…" in part.text for line in console.render_lines(table) for part in line)
    if not cut:
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
