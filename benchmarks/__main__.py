"""Runs every benchmark and writes its chart and table to docs/charts, and docs/run-out.md from them.

python3 -m uv run python -m benchmarks [scenes folder]

With a number of scenes and a folder: a trial of so many, which writes there only.
"""

from __future__ import annotations

import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"


def main() -> None:
    """Run them all, one after the other."""
    from benchmarks import integrators, kinks, page  # late: the reference's processes import this

    if sys.argv[1:]:
        charts = Path(sys.argv[2])
        charts.mkdir(parents=True, exist_ok=True)
        integrators.main(charts, int(sys.argv[1]))
        kinks.main(charts, 21)
    else:
        charts = DOCS / "charts"
        charts.mkdir(parents=True, exist_ok=True)
        integrators.main(charts)
        kinks.main(charts)
        page.refresh(DOCS / "run-out.md", charts)


if __name__ == "__main__":
    main()
