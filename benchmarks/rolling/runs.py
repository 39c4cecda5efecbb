"""Reconstructs a scene by the command, in a process of its own, and reads what it wrote."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import xarray as xr

from benchmarks.rolling.scenes import Made

TIME_OUT = 300.0  # s
QUANTITIES = ("speed_a", "speed_b", "e", "e_m", "mu")
NUMBERS = (
    "true", "median", "sd", "low_50", "high_50", "low_90", "high_90", "low_99.9", "high_99.9",
)  # fmt: skip
COLUMNS = (
    "scene", "wheels_a", "wheels_b", "rolling", "drag", "steered", "recorder", "course", "asked",
    "way_a", "way_b", "status", "reason", "model", "method", "seconds",
    *(f"{quantity}_{number}" for quantity in QUANTITIES for number in NUMBERS),
)  # fmt: skip
Row = dict[str, str]


def run(index: int, made: Made, scene: Path) -> Row:
    """Reconstruct a scene twice, with all options at their defaults, and time the second run.

    The first run compiles what the cache lacks. Each structure of scene has programs of its own, so
    there is no other run that would warm the cache.

    Args:
        index: of the scene.
        made: the crash.
        scene: its file, beside which the results go.

    Returns:
        Its row of the table; the answer is that of the second run.
    """
    plan, true = made.plan, made.truth
    row: dict[str, object] = {
        "scene": index,
        "wheels_a": plan.wheels[0],
        "wheels_b": plan.wheels[1],
        "rolling": "".join(plan.wheels).count("R"),
        "drag": plan.drag,
        "steered": int(plan.steered),
        "recorder": int(plan.recorder),
        "course": int(plan.course),
        "asked": " ".join(plan.asked),
        "way_a": f"{true['way_a']:.1f}",
        "way_b": f"{true['way_b']:.1f}",
    }
    results = scene.parent / "results"
    _command(scene, results)
    summary = results / "summary.json"
    summary.unlink(missing_ok=True)  # of the first run
    status, row["seconds"] = _command(scene, results)
    row |= {f"{quantity}_true": f"{true[quantity]:.6g}" for quantity in plan.asked}
    if status != 0:
        row["status"] = {2: "refused", None: "timed out"}.get(status, "failed")
        last = (_log(results).read_text("utf-8").strip().splitlines() or [""])[-1]
        row["reason"] = last.removeprefix(f"{scene}: ")  # whose path says nothing elsewhere
        return _text(row)
    found = json.loads(summary.read_text("utf-8"))
    row["status"] = "answered" if found["checks"]["passed"] else "withheld"
    row["reason"] = "; ".join(found["checks"]["reasons"])
    row["model"], row["method"] = found["model"], found["settings"].get("method", "")
    draws = xr.load_dataset(results / "posterior.nc", group="posterior", engine="h5netcdf")
    for quantity in plan.asked:
        numbers = found["parameters"][quantity]
        extremes = draws[quantity].quantile([0.0005, 0.9995]).values
        bounds = [*numbers["interval_50"], *numbers["interval_90"], *extremes]
        values = [numbers["median"], numbers["sd"], *bounds]
        row |= {
            f"{quantity}_{name}": f"{value:.6g}"
            for name, value in zip(NUMBERS[1:], values, strict=True)
            if value is not None
        }
    return _text(row)


def _log(results: Path) -> Path:
    return results.with_name("log.txt")


def _command(scene: Path, results: Path) -> tuple[int | None, str]:
    """The exit status, None where it took too long; and the seconds."""
    command = [Path(sys.executable).with_name("retrodict"), "reconstruct", scene, "--out", results]
    begin, status = time.perf_counter(), None
    with _log(results).open("w") as log:
        try:
            done = subprocess.run(
                command, stdout=log, stderr=subprocess.STDOUT, timeout=TIME_OUT, check=False
            )
            status = done.returncode
        except subprocess.TimeoutExpired:
            pass
    return status, f"{time.perf_counter() - begin:.2f}"


def _text(row: dict[str, object]) -> Row:
    return {column: str(row.get(column, "")) for column in COLUMNS}
