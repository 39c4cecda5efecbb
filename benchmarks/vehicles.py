"""Writes the tables of docs/vehicles.md from the library of vehicles.

python3 -m uv run --group bench python -m benchmarks.vehicles
"""

from __future__ import annotations

from benchmarks import page
from benchmarks.__main__ import DOCS
from retrodict.report.vehicles import HEADER, class_lines, library_rows


def parts() -> page.Parts:
    """What stands between the markers of docs/vehicles.md."""
    rows, _ = library_rows()
    return {
        "library": page.table(HEADER, map(list, rows)),
        "classes": [f"- {line}" for line in class_lines()],
    }


if __name__ == "__main__":
    page.refresh(DOCS / "vehicles.md", parts())
