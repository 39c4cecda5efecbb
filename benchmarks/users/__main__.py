"""How fast is it on scenes as users write them? Runs each by the command, and rewrites docs/users.md.

python3 -m uv run --group bench python -m benchmarks.users [--again-only] [--folder DIR] [SCENE ...]

Each scene is run twice, each time in a fresh process with all options at their defaults: with an
empty cache of compiled programs, and again with what that run compiled. The paper's example is run
in the same way before, three times, and every figure is a ratio to its median. Rows are kept in
out/users/results.csv as they come, and a run continues where the last one stopped; delete that file
to repeat it. Results and logs of each scene are beside it. Linux only, like the cache folder that it
sets.

With names, these scenes are run anew, and the page stays as it is. --again-only leaves out the first
pass, and runs a scene unmeasured until nothing compiles. --folder keeps rows elsewhere: a trial.
"""

from __future__ import annotations

import argparse
import csv
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks import page
from benchmarks.__main__ import DOCS
from benchmarks.machine import machine
from benchmarks.users import runs, scores
from benchmarks.users.catalogue import UserScene, scenes
from benchmarks.users.runs import AGAIN, COLUMNS, FIRST, Row
from benchmarks.users.scores import PAPER, PICTURE

EXAMPLE = DOCS.parent / "examples" / PAPER / "scene.toml"
FOLDER = DOCS.parent / "out" / "users"
REPEATS = 3  # of the paper's example


class Place(NamedTuple):
    """What a row is of: scene, number of the repeat, pass."""

    scene: str
    repeat: str
    which: str


def places(names: Iterable[str], passes: Sequence[str]) -> Iterator[Place]:
    """The rows to measure, in order: those of the paper's example first."""
    for name, repeats in [(PAPER, REPEATS), *((name, 1) for name in names)]:
        for repeat in range(repeats):
            for which in passes:
                yield Place(name, str(repeat), which)


def read_rows(file: Path) -> list[Row]:
    """The rows kept in a file; none where there is no such file."""
    if not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as kept:
        return [*csv.DictReader(kept)]


def write_rows(file: Path, rows: Iterable[Row]) -> None:
    """Keep these rows, and no others; a run that is stopped here leaves the file as it was."""
    new = file.with_suffix(".new")
    with new.open("w", newline="", encoding="utf-8") as kept:
        writer = csv.DictWriter(kept, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    os.replace(new, file)


def place_of(row: Row) -> Place:
    """What a row is of."""
    return Place(row["scene"], row["repeat"], row["pass"])


def measure(names: Sequence[str], passes: Sequence[str], folder: Path) -> list[Row]:
    """Run what has no row yet.

    Args:
        names: names of scenes.
        passes: passes to run.
        folder: folder of rows, results and logs.

    Returns:
        All rows in the folder.
    """
    known = scenes()
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "results.csv"
    rows = read_rows(file)
    done = {place_of(row) for row in rows}
    for place in places(names, passes):
        if place in done:
            continue
        scene = EXAMPLE if place.scene == PAPER else known[place.scene].file
        own = folder / place.scene
        if place.which == FIRST:
            row = runs.first(scene, own)
        else:
            # an interrupted run may have left the cache of another repeat, or none
            row = runs.again(scene, own, warm_up=FIRST not in passes or not _just_ran(rows, place))
        row |= {"scene": place.scene, "repeat": place.repeat, "pass": place.which}
        rows.append(row)
        write_rows(file, rows)
        shown = (*place, row["verdict"], f"{row['cpu']} s CPU", f"{row['wall']} s", row["model"])
        print(*shown, row["reason"], sep="  ", flush=True)
    return rows


def _just_ran(rows: Sequence[Row], place: Place) -> bool:
    """Whether the last row is the first pass of the same scene."""
    return bool(rows) and place_of(rows[-1]) == place._replace(which=FIRST)


def forget(names: Iterable[str], passes: Sequence[str], folder: Path) -> None:
    """Drop the rows of these scenes and passes, so that they are measured anew."""
    file, chosen = folder / "results.csv", set(names)
    if file.exists():
        rows = read_rows(file)
        write_rows(
            file, (row for row in rows if row["scene"] not in chosen or row["pass"] not in passes)
        )


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and write page and picture."""
    known = scenes()
    parser = argparse.ArgumentParser(prog="python -m benchmarks.users")
    parser.add_argument("names", nargs="*", metavar="SCENE", help="scenes to run; else all")
    parser.add_argument("--again-only", action="store_true", help="with everything compiled only")
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where rows are kept")
    asked = parser.parse_args(arguments)
    if unknown := [name for name in asked.names if name not in known]:
        parser.error(f"no scene {', '.join(unknown)}; choose from {', '.join(known)}")
    passes = (AGAIN,) if asked.again_only else (FIRST, AGAIN)
    if asked.names:
        forget(asked.names, passes, asked.folder)
    rows = measure(asked.names or [*known], passes, asked.folder)
    report(rows, known, to_page=not asked.names and asked.folder == FOLDER)


def report(rows: Sequence[Row], known: dict[str, UserScene], *, to_page: bool) -> None:
    """Print what stands between the page's markers; write it, and the picture, where asked.

    Args:
        rows: rows of all runs.
        known: scenes by name.
        to_page: whether page and picture are written.
    """
    found = scores.parts(rows, known, machine(("jax", "numpyro", "scipy")))
    if to_page:
        from benchmarks.users.chart import draw

        draw(scores.all_scores(rows, known), DOCS / PICTURE)
        page.refresh(DOCS / "users.md", found)
    print("\n".join(line for lines in found.values() for line in [*lines, ""]))


if __name__ == "__main__":
    main()
