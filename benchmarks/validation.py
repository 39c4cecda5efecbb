"""Are the answers true? Reconstructs staged collisions and writes docs/validation.md.

python3 -m uv run python -m benchmarks.validation [folders]

The collisions are those in examples/ and benchmarks/staged/cases/ by default. Numbers and charts go to
docs/charts/validation/. The fullest model is taken for all, so that none is chosen by its answer. What
was finished is kept in out/benchmarks/validation.json, and a run goes on from there: after a change of
the program delete that file.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks import how_wrong, page
from benchmarks.__main__ import DOCS
from retrodict.api import reconstruct
from retrodict.inference.outcome import Outcome
from retrodict.progress import Progress
from retrodict.report.validation import group_lines, remark_lines, table_lines, write_validation
from retrodict.scene.records import Measured, Scene
from retrodict.storage.files import write_whole
from retrodict.studies.fit import Summary
from retrodict.studies.narrowing import Narrowed
from retrodict.studies.validation import (
    SCENE,
    TRUTH,
    Score,
    Validation,
    cases,
    digest,
    validate,
)

ROOT = DOCS.parent
FOLDERS = (ROOT / "examples", ROOT / "benchmarks" / "staged" / "cases")
KEPT = ROOT / "out" / "benchmarks" / "validation.json"
MODEL, METHOD = "planar-moment+wheels", "importance"


def main(*folders: Path) -> None:
    """Run every case of some folders that was not run yet, then write the page."""
    kept = json.loads(KEPT.read_text("utf-8")) if KEPT.is_file() else {}
    scores: list[Score] = []
    for folder in cases(*(folders or FOLDERS)):
        key = " ".join(digest(folder / name) for name in (SCENE, TRUTH))
        if key not in kept:
            found = validate((folder,), _run, model=MODEL, method=METHOD, progress=_said)
            if not found.complete or found.faults:
                sys.exit("\n".join(found.faults) or "interrupted")
            kept[key] = [asdict(score) for score in found.scores]
            write_whole(KEPT, json.dumps(kept, indent=1, ensure_ascii=False).encode())
        scores += map(score_of, kept[key])
    found = Validation(tuple(scores), MODEL, METHOD)
    write_validation(found, DOCS / "charts" / "validation")
    parts = {
        "table": table_lines(found),
        "groups": group_lines(found),
        "remarks": remark_lines(found),
    }
    page.refresh(DOCS / "validation.md", parts)
    how_wrong.refresh()


def _run(scene: Scene, progress: Progress) -> Outcome:
    return reconstruct(scene, model=MODEL, method=METHOD, progress=progress).outcome


def _said(stage: str, done: int, total: int) -> None:
    print(stage, done, total, flush=True)


def score_of(row: dict[str, Any]) -> Score:
    """The score that a row of JSON was made of."""
    narrowed = tuple(
        Narrowed(n["name"], n["measured"] and Measured(**n["measured"]), n["sd"])
        for n in row["narrowed"]
    )
    reasons = {name: tuple(row[name]) for name in ("reasons", "exchanged_reasons")}
    answers = {name: row[name] and _summary(row[name]) for name in ("answer", "exchanged")}
    return Score(**(row | reasons | answers | {"narrowed": narrowed}))


def _summary(row: dict[str, Any]) -> Summary:
    intervals = {int(level): tuple(bounds) for level, bounds in row["intervals"].items()}
    return Summary(row["median"], row["sd"], intervals)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
