"""The library of vehicles as a table, with its sources."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from retrodict.findings.rounding import NOTHING, format_with_sd
from retrodict.report.layout import print_table
from retrodict.scene.vehicle_library import vehicles

HEADER = (
    "class",
    "mass, kg",
    "wheelbase, m",
    "front axle to centre of gravity, wheelbases",
    "radius of gyration in yaw, wheelbases",
    "track, m",
    "length, m",
    "width, m",
)
_QUANTITIES = ("mass", "wheelbase", "cg_share", "yaw_radius", "track", "length", "width")


def library_rows() -> tuple[list[tuple[str, ...]], list[str]]:
    """The library of vehicles, one row per class, and the sources that the bracketed numbers cite.

    Returns:
        Rows under `HEADER`, with ± one standard deviation; sources, the first of which is [1].
    """
    rows, numbers = [], dict[str, int]()
    for name, entry in vehicles().items():
        cells = [name]
        for quantity in _QUANTITIES:
            measured = getattr(entry, quantity)
            if measured is None:
                cells.append(NOTHING)
                continue
            number = numbers.setdefault(measured.source, len(numbers) + 1)
            cells.append(f"{format_with_sd(measured.value, measured.sd)} [{number}]")
        rows.append(tuple(cells))
    return rows, list(numbers)


def class_lines() -> list[str]:
    """Lines that say which vehicles each entry of the library stands for, one per entry."""
    return [
        f"{name}: {entry.what}" + (f"; {entry.models} models" if entry.models else "")
        for name, entry in vehicles().items()
    ]


def print_vehicles(console: Console) -> None:
    """Print the library of vehicles with its sources.

    Args:
        console: rich console to print on.
    """
    rows, sources = library_rows()
    table = Table(*HEADER)
    for row in rows:
        table.add_row(*map(Text, row))
    print_table(console, table)
    numbered = [f"[{number}] {source}" for number, source in enumerate(sources, start=1)]
    for line in (*class_lines(), *numbered):
        console.print(Text(line), soft_wrap=True)
