"""Are posteriors as sure as they may be? Calibrates rungs and methods, and writes docs/calibration.md.

python3 -m uv run python -m benchmarks.calibration [simulations] [rung or `rolling` ...]

A run goes on where the last one stopped: each rung's ranks stand in docs/charts/calibration/. Without
arguments the page is written from the ranks that are there, and nothing is run. `rolling` is the
default rung by smc, of crashes whose wheels roll (benchmarks/rolling/design.toml).
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from benchmarks import page
from benchmarks.__main__ import DOCS
from retrodict.api import calibrate
from retrodict.inference.reconstruct import DEFAULT_RUNG
from retrodict.scene import load_scene

METHODS, SMC = ["importance", "nuts"], "smc"
ROLLING, ROLLS = "rolling", ", wheels that roll"
DESIGN = Path(__file__).parent / "rolling" / "design.toml"
FOLDERS = DOCS / "charts" / "calibration"


def table(folders: list[Path]) -> page.Parts:
    """What stands between the markers of docs/calibration.md."""
    rows, verdicts = [], []
    for folder in folders:
        told = json.loads((folder / "calibration.json").read_text("utf-8"))
        outside = [k for k, v in told["quantities"].items() if not v["inside_jointly"]]
        alone = [k for k, v in told["quantities"].items() if not v["inside"]]
        counts = f"{told['ranked']} of {told['done']}"
        name = told["model"] + (ROLLS if folder.name.startswith(ROLLING) else "")
        cells = [name, told["method"], counts, f"{told['withheld']:.1%}"]
        rows.append([*cells, ", ".join(alone) or "none", ", ".join(outside) or "none"])
        verdicts += [
            f"### {name}, {told['method']}\n",
            f"{told['verdict']}\n",
            f"![ranks](charts/calibration/{folder.name}/calibration.png)\n",
            *page.table(
                ["quantity", *(f"{level} %" for level in (50, 80, 90, 95))], _coverage(told)
            ),
            "",
        ]
    heading = ["rung", "method", "ranked", "withheld", "outside its own band", "outside jointly"]
    return {"summary": page.table(heading, rows), "verdicts": verdicts[:-1]}


def _coverage(told: dict) -> list[list[str]]:
    return [
        [name, *(f"{c['share']:.1%} ± {c['error']:.1%}" for c in each["coverage"].values())]
        for name, each in told["quantities"].items()
    ]


def main(simulations: int, rungs: list[str]) -> None:
    """Go on with each rung until so many simulations are done, then write the page."""
    asked = [(method, rung) for rung in rungs for method in ([SMC] if rung == ROLLING else METHODS)]
    for method, rung in asked:
        rolling = rung == ROLLING
        found = calibrate(
            load_scene(DESIGN) if rolling else None,
            model=DEFAULT_RUNG if rolling else rung,
            method=method,
            simulations=simulations,
            out=FOLDERS / f"{rung}-{method}",
            progress=lambda *at: print(*at, flush=True),
        )
        if not found.complete:
            break
    done = sorted(file.parent for file in FOLDERS.glob("*/calibration.json"))
    page.refresh(DOCS / "calibration.md", table(done))


RUNGS = ["momentum+slide", "planar+spin", "planar-moment+wheels"]

if __name__ == "__main__":
    asked = int(sys.argv[1]) if sys.argv[1:] else 0
    main(asked, (sys.argv[2:] or RUNGS) if asked else [])
