"""What batches cost as they grow, and what a second worker brings.

python3 -m uv run --group bench python -m benchmarks.batch [counts, as 10,100,1000] [folder]

The scenes are crashes simulated from the design of `retrodict calibrate`, which share one structure.
Each count is answered by one worker (up to a hundred scenes) and by two, each time from nothing but
compiled programs. Memory is what worker processes hold (RSS), at the first and the last hundred scenes.
How often the central 95 % hold what was simulated is counted in the largest batch. Writes
docs/charts/batch.csv, batch.png and the numbers of docs/batch.md; a folder, for a trial, leaves the page
alone.

`mixed` in place of the counts: the same crashes as twelve users would write them, who leave out
different things, by two workers, with compiled programs. `same`: are a batch's means those of
`reconstruct` by importance sampling? Each writes its own lines of the page.
"""

from __future__ import annotations

import csv
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from threading import Event, Thread
from typing import NamedTuple

import numpy as np
import pandas as pd
import psutil
from matplotlib.figure import Figure
from retrodict.models import RUNGS

import retrodict as rd
from benchmarks import page
from benchmarks.__main__ import DOCS
from benchmarks.machine import machine
from retrodict.inference.density.compiled import programs_for
from retrodict.inference.reconstruct import reconstruct
from retrodict.options import DEFAULT_RUNG, RunOptions
from retrodict.report.batch import PASSED
from retrodict.studies import batch, calibration
from retrodict.studies.short import of_draws

COUNTS = (10, 100, 1000)
WORKERS = (1, 2)
ALONE = 100  # scenes: more of them are answered by two workers only
EVERY = 1.0  # s between looks at memory
END = 100  # scenes at either end whose memory is compared
MB = 2**20
USERS = 12  # who write the mixed crashes
MIXED = 20 * USERS
SAME = 300  # crashes that are answered both ways
UNKNOWNS = ("speed_b", "e", "e_m", "mu")


class Run(NamedTuple):
    """A batch: memory in MB of all workers together, early and late."""

    scenes: int
    workers: int
    seconds: float
    answered: int
    memory_early: float
    memory_late: float

    @property
    def a_minute(self) -> float:
        return 60 * self.scenes / self.seconds


def scenes(count: int) -> Iterator[tuple[rd.Scene, dict[str, float]]]:
    """Simulated crashes, measured as the design says, and what is true of each."""
    design = calibration.design()
    structure, data = RUNGS[DEFAULT_RUNG].of_scene(design)
    for number in range(count):
        i = number % calibration._BATCH
        if i == 0:
            truths = np.random.default_rng([0, number])
            sites, known = calibration._truths(programs_for(structure), data, truths)
        one = {k: v[i] for k, v in known.items()}
        scene = calibration._measured(design, structure, one, np.random.default_rng([1, number]))
        yield scene, {name: float(sites[name][i]) for name in UNKNOWNS}


def as_written_by(user: int, text: str) -> str:
    """A scene file without what one of twelve users leaves out."""
    heading_a, other, interlocked = user % 2, user // 2 % 3, user // 6
    vehicle, kept = "", []
    for line in text.splitlines():
        vehicle = line if line.startswith("[") else vehicle
        turned = line.startswith(("rest.heading", "rest.rotation"))
        without = {"[vehicles.A]": not heading_a, "[vehicles.B]": other == 0}.get(vehicle, False)
        if turned and without:
            continue
        if other == 1 and line.startswith("rest.rotation"):
            continue
        if other == 2 and line.startswith("approach.yaw_rate"):
            line = 'approach.yaw_rate = "unknown"'
        if interlocked and line.startswith("interlocked"):
            line = "interlocked = true"
        kept.append(line)
    return "\n".join(kept)


