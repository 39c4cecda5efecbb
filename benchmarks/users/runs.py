"""Runs `retrodict reconstruct` on a scene in a process of its own, and reads what it wrote."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

TIME_OUT = 600.0  # s a command
QUANTITIES = ("speed_a", "speed_b", "travelling_speed_a", "e", "e_m", "mu")
STAGES = ("total", "compile", "sample")  # of `seconds` in summary.json
FIRST, AGAIN = (
    "first",
    "again",
)  # with an empty cache of compiled programs; with all of them compiled
COLUMNS = (
    "scene", "repeat", "pass", "verdict", "reason", "cpu", "wall", "status", "programs",
    *STAGES, "model", "method",
    *(f"{quantity}_{number}" for quantity in QUANTITIES for number in ("mean", "sd")),
    "flags", "notes",
)  # fmt: skip
Row = dict[str, str]
_MOST_WARM_UPS = 2


class Ended(NamedTuple):
    """How a command ended.

    Args:
        status: exit status; None where it took too long.
        cpu: CPU seconds of it and its child processes.
        wall: seconds.
        programs: number of programs that it added to the cache.
    """

    status: int | None
    cpu: float
    wall: float
    programs: int


def first(scene: Path, folder: Path) -> Row:
    """Reconstruct a scene with an empty cache of compiled programs.

    Args:
        scene: scene file.
        folder: folder of this scene, for its cache, results and log.

    Returns:
        What is measured and read, by column.
    """
    shutil.rmtree(folder / "cache", ignore_errors=True)
    return _measured(scene, folder)


def again(scene: Path, folder: Path, *, warm_up: bool = False) -> Row:
    """Reconstruct a scene with the programs that an earlier run compiled.

    Args:
        scene: scene file.
        folder: folder of this scene, as for `first`.
        warm_up: whether to run it unmeasured before, until a run compiles nothing.

    Returns:
        What is measured and read, by column.
    """
    row = _measured(scene, folder)
    for _ in range(_MOST_WARM_UPS if warm_up else 0):
        if row["programs"] == "0":
            break
        row = _measured(scene, folder)
    return row


def _measured(scene: Path, folder: Path) -> Row:
    results, log = folder / "results", folder / "log.txt"
    shutil.rmtree(results, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)
    ended = _command(scene, results, log, folder / "cache")
    summary = results / "summary.json"
    found = json.loads(summary.read_text("utf-8")) if summary.is_file() else None
    return read(ended, log.read_text("utf-8", errors="replace"), found, str(scene))


def _command(scene: Path, results: Path, log: Path, cache: Path) -> Ended:
    """Run the command to its end, or to the time limit."""
    program = Path(sys.executable).with_name("retrodict")
    command = [str(part) for part in (program, "reconstruct", scene, "--out", results)]
    # matplotlib's list of fonts is no compiled program: all scenes share one
    fonts = folder_of_fonts(cache)
    environment = os.environ | {"XDG_CACHE_HOME": str(cache), "MPLCONFIGDIR": str(fonts)}
    compiled = _programs(cache)
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    status: int | None = None
    with log.open("w") as out:
        process = subprocess.Popen(
            command, stdout=out, stderr=subprocess.STDOUT, env=environment, start_new_session=True
        )
        try:
            status = process.wait(TIME_OUT)
        except subprocess.TimeoutExpired:
            pass
        finally:  # an interrupt ends it too
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
    wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Ended(status, cpu, wall, len(_programs(cache) - compiled))


def folder_of_fonts(cache: Path) -> Path:
    """Where matplotlib keeps its list of fonts: beside the folders of all scenes."""
    fonts = cache.parents[1] / "matplotlib"
    fonts.mkdir(parents=True, exist_ok=True)
    return fonts


def _programs(cache: Path) -> set[Path]:
    return set(cache.rglob("*.bin"))


def read(ended: Ended, log: str, summary: Mapping[str, Any] | None, scene: str) -> Row:
    """The row of a run, but for its place in the table.

    Args:
        ended: how the command ended.
        log: what it printed.
        summary: content of summary.json; None where it wrote none.
        scene: path of the scene file as the command took it.

    Returns:
        What is measured and read, by column.
    """
    verdict, reason = _verdict(ended.status, log, summary, scene)
    row: dict[str, object] = {
        "verdict": verdict,
        "reason": reason,
        "cpu": f"{ended.cpu:.2f}",
        "wall": f"{ended.wall:.2f}",
        "status": "" if ended.status is None else ended.status,
        "programs": ended.programs,
    }
    if ended.status == 0 and summary:
        row |= {stage: _number(summary["seconds"].get(stage)) for stage in STAGES}
        row |= {"model": summary["model"], "method": summary["settings"].get("method", "")}
        row |= {
            "flags": "; ".join(summary["checks"]["flags"]),
            "notes": " | ".join(summary["notes"]),
        }
        for quantity in QUANTITIES:
            mean, sd = _answer(summary, quantity)
            row |= {f"{quantity}_mean": _number(mean), f"{quantity}_sd": _number(sd)}
    return {column: str(row.get(column, "")) for column in COLUMNS}


def _verdict(
    status: int | None, log: str, summary: Mapping[str, Any] | None, scene: str
) -> tuple[str, str]:
    """What became of a scene, and why."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    last = lines[-1] if lines else ""
    if status is None:
        return "timed out", f"stopped after {TIME_OUT:.0f} s; last line: {last}"
    if status == 0 and summary:
        checks = summary["checks"]
        if checks["passed"]:
            return "passed", ""
        return "withheld", "; ".join(checks["reasons"])
    if "Traceback (most recent call last)" in log:
        return "traceback", last
    if status == 2:
        own = [line for line in lines if line.startswith(scene)]
        # the path of a file says nothing on another machine
        return "refused", (own[-1] if own else last).removeprefix(scene).removeprefix(": ")
    return "failed", f"exit status {status}: {last}"


def _answer(summary: Mapping[str, Any], quantity: str) -> tuple[float | None, float | None]:
    """Posterior mean and sd of a quantity; of one that was measured, not asked for, likewise."""
    if found := summary["parameters"].get(quantity):
        return found["mean"], found["sd"]
    measured = summary["measured"].get(quantity, {})
    return measured.get("mean"), measured.get("sd_found")


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
