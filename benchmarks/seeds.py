"""Twenty seeds of the two example scenes: divergences, effective draws and seconds, compiled.

python3 -m uv run --group bench python -m benchmarks.seeds [seeds folder]

Sampling alone is timed, with the computation of all reported quantities from the draws: by NUTS with
half its default draws and with all, by importance sampling likewise. A first run with divergences
counts as it is: no second run hides it. With a number of seeds and a folder: a trial, which writes
there only.
"""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import arviz_stats
import numpy as np

from benchmarks import page
from benchmarks.__main__ import DOCS
from benchmarks.competitors import Array, Sites
from benchmarks.inference.cost import SCENES
from benchmarks.inference.reference import CHAINS, WARMUP
from benchmarks.machine import machine
from retrodict import load_scene
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.samplers import METHODS, importance, nuts
from retrodict.inference.samplers.chains import sample
from retrodict.inference.samplers.draws import Draws, Task
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.quantities import REPORTED

SEEDS = 20
BUDGETS = (
    ("nuts", METHODS["nuts"].draws // 2),
    ("nuts", METHODS["nuts"].draws),
    ("importance", 500),
    ("importance", 1000),
)  # draws of a chain
_TAILS = (0.05, 0.95)  # Vehtari et al. 2021


class Run(NamedTuple):
    """One seed: seconds, and the worst of the reported quantities."""

    seconds: float
    divergences: int
    leapfrogs: float
    bulk: float
    tail: float
    rhat: float


def run(posterior: Posterior, method: str, draws: int, seed: int) -> Run:
    """A method with one seed, its programs compiled before."""
    task = Task(posterior, CHAINS, draws, WARMUP, seed, lambda *_: None)
    begin = time.perf_counter()
    divergences, leapfrogs = 0, np.nan
    if method == "nuts":
        found = sample(task, nuts.targets(posterior.programs.structure)[0])
        divergences = int(found.stats["diverging"].sum())
        leapfrogs = float(found.stats["n_steps"].mean())
        quantities = Draws(found.w, {}).known(posterior)
    else:
        quantities = importance.draw(task).known(posterior)
    seconds = time.perf_counter() - begin
    return Run(seconds, divergences, leapfrogs, *_worst(quantities))


def _worst(quantities: Sites) -> tuple[float, float, float]:
    """Least bulk and tail ESS and largest R-hat of the reported quantities."""
    chains = [np.reshape(quantities[name], (CHAINS, -1)) for name in REPORTED if name in quantities]
    moving = [x for x in chains if np.ptp(x) > 0]  # what is known stands still

    def of(statistic: Callable[..., Array], **options: object) -> list[float]:
        return [float(statistic(x, **options)) for x in moving]

    bulk, tail = of(arviz_stats.ess, method="bulk"), of(arviz_stats.ess, method="tail", prob=_TAILS)
    return min(bulk), min(tail), max(of(arviz_stats.rhat))


def rows(seeds: int) -> Iterator[dict[str, object]]:
    """A row for each scene and budget."""
    for scene, file in SCENES.items():
        posterior = prepare(load_scene(file), DEFAULT_RUNG)
        for method, draws in BUDGETS:
            run(posterior, method, draws, seeds)  # compiles
            runs = Run(*np.array([run(posterior, method, draws, seed) for seed in range(seeds)]).T)
            row = {
                "scene": scene,
                "method": method,
                "draws": f"{CHAINS} × {f'({WARMUP} + {draws})' if method == 'nuts' else draws}",
                "seeds": seeds,
                "divergences": int(np.sum(runs.divergences)),
                "leapfrogs": f"{np.mean(runs.leapfrogs):.2f}" if method == "nuts" else "",
                "bulk_median": f"{np.median(runs.bulk):.0f}",
                "bulk_least": f"{np.min(runs.bulk):.0f}",
                "tail_median": f"{np.median(runs.tail):.0f}",
                "tail_least": f"{np.min(runs.tail):.0f}",
                "rhat_largest": f"{np.max(runs.rhat):.3f}",
                "seconds_median": f"{np.median(runs.seconds):.3f}",
                "seconds_least": f"{np.min(runs.seconds):.3f}",
                "machine": machine(),
            }
            print("  ".join(str(value) for value in row.values()), flush=True)
            yield row


def main(seeds: int = SEEDS, charts: Path = DOCS / "charts") -> None:
    """Run them all, then write the table and its page."""
    charts.mkdir(parents=True, exist_ok=True)
    found = list(rows(seeds))
    with (charts / "seeds.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, list(found[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(found)
    if charts == DOCS / "charts":
        page.refresh(DOCS / "inference.md", page.of_inference(charts))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]), *map(Path, sys.argv[2:3]))
