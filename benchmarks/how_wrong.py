"""Writes the known error rates of docs/how-wrong.md, from the tables in docs/charts.

python3 -m uv run --group bench python -m benchmarks.how_wrong

Benchmarks that change one of these tables do it too.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path

from benchmarks import page
from benchmarks.__main__ import DOCS
from benchmarks.rolling.scores import answered, covered, share, wrong

LEVELS = ("50", "90", "95")


def parts(charts: Path) -> page.Parts:
    """What stands between the markers of docs/how-wrong.md."""
    return {
        "staged": _staged(
            json.loads((charts / "validation" / "validation.json").read_text("utf-8"))
        ),
        "calibration": page.table(
            ["model", "method", "crashes", "withheld", *(f"{x} % interval" for x in LEVELS)],
            [_calibrated(file) for file in sorted(charts.glob("calibration/*/calibration.json"))],
        ),
        "rolling": _rolling(charts / "rolling.csv"),
        "random": [
            line
            for of in ("reconstructions", "unseen")
            for line in _remarks(charts / f"atlas-{of}.csv", of)
        ],
        "map": _remarks(charts / "atlas-map.csv", "maps"),
    }


def _staged(found: dict) -> list[str]:
    scores = found["scores"]
    passed = [score for score in scores if score["passed"]]
    errors = [score["error"] / score["truth"] for score in passed]
    widest = max(map(abs, errors))
    withheld = "; the others were withheld" if len(passed) < len(scores) else ""
    root_mean_square = (sum(e * e for e in errors) / len(errors)) ** 0.5
    return [
        f"- Speeds answered: {len(passed)} of {len(scores)}{withheld}.",
        *(
            f"- True speed inside the {x} % interval: {share(inside['inside'], inside['of'])}."
            for x, inside in found["coverage"].items()
        ),
        f"- Error of the median, relative to the true speed: {root_mean_square:.0%} in the root mean "
        f"square, {widest:.0%} at most.",
    ]


def _calibrated(file: Path) -> list[str]:
    found = json.loads(file.read_text("utf-8"))
    name = found["model"] + NAMES.get(file.parent.name.split("-")[0], "")
    # a barrier stands still
    asked = "speed_b" if "speed_b" in found["quantities"] else "speed_a"
    coverage = found["quantities"][asked]["coverage"]
    return [
        name,
        found["method"],
        str(found["done"]),
        f"{found['withheld']:.1%}",
        *(f"{coverage[x]['share']:.1%} ± {coverage[x]['error']:.1%}" for x in LEVELS),
    ]


NAMES = {
    "rolling": ", wheels that roll",
    "slow": ", slow closing",
    "wall": ", a car against a wall (its speed)",
}


def _rolling(file: Path) -> list[str]:
    rows = list(csv.DictReader(file.read_text("utf-8").splitlines()))
    kept = [row for row in rows if answered(row)]
    pairs = [(row, quantity) for row in kept for quantity in row["asked"].split()]
    speeds = [pair for pair in pairs if pair[1] == "speed_b"]
    return [
        f"- Answered: {share(len(kept), len(rows))}.",
        "- True speed of B inside the 90 % interval: "
        f"{share(sum(covered(*pair) for pair in speeds), len(speeds))}.",
        "- True value inside it, all quantities: "
        f"{share(sum(covered(*pair) for pair in pairs), len(pairs))}.",
        "- Wrong though all checks passed (outside the 99.9 % interval, or over 4 sd off): "
        f"{share(sum(wrong(*pair) for pair in pairs), len(pairs))} of all values.",
    ]


def _remarks(file: Path, kind: str) -> list[str]:
    begin = f"# {kind}: "
    lines = file.read_text("utf-8").splitlines()
    return [f"- {line.removeprefix(begin)}" for line in lines if line.startswith(begin)]


def refresh() -> None:
    """Rewrite the numbers of the page."""
    page.refresh(DOCS / "how-wrong.md", parts(DOCS / "charts"))


if __name__ == "__main__":
    refresh()
