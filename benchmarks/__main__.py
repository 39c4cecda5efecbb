"""Runs every benchmark and writes its chart and table to docs/charts."""

from __future__ import annotations

from pathlib import Path

CHARTS = Path(__file__).resolve().parents[1] / "docs" / "charts"


def main() -> None:
    """Run them all, one after the other."""
    from benchmarks import integrators  # late: the reference's processes import this file too

    CHARTS.mkdir(parents=True, exist_ok=True)
    integrators.main(CHARTS)


if __name__ == "__main__":
    main()
