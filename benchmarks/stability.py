"""The atlas of failure: where every option breaks, and what a user then sees.

python3 -m uv run --group bench python -m benchmarks.stability [share folder]

Writes docs/charts/atlas-random.csv (scenes at random), atlas-mechanics.csv and atlas-inference.csv
(edges), atlas-map.csv and atlas.png (maps), and the numbers of docs/atlas.md. With a share of the
counts (0.05, say) and a folder: a trial, which writes there only.
"""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.atlas import Row

DOCS = Path(__file__).resolve().parents[1] / "docs"
IMPACTS, LOCKED, ROLLING, FILES = 10_000, 10_000, 200, 10_000
AGAINST_SCIPY = 20  # run-outs of each kind

Remark = tuple[str, str]


def impacts(number: int) -> Iterator[Remark]:
    """Impacts at random."""
    from benchmarks.atlas import impacts as drawn

    found = drawn.examine(drawn.draw(number))
    worst = max(found.faults, key=lambda law: found.faults[law].max())
    size = found.faults[worst].max()
    broken = np.any([fault > 1 for fault in found.faults.values()], axis=0).sum()
    unflagged = sum((found.odd[k] & ~found.flags[k]).sum() for k in found.flags)
    raised = ", ".join(f"{flag.mean():.0%} {name}" for name, flag in found.flags.items())
    yield (
        "impacts",
        f"{number} impacts: {broken} break a law or differ from the second implementation by more than "
        f"{drawn.TOLERANCE:g} of the terms (worst: {worst}, {size:.2g} of that); not numbers: "
        f"{np.isinf(found.faults['finite']).sum()}",
    )
    yield (
        "impacts",
        f"flagged: {raised}, by design of the draws; odd by NumPy's reckoning and not flagged: "
        f"{unflagged}",
    )


def run_outs(locked: int, rolling: int, compared: int) -> Iterator[Remark]:
    """Run-outs at random."""
    from benchmarks.atlas import run_outs as drawn

    for name, number in (("locked", locked), ("rolling", rolling)):
        scenes = drawn.draw(number, rolling=name == "rolling")
        found = drawn.examine(scenes)
        broken = np.any(list(found.faults.values()), axis=0).sum()
        few = drawn.Found(found.rest[:compared], found.refused[:compared], {})
        apart = drawn.apart(scenes[:compared], few)
        far = (apart > drawn.WITHIN).sum()
        yield (
            "runouts",
            f"{number} run-outs, wheels {name}: {broken} break a law; {found.refused.sum()} could not "
            "be followed in 8192 steps, and have no rest pose (not numbers); of the first "
            f"{len(apart)}, {far} end over {drawn.WITHIN * 1e3:g} mm or mrad from where SciPy's do "
            f"(worst {apart.max() * 1e3:.1g})",
        )


def files(number: int) -> Iterator[Remark]:
    """Scene files at random."""
    from benchmarks.atlas import files as drawn

    counts = drawn.count(number)
    told = ", ".join(f"{n} {verdict}" for verdict, n in sorted(counts.items()))
    yield "files", f"{counts.total()} scene files given to `retrodict check`: {told}, no traceback"


def at_random(charts: Path, share: float) -> None:
    """Write `atlas-random.csv`: what scenes at random came to."""
    counts = [max(50, int(n * share)) for n in (IMPACTS, LOCKED, ROLLING, FILES)]
    compared = max(4, int(AGAINST_SCIPY * share))
    begin = time.perf_counter()
    remarks = [
        *impacts(counts[0]),
        *run_outs(counts[1], counts[2], compared),
        *files(counts[3]),
    ]
    _write([], Row, charts / "atlas-random.csv", remarks, begin)


def maps(charts: Path, share: float) -> None:
    """Write `atlas-map.csv` and `atlas.png`: where methods fail."""
    from benchmarks.atlas import maps as charted

    begin, every = time.perf_counter(), 1 if share == 1 else 2
    found = [cell for chosen in charted.MAPS for cell in charted.cells(chosen, every)]
    charted.picture(found, charts / "atlas.png")
    remarks = []
    for method in charted.SHOWN:
        mine = [cell for cell in found if cell.method == method]
        states = (f"{sum(c.state == state for c in mine)} {state}" for state in charted.STATES)
        worst = max((c.error for c in mine if c.state == "wrong"), default=0.0)
        more = f"; worst unflagged {worst:.2g} sd off" if worst else ""
        remarks.append(("maps", f"{method}: of {len(mine)} scenes {', '.join(states)}{more}"))
    _write(found, charted.Cell, charts / "atlas-map.csv", remarks, begin)


def mechanics(charts: Path, _: float) -> None:
    """Write `atlas-mechanics.csv`: edges of impact and run-out."""
    from benchmarks.atlas import edges

    begin = time.perf_counter()
    rows = [*_told(edges.impacts()), *_told(edges.run_outs())]
    _write(rows, Row, charts / "atlas-mechanics.csv", [], begin)


def inference(charts: Path, _: float) -> None:
    """Write `atlas-inference.csv`: edges of inference."""
    from benchmarks.atlas import posteriors

    begin = time.perf_counter()
    rows = list(_told(posteriors.rows()))
    _write(rows, Row, charts / "atlas-inference.csv", [], begin)


def _told(rows: Iterator[Row]) -> Iterator[Row]:
    """The rows, printed as they come."""
    for row in rows:
        print(row.part, row.edge, row.seen, sep=" | ", flush=True)
        yield row


def _write(
    rows: Sequence[NamedTuple], kind: type, file: Path, remarks: Sequence[Remark], begin: float
) -> None:
    """A table, its remarks, and how long it took."""
    minutes = f"{file.stem}: {(time.perf_counter() - begin) / 60:.1f} minutes"
    with file.open("w", newline="", encoding="utf-8") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(kind._fields)  # type: ignore[attr-defined]
        table.writerows([f"{v:.4g}" if isinstance(v, float) else v for v in row] for row in rows)
        for of, text in (*remarks, ("seconds", minutes)):
            print(of, text, sep=": ", flush=True)
            out.write(f"# {of}: {text}\n")


def main(charts: Path, share: float = 1.0) -> None:
    """Measure, then write the tables and the picture into the folder.

    Args:
        charts: the folder.
        share: of the counts, for a trial.
    """
    for part in (at_random, mechanics, inference, maps):
        part(charts, share)


if __name__ == "__main__":
    if sys.argv[1:]:
        folder = Path(sys.argv[2])
        folder.mkdir(parents=True, exist_ok=True)
        main(folder, float(sys.argv[1]))
    else:
        from benchmarks import page

        main(DOCS / "charts")
        page.refresh(DOCS / "atlas.md", page.of_atlas(DOCS / "charts"))
