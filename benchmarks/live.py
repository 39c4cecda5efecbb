"""A warm session: how fast it answers, how sure it is, and whether it agrees with a fresh run.

python3 -m uv run --group bench python -m benchmarks.live [changes]

Each change moves one to three of a scene's measured quantities by up to 3 of their standard deviations.
The answer's means and standard deviations are compared with those of NUTS from nothing, in standard
errors of both. The chart has the error of the mean, in posterior standard deviations, against seconds:
of scrambled Sobol points and of independent draws, from one proposal. Writes docs/charts/live.csv,
live.png, and the numbers of docs/live.md.
"""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

import retrodict as rd
from benchmarks import page
from benchmarks.__main__ import DOCS
from benchmarks.machine import machine
from retrodict.explore.controls import GROUPS, controls
from retrodict.inference.points import SCRAMBLINGS
from retrodict.inference.samplers.importance import evaluated
from retrodict.inference.samplers.psis import smoothed
from retrodict.inference.samplers.quasi import Weighted, scrambled
from retrodict.inference.warm import Warm

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
MODEL = "planar-moment+wheels"
SCENES = {"paper": "brach-1977", "berm": "brach-1977-berm"}
CHANGES = 200
MOVED, MOST = 3.0, 3  # standard deviations; quantities of a change
APART = (
    4.5  # standard errors beyond which an answer is wrong: of 3200 comparisons 0.02 are, by chance
)
OF = ("speed_b", "e", "e_m", "mu")
TIMES = 20  # answers that are timed
POINTS, REPEATS = (256, 512, 1024, 2048, 4096, 8192), 20
COLUMNS = ["scene", "change", "seconds", "points", "refitted", "passed", "worst", "fresh_passed"]


class Change(NamedTuple):
    """A changed scene answered: by how many standard errors a mean or an sd is off at most."""

    scene: str
    change: str
    seconds: float
    points: int
    refitted: bool
    passed: bool
    worst: float
    fresh_passed: bool


def changes(scene: rd.Scene, rng: np.random.Generator) -> dict[str, object]:
    """A random change of measured quantities, by key."""
    measured = [c for c in controls(scene) if c.sd > 0 and c.group != GROUPS[-1]]
    chosen = rng.choice(len(measured), rng.integers(1, MOST + 1), replace=False)
    found: dict[str, object] = {}
    for control in (measured[i] for i in chosen):
        value = control.value + rng.uniform(-MOVED, MOVED) * control.sd
        found |= control.changes(control.text(value))
    return found


def compared(name: str, count: int) -> Iterator[Change]:
    """Random changes of a scene, each answered by its session and by NUTS."""
    scene = rd.load_scene(EXAMPLES / SCENES[name] / "scene.toml")
    warm, rng = rd.session(scene, model=MODEL), np.random.default_rng(0)
    for _ in range(count):
        asked = changes(scene, rng)
        changed = scene.change(asked)
        begin = time.perf_counter()
        answer = warm.update(changed)
        seconds = time.perf_counter() - begin
        fresh = rd.reconstruct(changed, model=MODEL)
        yield Change(
            name,
            "; ".join(asked),
            seconds,
            answer.estimate.evaluations,
            answer.estimate.refitted,
            answer.checks.passed,
            _worst(answer, fresh),
            fresh.checks.passed,
        )


def _worst(answer: rd.Answer, fresh: rd.Result) -> float:
    weighted, quantities = answer.estimate.weighted, answer.estimate.quantities
    off = []
    for name in OF:
        sure = np.asarray(fresh.idata["posterior"][name])
        independent = fresh.checks.min_ess_bulk
        (mean, error), (sd, error_sd) = (
            weighted.mean(quantities[name]),
            weighted.sd(quantities[name]),
        )
        off.append((mean - sure.mean()) / np.hypot(error, sure.std() / np.sqrt(independent)))
        # of a normal's sd: half its variance's relative error
        fresh_error = sure.std() / np.sqrt(2 * fresh.checks.min_ess_tail)
        off.append((sd - sure.std()) / np.hypot(error_sd, fresh_error))
    return float(np.max(np.abs(off)))


