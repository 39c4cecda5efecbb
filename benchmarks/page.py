"""Writes the numbers of docs/run-out.md, docs/inference.md and docs/atlas.md from docs/charts.

`python -m benchmarks.page`. Between `<!-- name -->` and `<!-- end -->` stands what is written here: the
remarks of this name (`# name: text` in a table), or all tables.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator
from pathlib import Path


def table(headings: Iterable[str], rows: Iterable[list[str]]) -> list[str]:
    """The lines of a Markdown table."""
    headings = [*headings]
    lines = [headings, ["---"] * len(headings), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


METHODS = {
    "method": "method",
    "budget": "chains × draws",
    "seconds": "seconds",
    "ess": "ESS",
    "ess_per_second": "ESS per second",
    "ess_per_1000_evaluations": "ESS per 1000 evaluations",
    "seconds_to_ess_400": "seconds to ESS 400",
    "compile_seconds": "compilation, s",
    "error_mean_sd": "error of mean",
    "error_sd_sd": "of sd",
    "error_limits_sd": "of 95 % limits",
    "nuts_is_times_faster": "nuts is faster, times",
}


def _listed(rows: list[dict[str, str]]) -> Iterator[str]:
    """Each scene's methods, one budget of each."""

    def cell(row: dict[str, str], column: str) -> str:
        value = row[column]
        if column not in ("method", "budget") and value:
            number = float(value)
            value = f"{number:,.0f}" if number >= 100 else f"{number:.2g}"
        elif column == "budget" and row["extrapolated"]:
            value = f"{value} †"
        return f"**{value}**" if row["method"] == "nuts" and value else value

    for scene in dict.fromkeys(row["scene"] for row in rows):
        yield f"### Scene: {scene}\n"
        mine = (row for row in rows if row["scene"] == scene and row["listed"])
        yield from table(METHODS.values(), ([cell(row, c) for c in METHODS] for row in mine))
        yield ""


Parts = dict[str, list[str]]


def _read(*files: Path) -> tuple[list[dict[str, str]], Parts]:
    """The first table's rows, and the remarks of all."""
    parts: Parts = {}
    texts = [file.read_text("utf-8").splitlines() for file in files]
    for line in (line for text in texts for line in text if line.startswith("# ")):
        kind, remark = line[2:].split(": ", 1)
        parts.setdefault(kind, []).append(f"- {remark}")
    return list(csv.DictReader(line for line in texts[0] if not line.startswith("# "))), parts


def of_run_out(charts: Path) -> Parts:
    """What stands between the markers of docs/run-out.md."""
    return _read(charts / "integrators.csv", charts / "kinks.csv")[1]


def of_inference(charts: Path) -> Parts:
    """What stands between the markers of docs/inference.md."""
    rows, parts = _read(charts / "inference.csv", charts / "agreement.csv")
    seeds, _ = _read(charts / "seeds.csv")
    parts["seeds_machine"] = [f"- {seeds[0]['machine']}"]
    parts["seeds"] = table(SEEDS.values(), ([row[c] for c in SEEDS] for row in seeds))
    return parts | {"tables": ["\n".join(_listed(rows)).rstrip()]}


SEEDS = {
    "scene": "scene",
    "method": "method",
    "draws": "chains × draws",
    "seeds": "seeds",
    "divergences": "divergences, all seeds",
    "leapfrogs": "leapfrogs a draw",
    "bulk_median": "bulk ESS, median",
    "bulk_least": "least",
    "tail_median": "tail ESS, median",
    "tail_least": "least",
    "rhat_largest": "largest R̂",
    "seconds_median": "seconds, median",
    "seconds_least": "least",
}
APPROXIMATIONS = [
    "method",
    "right and passed",
    "right and flagged",
    "wrong and flagged",
    "wrong and passed",
]
EDGES = {
    "edge": "edge",
    "tried": "what was tried",
    "seen": "what a user sees",
    "saved": "what saves them",
    "verdict": "verdict",
    "test": "pinned by",
}


def _edge(row: dict[str, str]) -> list[str]:
    *cells, test = (row[column].replace("|", "\\|").replace("\n", " ") for column in EDGES)
    return [*cells, f"`{test}`"]


def of_atlas(charts: Path) -> Parts:
    """What stands between the markers of docs/atlas.md."""
    of_edges = [charts / f"atlas-{part}.csv" for part in ("mechanics", "inference")]
    at_random = [charts / f"atlas-{part}.csv" for part in ("random", "reconstructions", "unseen")]
    _, parts = _read(*at_random, *of_edges, charts / "atlas-map.csv")
    approximations = [line.removeprefix("- ") for line in parts["approximations"]]
    parts["approximations"] = table(APPROXIMATIONS, []) + approximations
    rows = [row for file in of_edges for row in _read(file)[0]]
    for part in dict.fromkeys(row["part"] for row in rows):
        mine = (row for row in rows if row["part"] == part)
        parts[part.replace("-", "_")] = table(EDGES.values(), map(_edge, mine))
    return parts


def refresh(page: Path, parts: Parts, *, whole: bool = True) -> None:
    """Rewrite what stands between the page's markers; parts not given are emptied if it is `whole`."""

    def fill(found: re.Match[str]) -> str:
        if found[1] not in parts and not whole:
            return found[0]
        body = "\n".join(parts.get(found[1], ["- none"]))
        return f"<!-- {found[1]} -->\n\n{body}\n\n<!-- end -->"

    text = re.sub(r"<!-- (\w+) -->\n.*?<!-- end -->", fill, page.read_text("utf-8"), flags=re.S)
    page.write_text(text, "utf-8")


if __name__ == "__main__":
    docs = Path(__file__).resolve().parents[1] / "docs"
    refresh(docs / "run-out.md", of_run_out(docs / "charts"))
    refresh(docs / "inference.md", of_inference(docs / "charts"))
    refresh(docs / "atlas.md", of_atlas(docs / "charts"))
