"""The values that an import took, and those that it left, on a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from retrodict.progress import printable
from retrodict.scene.errors import shown

if TYPE_CHECKING:
    from rich.console import Console

    from retrodict.interchange.importing import Import

_LEFT = 20  # lines on what was left


def print_import(found: Import, console: Console) -> None:
    """Print every value that an import took, with the value that it replaces, and what was left.

    Args:
        found: import to print.
        console: rich console to print on.
    """
    from rich.table import Table
    from rich.text import Text

    replaces = any(taken.before is not None for taken in found.taken)
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("taken", no_wrap=True)
    for column in ("value", "from", *(["before"] if replaces else [])):
        table.add_column(column, overflow="fold")
    for taken in found.taken:
        where = "; ".join(each for each in (taken.where, taken.remark) if each)
        row = [taken.key, _short(taken.value), where]
        if replaces:
            row.append("–" if taken.before is None else _short(taken.before))
        table.add_row(*(Text(printable(cell)) for cell in row))
    console.print(table)
    lines = list(found.left[:_LEFT])
    if len(found.left) > _LEFT:
        lines.append(f"and {len(found.left) - _LEFT} more")
    for line in lines:
        console.print(printable(f"left: {line}"), markup=False, highlight=False, soft_wrap=True)


def _short(value: Any) -> str:
    """A value of a scene file in a few words."""
    match value:
        case None:
            return "removed"
        case {"times": [first, *_, last] as times, "speeds": [before, *_, after], **_others}:
            return f"{len(times)} times and speeds: {before} at {first} to {after} at {last}"
        case {"value": number, "sd": sd, "unit": unit, **_others}:
            return f"{number} ± {sd} {unit}"
        case {"value": number, "unit": unit, **_others}:
            return f"{number} {unit}"
        case [{"point": _, **_others}, *_points]:
            return f"{len(value)} points"
        case list():
            return ", ".join(map(_short, value[:4]))
        case {"corners": [*corners], **_others}:
            return f"{len(corners)} corners"
        case {"point": point, "direction": direction, **_others}:
            return f"through {_short(point)} at {_short(direction)}"
        case str():
            return shown(value)[1:-1]
    return shown(value)
