"""All of it: measured, judged, written."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks import tables
from benchmarks.integrators.chart import draw
from benchmarks.integrators.findings import (
    against_scipy,
    gradients,
    reasons,
    targets,
    turns_of,
    worst,
)
from benchmarks.integrators.rows import Row, by_set
from benchmarks.integrators.solvers import BATCH, DEFAULT, FEWER, FIXED, methods
from benchmarks.integrators.timing import SCIPY_EVERY, SINGLE, by_scipy, measure
from benchmarks.machine import machine
from benchmarks.tables import Remark, shown
from tests.shared import reference

TURNS, LENGTH = 2.0, 40.0  # an ordinary run-out has fewer turns and a shorter path, m
AWAY = 0.3  # m: a wheel that rests nearer to an edge is at a kink
GRADIENTS = 50
SHORTEST = 20  # rolling scenes whose derivatives are compared
NUMBER = 500  # scenes with locked wheels
ROLLING = 100  # scenes with rolling ones
COLUMNS = (
    *("scenes", "method", "setting", "mark", "number"),
    *("position_mm_median", "position_mm_p99", "position_mm_worst"),
    *("heading_deg_median", "heading_deg_p99", "heading_deg_worst"),
    *("share_within_1mm_0.01deg", "evaluations", "us_batched", "us_batched_two_threads"),
    *("us_single", "us_batched_jacobian"),
)


def main(charts: Path, number: int = NUMBER) -> None:
    """Measure, then write `integrators.csv` and `integrators.png` into the folder.

    Args:
        charts: the folder.
        number: of scenes with locked wheels.
    """
    of = reference.scenes(number)
    rolling = reference.rolling_scenes(ROLLING * number // NUMBER)
    known, known_rolling = reference.runs(of), reference.runs(rolling)
    turns = np.array([turns_of(scene, run) for scene, run in zip(of, known, strict=True)])
    length = np.array([run.length for run in known])
    ordinary = np.flatnonzero((turns < TURNS) & (length < LENGTH))
    groups = (
        ({"locked": np.arange(number), "ordinary": ordinary}, of, known),
        ({"rolling": np.arange(len(rolling))}, rolling, known_rolling),
    )
    rows: list[Row] = []
    for sets, scenes, runs in groups:
        truth = np.array([run.rest for run in runs])
        for method in methods():
            rows += measure(method, sets, scenes, truth)
            print(*rows[-1][:3], [shown(value) for value in rows[-1].figures], flush=True)
        rows += by_scipy(sets, scenes, truth)
    rows = [row for mine in by_set(rows).values() for row in mine]
    last = {row.scenes: row for row in rows if row.setting == f"{FIXED[-1]} steps"}
    default = {row.scenes: row for row in rows if row.method == DEFAULT}
    crossed = np.mean([run.crossings > 0 for run in known])
    compared, why = list(against_scipy(rows)), list(reasons(rows))
    edge = np.array([known[i].edge_distance for i in ordinary])
    shortest = np.argsort([run.evaluations for run in known_rolling])[:SHORTEST]
    differentiated = {
        f"ordinary scenes, no wheel at rest within {AWAY} m of an edge": [
            of[i] for i in ordinary[edge > AWAY][:GRADIENTS]
        ],
        "ordinary scenes, a wheel at rest on an edge": [
            of[i] for i in ordinary[edge < reference.TYRE_WIDTH / 2][: GRADIENTS // 2]
        ],
        "rolling scenes, those that end soonest": [rolling[i] for i in shortest],
    }
    remarks: list[Remark] = [
        ("machine", machine()),
        (
            "scenes",
            f"{number} with locked wheels, {crossed:.0%} with a wheel over the edge; ordinary are"
            f" the {len(ordinary)} of fewer than {TURNS:.0f} turns and less than {LENGTH:.0f} m",
        ),
        (
            "scenes",
            f"{len(rolling)} with rolling wheels: drag {reference.DRAG[0]} to {reference.DRAG[1]},"
            f" a quarter locked, front wheels steered by up to {reference.STEER} rad",
        ),
        (
            "scenes",
            f"batches are of {BATCH}, the scenes repeated; Jacobians are of the rest pose by start"
            " pose and start velocity, 3 by 6: in reverse for rest's default, else forward; those"
            f" of adaptive steps in batches of {BATCH // FEWER}; scenes are timed singly, {SINGLE} or"
            f" somewhat more of a set; SciPy runs every {SCIPY_EVERY}th scene",
        ),
        *targets(rows),
        *(("scipy", text) for text in compared),
        *(("why", text) for text in why),
        *gradients(differentiated),
        *worst(last["locked"], of, known),
        *worst(default["locked"], of, known),
        *worst(last["rolling"], rolling, known_rolling),
        *worst(default["rolling"], rolling, known_rolling),
    ]
    cells = ([*row[:4], len(row.of), *row.figures] for row in rows)
    tables.write(charts / "integrators.csv", COLUMNS, cells, remarks)
    missed = [*why, *(text for text in compared if "MISSED" in text)]
    below = ["Targets that are missed, and why:", *(f"– {text}" for text in missed)]
    draw(rows, charts / "integrators.png", [*below, remarks[0][1]])
    print(*(f"{kind}: {text}" for kind, text in remarks), sep="\n")
