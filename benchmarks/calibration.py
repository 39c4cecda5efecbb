"""Are posteriors as sure as they may be? Calibrates rungs and methods, and writes docs/calibration.md.

python3 -m uv run python -m benchmarks.calibration [simulations] [rung or `rolling` ...]

A run goes on where the last one stopped: each rung's ranks stand in docs/charts/calibration/. Without
arguments the page is written from the ranks that are there, and nothing is run. `rolling` is the
default rung, of crashes whose wheels roll (benchmarks/rolling/design.toml); `slow` is the default
rung of two cars that close in slowly (benchmarks/slow.toml); `wall` is a car against a wall, whose
recorder was read (benchmarks/wall.toml); `together` is two cars that go on as one body
(benchmarks/together.toml).
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from benchmarks import how_wrong, page
from benchmarks.__main__ import DOCS
from retrodict.api import calibrate
from retrodict.options import DEFAULT_RUNG
from retrodict.report.calibration import LEAST
from retrodict.scene import load_scene
from retrodict.studies.calibration import SLOWLY

METHODS = ["importance", "nuts"]
BY = {
    "rolling": ["importance"],
    "slow": ["importance", "smc"],
    "wall": ["importance", "smc"],
    "together": ["importance"],
}
MODELS = {
    "wall": "planar+spin",
    "together": "joined-body+wheels",
}  # of a design; the default rung of the others
HERE = Path(__file__).parent
DESIGNS = {
    "rolling": HERE / "rolling" / "design.toml",
    "slow": HERE / "slow.toml",
    "wall": HERE / "wall.toml",
    "together": HERE / "together.toml",
}
NAMES = {
    "rolling": ", wheels that roll",
    "slow": ", cars that close in slowly",
    "wall": ", a car against a wall",
    "together": ", cars that go on together",
}
FOLDERS = DOCS / "charts" / "calibration"


def table(folders: list[Path]) -> page.Parts:
    """What stands between the markers of docs/calibration.md."""
    rows, verdicts = [], []
    for folder in folders:
        calibration = json.loads((folder / "calibration.json").read_text("utf-8"))
        name = calibration["model"] + NAMES.get(folder.name.split("-")[0], "")
        every = f"closing from {calibration.get('closing_from', 3.0):g} m/s"
        groups = {
            every: calibration,
            f"closing below {SLOWLY:g} m/s": calibration.get("closing_slowly"),
        }
        for which, group in groups.items():
            if group and group["done"]:
                rows.append([name, calibration["method"], which, *_counts(group)])
        verdicts += [
            f"### {name}, {calibration['method']}\n",
            f"{calibration['verdict']}\n",
            f"![ranks](charts/calibration/{folder.name}/calibration.png)\n",
            *page.table(
                ["quantity", *(f"{level} %" for level in (50, 80, 90, 95))], _coverage(calibration)
            ),
            "",
        ]
    heading = [
        "rung", "method", "crashes", "ranked", "withheld", "outside its own band", "outside jointly",
    ]  # fmt: skip
    return {"summary": page.table(heading, rows), "verdicts": verdicts[:-1]}


def _counts(calibration: dict) -> list[str]:
    """Ranked, withheld, and quantities outside their bands."""
    bands = ["too few to judge"] * 2
    if calibration["done"] >= LEAST:
        bands = [
            ", ".join(k for k, v in calibration["quantities"].items() if not v[which]) or "none"
            for which in ("inside", "inside_jointly")
        ]
    return [
        f"{calibration['ranked']} of {calibration['done']}",
        f"{calibration['withheld']:.1%}",
        *bands,
    ]


def _coverage(calibration: dict) -> list[list[str]]:
    return [
        [name, *(f"{c['share']:.1%} ± {c['error']:.1%}" for c in each["coverage"].values())]
        for name, each in calibration["quantities"].items()
    ]


def main(simulations: int, rungs: list[str]) -> None:
    """Go on with each rung until so many simulations are done, then write the page."""
    asked = [(method, rung) for rung in rungs for method in BY.get(rung, METHODS)]
    for method, rung in asked:
        found = calibrate(
            load_scene(DESIGNS[rung]) if rung in DESIGNS else None,
            model=MODELS.get(rung, DEFAULT_RUNG) if rung in DESIGNS else rung,
            method=method,
            simulations=simulations,
            out=FOLDERS / f"{rung}-{method}",
            progress=lambda *at: print(*at, flush=True),
        )
        if not found.complete:
            break
    done = sorted(file.parent for file in FOLDERS.glob("*/calibration.json"))
    page.refresh(DOCS / "calibration.md", table(done))
    how_wrong.refresh()


RUNGS = ["momentum+slide", "planar+spin", "planar-moment+wheels"]

if __name__ == "__main__":
    asked = int(sys.argv[1]) if sys.argv[1:] else 0
    main(asked, (sys.argv[2:] or RUNGS) if asked else [])
