"""All of it: measured, judged, written."""

from __future__ import annotations

from pathlib import Path

from benchmarks.inference import agreement, cost
from benchmarks.inference.chart import draw
from benchmarks.inference.reference import Effort, posteriors_of, refer
from benchmarks.machine import machine
from benchmarks.tables import Remark, shown
from retrodict import load_scene


def main(charts: Path, share: float = 1.0) -> None:
    """Measure, then write `inference.csv`, `inference.png` and `agreement.csv` into the folder.

    Args:
        charts: the folder.
        share: of the work, for a trial.
    """
    effort = Effort() if share == 1 else Effort().scaled(share)
    packages = ("jax", "numpyro", "blackjax", "emcee", "numpy", "scipy")
    remarks: list[Remark] = [("machine", machine(packages))]
    points: list[cost.Point] = []
    rows: list[agreement.Compared] = []
    for scene, file in cost.SCENES.items():
        posteriors = posteriors_of(load_scene(file))
        known, remark = refer(posteriors, effort, scene)
        remarks.append(remark)
        print(*remark, flush=True)
        for found in (cost.ours, cost.theirs):
            for point in found(posteriors, known, effort, scene):
                points.append(point)
                print(*point[:3], *map(shown, point[3:9]), point.note, flush=True)
        rows += agreement.compare(posteriors, known, scene)
    rows += agreement.at_random(effort)
    verdicts = list(agreement.judged(rows))
    stopped = [p for p in points if p.listed and p.note]
    remarks += [
        *cost.targets(points),
        *(("stopped", f"{p.scene}, {p.method}: {p.note}") for p in stopped),
    ]
    cost.write(points, remarks, charts / "inference.csv")
    agreement.write(rows, verdicts, charts / "agreement.csv")
    below = [
        "Dashed, hollow: extrapolated, by draws in proportion to seconds and errors to their root. Our"
        f" errors are root mean squares over {effort.repeats} seeds, others' of one run. All compiled.",
        *(text for kind, text in remarks if kind in ("targets", "machine")),
    ]
    draw(points, charts / "inference.png", below)
    print(*(f"{kind}: {text}" for kind, text in [*remarks, *verdicts]), sep="\n")