def mixed(charts: Path) -> None:
    """Answer crashes of many structures; write what it took."""
    files, structures = [], set()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for i, (scene, _) in enumerate(scenes(MIXED)):
            files.append(folder / f"{i:05}.toml")
            files[-1].write_text(as_written_by(i % USERS, scene.to_toml()), "utf-8")
            structures.add(RUNGS[DEFAULT_RUNG].of_scene(rd.load_scene(files[-1]))[0])
        rd.batch(files[:USERS], workers=1)  # compiles
        run, _ = measured(files, max(WORKERS), folder / "mixed")
    said = (
        f"- {run.scenes} scenes as {USERS} users would write them, of {len(structures)} structures, by "
        f"{run.workers} workers: {run.seconds:.0f} s, {run.a_minute:.0f} a minute; {run.answered} "
        f"answered; {run.memory_early:.0f} MB at first, {run.memory_late:.0f} at last"
    )
    if charts == DOCS / "charts":
        page.refresh(DOCS / "batch.md", {"mixed": [said]}, whole=False)
    print(said)


def same(charts: Path) -> None:
    """Compare means with those of `reconstruct`; write how far apart they are."""
    apart = {name: list[float]() for name in UNKNOWNS}  # Monte Carlo errors
    shifts, one_only = [], 0
    for i, (scene, _) in enumerate(scenes(SAME)):
        one = batch.answer(scene, DEFAULT_RUNG, 0)
        options = RunOptions(model=DEFAULT_RUNG, method="importance", seed=1)
        draws = reconstruct(scene, options, pictured=False)
        if one.reason or draws.checks.reasons:
            one_only += bool(one.reason) != bool(draws.checks.reasons)
            continue
        other = of_draws(draws)
        for name in UNKNOWNS:
            mine, its = one.numbers[name], other[name]
            shift = mine["mean"] - its["mean"]
            apart[name].append(shift / np.hypot(mine["mcse_mean"], its["mcse_mean"]))
            shifts.append(abs(shift) / its["sd"])
        print(i, {name: f"{each[-1]:+.1f}" for name, each in apart.items()}, flush=True)
    said = [
        f"- `{name}`: {np.mean(np.abs(each) < 1.96):.0%} within 1.96 Monte Carlo errors of both, the "
        f"farthest {np.abs(each).max():.1f}"
        for name, each in apart.items()
    ]
    said.append(
        f"- the farthest mean of all is {max(shifts):.2f} posterior sds off; of {SAME} crashes "
        f"{len(apart['e'])} are answered both ways, {one_only} one way only"
    )
    if charts == DOCS / "charts":
        page.refresh(DOCS / "batch.md", {"same": said}, whole=False)
    print("\n".join(said))