def errors(name: str) -> Iterator[tuple[str, str, int, float, float]]:
    """(scene, points, their number, median seconds, root mean square error of the worst mean)."""
    warm = Warm(rd.load_scene(EXAMPLES / SCENES[name] / "scene.toml"), MODEL)
    posterior, proposal = warm.fitted[0].solution.posterior, warm.fitted[0].proposal
    size = proposal.middle.size + 2

    def means(u: np.ndarray) -> np.ndarray:
        w = proposal.at(u)
        heights, quantities = evaluated(posterior, w)
        log_weight = heights - proposal.log_density(w)
        weighted = Weighted(smoothed(log_weight)[0], SCRAMBLINGS)
        return np.array([weighted.mean(quantities[each])[0] for each in OF])

    sure = np.mean([means(scrambled(size, 8192, SCRAMBLINGS, 1000 + i)) for i in range(4)], axis=0)
    w = proposal.at(scrambled(size, 4096, 1, 999))
    heights, quantities = evaluated(posterior, w)
    log_weight = heights - proposal.log_density(w)
    weighted = Weighted(smoothed(log_weight)[0], SCRAMBLINGS)
    sd = np.array([weighted.sd(quantities[each])[0] for each in OF])
    for kind in ("scrambled Sobol", "independent"):
        for count in POINTS:
            off, seconds = [], []
            for seed in range(REPEATS):
                rng = np.random.default_rng(seed)
                begin = time.perf_counter()
                u = (
                    scrambled(size, count // SCRAMBLINGS, SCRAMBLINGS, seed)
                    if kind == "scrambled Sobol"
                    else rng.random((count, size))
                )
                found = means(u)
                seconds.append(time.perf_counter() - begin)
                off.append((found - sure) / sd)
            worst = float(np.sqrt(np.mean(np.square(off), axis=0)).max())
            yield name, kind, count, float(np.median(seconds)), worst


def timed(name: str) -> tuple[str, float, float]:
    """(scene, median seconds of an answer with its change, least independent draws of these)."""
    scene = rd.load_scene(EXAMPLES / SCENES[name] / "scene.toml")
    warm, rng = rd.session(scene, model=MODEL), np.random.default_rng(1)
    seconds, draws = [], []
    for _ in range(TIMES):
        asked = changes(scene, rng)
        begin = time.perf_counter()
        answer = warm.update(scene.change(asked))
        answer.summary()
        seconds.append(time.perf_counter() - begin)
        draws.append(answer.checks.min_ess_bulk)
    return name, float(np.median(seconds)), float(np.min(draws))


def _draw(rows: list[tuple[str, str, int, float, float]], file: Path) -> None:
    figure = Figure(figsize=(10, 4), layout="constrained")
    panels = figure.subplots(1, len(SCENES), sharey=True)
    for axes, name in zip(panels, SCENES, strict=True):
        for kind, look in (("scrambled Sobol", "o-"), ("independent", "s--")):
            mine = [row for row in rows if row[:2] == (name, kind)]
            axes.loglog([r[3] for r in mine], [r[4] for r in mine], look, color="black", label=kind)
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.axhline(1 / np.sqrt(1000), color="#999999", linewidth=0.8)
        axes.set(xlabel="seconds", title=f"{name}: grey, 1000 independent draws of the posterior")
    panels[0].set_ylabel("error of the worst mean, posterior sd")
    panels[0].legend()
    figure.savefig(file, dpi=120)


def main(count: int) -> None:
    """Measure, draw and write the page."""
    charts = DOCS / "charts"
    speeds = [timed(name) for name in SCENES]
    accuracy = [row for name in SCENES for row in errors(name)]
    _draw(accuracy, charts / "live.png")
    found: list[Change] = []
    with (charts / "live.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for name in SCENES:
            for change in compared(name, count // len(SCENES)):
                found.append(change)
                table.writerow(change)
                file.flush()
    wrong = [c for c in found if c.passed and c.fresh_passed and c.worst > APART]
    flagged = [c for c in found if not c.passed]
    both = [c for c in found if c.passed and c.fresh_passed]
    parts = {
        "machine": [f"- {machine()}"],
        "seconds": page.table(
            ["scene", "seconds, median", "independent draws with the same errors, least"],
            [[name, f"{seconds:.3f}", f"{draws:.0f}"] for name, seconds, draws in speeds],
        ),
        "errors": page.table(
            ["scene", "points", "number", "seconds", "error of the worst mean, sd"],
            [[n, kind, str(k), f"{s:.4f}", f"{e:.4f}"] for n, kind, k, s, e in accuracy],
        ),
        "changes": [
            f"- Of {len(found)} changed scenes {len(found) - len(flagged)} were answered, "
            f"{sum(c.refitted for c in found)} of all with coordinates fitted anew; NUTS passed its "
            f"checks in {len(both)} of the answered ones.",
            f"- Of these {len(wrong)} were off by more than {APART} standard errors in a mean or an sd; "
            f"the largest of all is {max((c.worst for c in both), default=0):.1f}.",
        ],
    }
    page.refresh(DOCS / "live.md", parts)


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else CHANGES)
