"""Runs every benchmark and writes its chart and table to docs/charts, and two pages of docs/ from them.

python3 -m uv run python -m benchmarks [scenes folder]

With a number of scenes and a folder: a trial of so many, which writes there only.
"""

from __future__ import annotations

import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"


def main() -> None:
    """Run them all, one after the other."""
    # late: the reference's processes import this
    from benchmarks import kinks, page
    from benchmarks.inference import study as inference
    from benchmarks.integrators import study as integrators

    if sys.argv[1:]:
        charts = Path(sys.argv[2])
        charts.mkdir(parents=True, exist_ok=True)
        integrators.main(charts, int(sys.argv[1]))
        kinks.main(charts, 21)
        inference.main(charts, int(sys.argv[1]) / integrators.NUMBER)
    else:
        charts = DOCS / "charts"
        charts.mkdir(parents=True, exist_ok=True)
        integrators.main(charts)
        kinks.main(charts)
        inference.main(charts)
        page.refresh(DOCS / "run-out.md", page.of_run_out(charts))
        page.refresh(DOCS / "inference.md", page.of_inference(charts))


if __name__ == "__main__":
    main()
