"""Writes the numbers of docs/run-out.md from the tables in docs/charts: `python -m benchmarks.page`.

Between `<!-- name -->` and `<!-- end -->` stands what is written here: the remarks of this name
(`# name: text` in a table), or all tables.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

COLUMNS = {
    "method": "clock, solver",
    "setting": "setting",
    "position_mm_median": "median, mm",
    "position_mm_p99": "p99, mm",
    "position_mm_worst": "worst, mm",
    "share_within_1mm_0.01deg": "within 1 mm and 0.01°",
    "evaluations": "slopes",
    "us_batched": "batched, µs",
    "us_batched_two_threads": "two threads, µs",
    "us_single": "singly, µs",
    "us_batched_jacobian": "with Jacobian, µs",
}
TITLES = {"locked": "Locked wheels", "ordinary": "Ordinary ones of these", "rolling": "Rolling"}


def _cell(row: dict[str, str], column: str) -> str:
    value = row[column]
    if column in ("method", "setting") or not value:
        return f"**{value}**" if row["mark"] and value else value
    if column.startswith("share"):
        return f"{float(value):.0%}"
    number = float(value)
    if not number < float("inf"):
        return "none"
    whole = number >= 100 or column.startswith(("us", "evaluations"))
    return f"{number:.0f}" if whole else f"{number:.2g}"


def _tables(rows: list[dict[str, str]]) -> Iterator[str]:
    for scenes in dict.fromkeys(row["scenes"] for row in rows):
        mine = [row for row in rows if row["scenes"] == scenes]
        yield f"### {TITLES[scenes]} ({max(int(row['number']) for row in mine)})\n"
        yield f"| {' | '.join(COLUMNS.values())} |"
        yield "| " + " | ".join("---" for _ in COLUMNS) + " |"
        for row in mine:
            yield f"| {' | '.join(_cell(row, column) for column in COLUMNS)} |"
        yield ""


def refresh(page: Path, charts: Path) -> None:
    """Rewrite what stands between the page's markers."""
    written = (charts / "integrators.csv").read_text("utf-8").splitlines()
    rows = list(csv.DictReader(line for line in written if not line.startswith("# ")))
    parts: dict[str, list[str]] = {"tables": ["\n".join(_tables(rows)).rstrip()]}
    for line in [*written, *(charts / "kinks.csv").read_text("utf-8").splitlines()]:
        if line.startswith("# "):
            kind, text = line[2:].split(": ", 1)
            parts.setdefault(kind, []).append(f"- {text}")

    def fill(found: re.Match[str]) -> str:
        body = "\n".join(parts.get(found[1], ["- none"]))
        return f"<!-- {found[1]} -->\n\n{body}\n\n<!-- end -->"

    text = re.sub(r"<!-- (\w+) -->\n.*?<!-- end -->", fill, page.read_text("utf-8"), flags=re.S)
    page.write_text(text, "utf-8")


if __name__ == "__main__":
    docs = Path(__file__).resolve().parents[1] / "docs"
    refresh(docs / "run-out.md", docs / "charts")
