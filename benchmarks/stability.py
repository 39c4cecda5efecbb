"""The atlas of failure: where every option breaks, and what a user then sees.

python3 -m uv run --group bench python -m benchmarks.stability [part ...] [--trial SHARE FOLDER]

Each part writes its table into docs/charts, and then the numbers of docs/atlas.md: `random` (impacts,
run-outs and scene files), `reconstructions` (crashes at random), `unseen` (more of them, which nothing
was tuned on; both go on where they stopped), `mechanics` and `inference` (edges), `map` (and atlas.png).
None named: all of them. A trial takes a share of the counts (0.05, say) and writes into the folder only.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks import tables
from benchmarks.atlas import Row
from benchmarks.tables import Remark

CHARTS = Path(__file__).resolve().parents[1] / "docs" / "charts"
IMPACTS, LOCKED, ROLLING, FILES, CRASHES = 10_000, 10_000, 10_000, 10_000, 50
UNSEEN, UNSEEN_FROM = 100, 1000  # crashes; seed of the first
FIXED_STEPS, COARSE = (12, 48, 192), 0.01  # COARSE: m
AGAINST_SCIPY = 20  # run-outs of each kind


def impacts(number: int) -> Iterator[Remark]:
    """Impacts at random."""
    from tests.shared import random_impacts as drawn

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
    from retrodict.mechanics.integration import MOST_STEPS
    from tests.shared import random_run_outs as drawn

    for name, number in (("locked", locked), ("rolling", rolling)):
        scenes = drawn.draw(number, rolling=name == "rolling")
        found = drawn.examine(scenes)
        broken = np.any(list(found.faults.values()), axis=0).sum()
        few = drawn.Found(found.rest[:compared], found.refused[:compared], {})
        apart = drawn.differences(scenes[:compared], few)
        far = (apart > drawn.WITHIN).sum()
        yield (
            "runouts",
            f"{number} run-outs, wheels {name}: {broken} break a law; {found.refused.sum()} could not "
            f"be followed in {MOST_STEPS} steps, and have no rest pose (not numbers); of the first "
            f"{len(apart)}, {far} end over {drawn.WITHIN * 1e3:g} mm or mrad from where SciPy's do "
            f"(worst {apart.max() * 1e3:.1g})",
        )
        if name == "rolling":  # whose clock is stiff: fixed steps are not for them
            continue
        off, errors = np.concatenate(
            [drawn.in_fixed_steps(scenes, found, n) for n in FIXED_STEPS], axis=1
        )
        bad, unseen = off > COARSE, (off > COARSE) & ~(errors > COARSE)
        yield (
            "runouts",
            f"the same in {', '.join(map(str, FIXED_STEPS))} fixed steps: of {off.size} rest poses "
            f"{bad.sum()} are off by over {COARSE * 1e3:g} mm, and of these `step_error` says so of all "
            f"but {unseen.sum()}, of which the worst is off by {off[unseen].max(initial=0) * 1e3:.0f} "
            f"mm; of the {(~bad).sum()} others it says so of {(~bad & (errors > COARSE)).sum()}",
        )


def files(number: int) -> Iterator[Remark]:
    """Scene files at random."""
    from benchmarks.atlas import files as drawn

    counts = drawn.count(number)
    verdicts = ", ".join(f"{n} {verdict}" for verdict, n in sorted(counts.items()))
    yield (
        "files",
        f"{counts.total()} scene files given to `retrodict check`: {verdicts}, no traceback",
    )


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


def reconstructions(charts: Path, share: float) -> None:
    """Write `atlas-reconstructions.csv`: what crashes at random came to by every method."""
    from benchmarks.atlas.reconstructions import ALL

    _crashes("reconstructions", charts, range(max(2, int(CRASHES * share))), ALL)


def unseen(charts: Path, share: float) -> None:
    """Write `atlas-unseen.csv`: what other crashes at random came to by the exact methods."""
    from benchmarks.atlas.reconstructions import EXACT

    count = max(2, int(UNSEEN * share))
    _crashes("unseen", charts, range(UNSEEN_FROM, UNSEEN_FROM + count), EXACT)


def _crashes(part: str, charts: Path, seeds: range, methods: tuple[str, ...]) -> None:
    """Write a part's table of crashes at random by some methods, and its remarks below."""
    from benchmarks.atlas import reconstructions as drawn

    file = charts / f"atlas-{part}.csv"
    found = drawn.study(file, seeds, methods)
    with file.open("a", encoding="utf-8") as out:
        for of, text in (*drawn.remarks(found, part), *drawn.repeated(drawn.apart(found), part)):
            print(of, text, sep=": ", flush=True)
            out.write(f"# {of}: {text}\n")


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
    rows = [*_printed(edges.impacts()), *_printed(edges.run_outs())]
    _write(rows, Row, charts / "atlas-mechanics.csv", [], begin)


def inference(charts: Path, _: float) -> None:
    """Write `atlas-inference.csv`: edges of inference."""
    from benchmarks.atlas import posteriors

    begin = time.perf_counter()
    rows = list(_printed(posteriors.rows()))
    _write(rows, Row, charts / "atlas-inference.csv", [], begin)


def _printed(rows: Iterator[Row]) -> Iterator[Row]:
    """The rows, printed as they come."""
    for row in rows:
        print(row.part, row.edge, row.seen, sep=" | ", flush=True)
        yield row


def _write(
    rows: Sequence[NamedTuple], kind: type, file: Path, remarks: Sequence[Remark], begin: float
) -> None:
    """A table, its remarks, and how long it took."""
    minutes = f"{file.stem}: {(time.perf_counter() - begin) / 60:.1f} minutes"
    notes = [*remarks, ("seconds", minutes)]
    tables.write(file, kind._fields, rows, notes)  # type: ignore[attr-defined]
    print(*(f"{of}: {text}" for of, text in notes), sep="\n", flush=True)


PARTS = {
    "random": at_random,
    "reconstructions": reconstructions,
    "unseen": unseen,
    "mechanics": mechanics,
    "inference": inference,
    "map": maps,
}


def main() -> None:
    """Run the parts named on the command line."""
    parser = argparse.ArgumentParser(description="The atlas of failure: see docs/atlas.md.")
    parser.add_argument("parts", nargs="*", metavar="part", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--trial", nargs=2, metavar=("SHARE", "FOLDER"))
    asked = parser.parse_args()
    if unknown := set(asked.parts) - set(PARTS):
        parser.error(f"no such part: {', '.join(unknown)}; give some of {', '.join(PARTS)}")
    share, charts = (float(asked.trial[0]), Path(asked.trial[1])) if asked.trial else (1.0, CHARTS)
    charts.mkdir(parents=True, exist_ok=True)
    for part in asked.parts or PARTS:
        PARTS[part](charts, share)
        if not asked.trial:
            from benchmarks import how_wrong, page

            page.refresh(CHARTS.parent / "atlas.md", page.of_atlas(CHARTS))
            how_wrong.refresh()


if __name__ == "__main__":
    main()