def measured(files: list[Path], workers: int, out: Path) -> tuple[Run, pd.DataFrame]:
    """Answer scene files, and look at the memory of the processes that do it; the table too."""
    looks: list[tuple[int, float]] = []  # scenes done, MB
    done, ended = 0, Event()

    def progress(stage: str, so_far: int, _: int) -> None:
        nonlocal done
        done = so_far if stage.startswith("answering") else done

    def look() -> None:
        own = psutil.Process()
        while not ended.wait(EVERY):
            doing = own.children(recursive=True) if workers > 1 else [own]
            try:
                looks.append((done, sum(each.memory_info().rss for each in doing) / MB))
            except psutil.NoSuchProcess:
                continue

    thread = Thread(target=look)
    thread.start()
    begin = time.perf_counter()
    try:
        table = rd.batch(files, workers=workers, out=out, progress=progress)
    finally:
        ended.set()
        thread.join()
    seconds = time.perf_counter() - begin
    end = min(END, len(files) // 2)
    early = [mb for count, mb in looks if 0 < count <= end]
    late = [mb for count, mb in looks if count >= len(files) - end]
    answered = int((table["checks"] == PASSED).sum())
    middle = (float(np.median(each)) if each else np.nan for each in (early, late))
    return Run(len(files), workers, seconds, answered, *middle), table


def covered(table: pd.DataFrame, truths: list[dict[str, float]]) -> dict[str, float]:
    """Share of the answered scenes whose central 95 % hold what was simulated, by unknown."""
    true = pd.DataFrame(truths[: len(table)])
    known = (table["checks"] == PASSED).to_numpy()
    shares = {}
    for name in UNKNOWNS:
        low, high = (table[f"{name}_{limit}"].to_numpy()[known] for limit in ("low_95", "high_95"))
        shares[name] = float(np.mean((low <= true[name][known]) & (true[name][known] <= high)))
    return shares


def draw(runs: list[Run], file: Path) -> None:
    figure = Figure(figsize=(10, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    for workers, look in zip(WORKERS, ("o-", "s--"), strict=True):
        mine = [run for run in runs if run.workers == workers]
        name = f"{workers} worker{'s' * (workers > 1)}"
        counts = [run.scenes for run in mine]
        left.loglog(counts, [run.seconds for run in mine], look, color="black", label=name)
        right.semilogx(counts, [run.memory_late for run in mine], look, color="black", label=name)
    left.set(xlabel="scenes", ylabel="seconds", title="Time")
    right.set(
        xlabel="scenes", ylabel="MB, at the end", title="Memory of the workers", ylim=(0, None)
    )
    left.legend()
    figure.savefig(file, dpi=120)


def parts(runs: list[Run], held: dict[str, float]) -> page.Parts:
    """What stands between the markers of docs/batch.md."""
    alone = {run.scenes: run.seconds for run in runs if run.workers == 1}
    headings = [
        "scenes", "workers", "seconds", "scenes a minute", "times as fast as one worker", "answered",
        "MB, first", "MB, last",
    ]  # fmt: skip
    rows = [
        [
            str(run.scenes), str(run.workers), f"{run.seconds:.0f}", f"{run.a_minute:.0f}",
            f"{alone[run.scenes] / run.seconds:.2f}" if run.scenes in alone else "",
            str(run.answered), f"{run.memory_early:.0f}", f"{run.memory_late:.0f}",
        ]
        for run in runs
    ]  # fmt: skip
    count = runs[-1].answered
    error = np.sqrt(0.95 * 0.05 / count)
    of_each = ", ".join(f"`{name}` {share:.1%}" for name, share in held.items())
    return {
        "machine": [f"- {machine()}"],
        "cost": page.table(headings, rows),
        "covered": [f"- {of_each}; of {count} scenes, so each ± {error:.1%} by chance"],
    }


def main(counts: tuple[int, ...] = COUNTS, charts: Path = DOCS / "charts") -> None:
    """Measure, draw and write the page."""
    charts.mkdir(parents=True, exist_ok=True)
    runs: list[Run] = []
    with tempfile.TemporaryDirectory() as name:
        folder, files, truths = Path(name), [], []
        for i, (scene, truth) in enumerate(scenes(max(counts))):
            truths.append(truth)
            files.append(folder / f"{i:05}.toml")
            files[-1].write_text(scene.to_toml(), "utf-8")
        rd.batch(files[:1], workers=1)  # compiles
        with (charts / "batch.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(Run._fields)
            for count in counts:
                for workers in WORKERS[count > ALONE :]:
                    run, last = measured(files[:count], workers, folder / f"{count}-{workers}")
                    runs.append(run)
                    table.writerow(runs[-1])
                    file.flush()
                    print(runs[-1], flush=True)
    draw(runs, charts / "batch.png")
    found = parts(runs, covered(last, truths))
    if charts == DOCS / "charts":
        page.refresh(DOCS / "batch.md", found, whole=False)
    print("\n".join(line for lines in found.values() for line in [*lines, ""]))


if __name__ == "__main__":
    # a worker has one core, and so has this process where it is the only one
    os.environ["NPROC"] = "1"
    what, *given = sys.argv[1:] or [",".join(map(str, COUNTS))]
    into = Path(given[0]) if given else DOCS / "charts"
    if what == "same":
        same(into)
    elif what == "mixed":
        mixed(into)
    else:
        main(tuple(map(int, what.split(","))), into)
