"""The atlas of failure: where every option breaks, and what a user then sees.

python3 -m uv run --group bench python -m benchmarks.stability [share folder]

Writes docs/charts/atlas.csv (edges), atlas-map.csv and atlas.png (maps), and the numbers of
docs/atlas.md. With a share of the counts (0.05, say) and a folder: a trial, which writes there only.
"""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.atlas import Row

DOCS = Path(__file__).resolve().parents[1] / "docs"
IMPACTS, LOCKED, ROLLING, FILES = 10_000, 10_000, 500, 10_000
AGAINST_SCIPY = 40  # run-outs of each kind

Remark = tuple[str, str]


def impacts(number: int) -> Iterator[Remark]:
    """Impacts at random."""
    from benchmarks.atlas import impacts as at_random

    found = at_random.examine(at_random.draw(number))
    worst = max(found.faults, key=lambda law: found.faults[law].max())
    size = found.faults[worst].max()
    broken = np.any([fault > 1 for fault in found.faults.values()], axis=0).sum()
    unflagged = sum((found.odd[k] & ~found.flags[k]).sum() for k in found.flags)
    raised = ", ".join(f"{flag.mean():.0%} {name}" for name, flag in found.flags.items())
    yield (
        "impacts",
        f"{number} impacts: {broken} break a law or differ from the second implementation by more than "
        f"{at_random.TOLERANCE:g} of the terms (worst: {worst}, {size:.2g} of that); not numbers: "
        f"{np.isinf(found.faults['finite']).sum()}",
    )
    yield (
        "impacts",
        f"flagged: {raised}, by design of the draws; odd by NumPy's reckoning and not flagged: "
        f"{unflagged}",
    )


def run_outs(locked: int, rolling: int, compared: int) -> Iterator[Remark]:
    """Run-outs at random."""
    from benchmarks.atlas import run_outs as at_random

    for name, number in (("locked", locked), ("rolling", rolling)):
        scenes = at_random.draw(number, rolling=name == "rolling")
        found = at_random.examine(scenes)
        broken = np.any(list(found.faults.values()), axis=0).sum()
        few = at_random.Found(found.rest[:compared], found.refused[:compared], {})
        apart = at_random.apart(scenes[:compared], few)
        far = (apart > at_random.WITHIN).sum()
        yield (
            "runouts",
            f"{number} run-outs, wheels {name}: {broken} break a law; {found.refused.sum()} could not "
            "be followed in 8192 steps, and have no rest pose (not numbers); of the first "
            f"{len(apart)}, {far} end over {at_random.WITHIN * 1e3:g} mm or mrad from where SciPy's do "
            f"(worst {apart.max() * 1e3:.1g})",
        )


def files(number: int) -> Iterator[Remark]:
    """Scene files at random."""
    from benchmarks.atlas import files as at_random

    counts = at_random.count(number)
    told = ", ".join(f"{n} {verdict}" for verdict, n in sorted(counts.items()))
    yield "files", f"{counts.total()} scene files given to `retrodict check`: {told}, no traceback"


def maps(every: int, folder: Path) -> Iterator[Remark]:
    """Maps of the methods, their table and their picture."""
    from benchmarks.atlas import maps as charted

    found = [cell for chosen in charted.MAPS for cell in charted.cells(chosen, every)]
    _table(found, charted.Cell, folder / "atlas-map.csv")
    charted.picture(found, folder / "atlas.png")
    for method in charted.SHOWN:
        mine = [cell for cell in found if cell.method == method]
        counts = ", ".join(
            f"{sum(c.state == state for c in mine)} {state}" for state in charted.STATES
        )
        worst = max((c.error for c in mine if c.state == "wrong"), default=0.0)
        more = f"; worst unflagged {worst:.2g} sd off" if worst else ""
        yield "maps", f"{method}: of {len(mine)} scenes {counts}{more}"


def edges() -> Iterator[Row]:
    """Every edge, the mechanics' first."""
    from benchmarks.atlas import edges as mechanics
    from benchmarks.atlas import posteriors

    for rows in (mechanics.impacts(), mechanics.run_outs(), posteriors.rows()):
        for row in rows:
            print(row.part, row.edge, row.seen, sep=" | ", flush=True)
            yield row


def _table(
    rows: Iterable[NamedTuple], kind: type, file: Path, remarks: Iterable[Remark] = ()
) -> None:
    with file.open("w", newline="", encoding="utf-8") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(kind._fields)  # type: ignore[attr-defined]
        table.writerows([f"{v:.4g}" if isinstance(v, float) else v for v in row] for row in rows)
        out.writelines(f"# {kind}: {text}\n" for kind, text in remarks)


def main(charts: Path, share: float = 1.0) -> None:
    """Measure, then write the tables and the picture into the folder.

    Args:
        charts: the folder.
        share: of the counts, for a trial.
    """
    begin = time.perf_counter()
    number = [max(50, int(n * share)) for n in (IMPACTS, LOCKED, ROLLING, FILES)]
    compared = max(4, int(AGAINST_SCIPY * share))
    rows = list(edges())
    remarks: list[Remark] = []
    for part in (
        impacts(number[0]),
        run_outs(number[1], number[2], compared),
        files(number[3]),
        maps(1 if share == 1 else 2, charts),
    ):
        for remark in part:
            print(*remark, sep=": ", flush=True)
            remarks.append(remark)
    minutes = (time.perf_counter() - begin) / 60
    remarks.append(("seconds", f"{minutes:.0f} minutes on this machine, compilation included"))
    _table(rows, Row, charts / "atlas.csv", remarks)


if __name__ == "__main__":
    if sys.argv[1:]:
        folder = Path(sys.argv[2])
        folder.mkdir(parents=True, exist_ok=True)
        main(folder, float(sys.argv[1]))
    else:
        from benchmarks import page

        main(DOCS / "charts")
        page.refresh(DOCS / "atlas.md", page.of_atlas(DOCS / "charts"))
