"""Are the answers true? Reconstructs staged collisions and writes docs/validation.md.

python3 -m uv run python -m benchmarks.validation [folders]

The collisions are those in examples/ and benchmarks/staged/cases/ by default. Numbers and charts go to
docs/charts/validation/. The fullest model is taken for all, so that none is chosen by its answer.
"""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks import how_wrong, page
from benchmarks.__main__ import DOCS
from retrodict.api import validate
from retrodict.report.validation import group_lines, remark_lines, table_lines

FOLDERS = (DOCS.parent / "examples", DOCS.parent / "benchmarks" / "staged" / "cases")


def main(*folders: Path) -> None:
    """Run every case of some folders, then write the page."""
    found = validate(
        folders or FOLDERS,
        out=DOCS / "charts" / "validation",
        model="planar-moment+wheels",
        progress=lambda *at: print(*at, flush=True),
    )
    parts = {
        "table": table_lines(found),
        "groups": group_lines(found),
        "remarks": remark_lines(found),
    }
    page.refresh(DOCS / "validation.md", parts)
    how_wrong.refresh()


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
