"""Does it tell the truth? Reconstructs the staged collisions in examples/ and writes docs/validation.md.

python3 -m uv run python -m benchmarks.validation

Numbers and chart go to docs/charts/validation/. The fullest model is taken for all, so that none is
chosen by its answer; by importance sampling, because without rest poses NUTS diverges.
"""

from __future__ import annotations

from benchmarks import page
from benchmarks.__main__ import DOCS
from retrodict.api import validate
from retrodict.report.validation import remark_lines, table_lines


def main() -> None:
    """Run every case, then write the page."""
    found = validate(
        DOCS.parent / "examples",
        out=DOCS / "charts" / "validation",
        model="planar-moment+wheels",
        method="importance",
        progress=lambda *at: print(*at, flush=True),
    )
    parts = {"table": table_lines(found), "remarks": remark_lines(found)}
    page.refresh(DOCS / "validation.md", parts)


if __name__ == "__main__":
    main()
