"""Reconstructs synthetic crashes of cars whose wheels roll, and rewrites docs/rolling.md.

python3 -m uv run --group bench python -m benchmarks.rolling [scenes] [folder]

Scenes and results go to out/rolling, rows to docs/charts/rolling.csv as they come; a run goes on where
the last one stopped. With a folder: a trial, which writes there only. One process runs at a time.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable
from pathlib import Path

from benchmarks import how_wrong, page
from benchmarks.__main__ import DOCS
from benchmarks.rolling import scenes, scores
from benchmarks.rolling.runs import COLUMNS, Row, run

NUMBER = 64


def main(indices: Iterable[int] = range(NUMBER), folder: Path | None = None) -> None:
    """Go on with the table until these scenes stand in it, then score them."""
    charts = folder or DOCS / "charts"
    scenes_in = folder or DOCS.parent / "out" / "rolling"
    charts.mkdir(parents=True, exist_ok=True)
    file = charts / "rolling.csv"
    new = not file.exists() or not file.stat().st_size
    done = set() if new else {int(row["scene"]) for row in _read(file)}
    with file.open("a", newline="", encoding="utf-8") as kept:
        writer = csv.DictWriter(kept, COLUMNS, lineterminator="\n")
        if new:
            writer.writeheader()
        for index in indices:
            if index in done:
                continue
            made = scenes.crash(index)
            row = run(index, made, scenes.write(index, made, scenes_in))
            writer.writerow(row)
            kept.flush()
            shown = ("scene", "wheels_a", "wheels_b", "status", "seconds", "model", "reason")
            print(*(row[column] for column in shown), sep="  ", flush=True)
    rows = _read(file)
    parts = scores.parts(rows)
    scores.draw(rows, charts / "rolling.png")
    if folder is None:
        page.refresh(DOCS / "rolling.md", parts)
        how_wrong.refresh()
    print("\n".join(line for lines in parts.values() for line in [*lines, ""]))


def _read(file: Path) -> list[Row]:
    with file.open(newline="", encoding="utf-8") as kept:
        return sorted(csv.DictReader(kept), key=lambda row: int(row["scene"]))


if __name__ == "__main__":
    main(range(int(sys.argv[1]) if sys.argv[1:] else NUMBER), *map(Path, sys.argv[2:3]))
