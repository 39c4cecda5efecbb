"""What every method costs at its budgets, and how far off it is."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks import competitors, tables
from benchmarks.competitors import Sites
from benchmarks.inference.reference import (
    ASKED,
    CHAINS,
    WARMUP,
    Effort,
    Posteriors,
    Reference,
    drawn_by,
    least_ess,
    sites_of,
    statistics_of,
    worst,
)
from benchmarks.tables import Remark
from retrodict import load_scene
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.plan import ways
from retrodict.inference.samplers import METHODS
from retrodict.options import DEFAULT_RUNG

ROOT = Path(__file__).resolve().parents[2]
SCENES = {
    "paper": ROOT / "examples" / "brach-1977" / "scene.toml",
    "berm": ROOT / "examples" / "brach-1977-berm" / "scene.toml",
}
BUDGETS = {
    "nuts": (50, 150, METHODS["nuts"].draws, 2100),
    "importance": (100, 250, METHODS["importance"].draws, 2500, 10_000),
    "smc": (128, 256, METHODS["smc"].draws),
    "laplace": (100, 250, 600, 2500, 10_000),
    "monte-carlo": (100, 250, 600, 2500, 10_000),
    "linear": (100, 250, 600, 2500, 10_000),
}
USABLE = 400.0  # effective draws, as the checks ask
TARGETS = (
    ("NumPyro NUTS at its defaults", (competitors.DEFAULT_NAME,), 100.0),
    ("the best plain NumPyro", (competitors.DEFAULT_NAME, competitors.DENSE_NAME), 15.0),
    ("emcee on SciPy", (competitors.SCIPY_NAME,), 1000.0),
)


class Point(NamedTuple):
    """A method with a budget: what it costs and how far off it is, worst of the quantities, in sd."""

    scene: str
    method: str
    budget: str
    seconds: float
    ess: float  # least bulk of the quantities; of an approximation, of its own draws
    evaluations: float  # of gradient or density, for the draws kept
    mean: float
    sd: float
    limits: float
    extrapolated: bool = False
    listed: bool = False  # whether it stands in the page's table
    compile: float = np.nan
    usable: float = np.nan  # seconds to USABLE effective draws
    note: str = ""


def ours(posteriors: Posteriors, known: Reference, effort: Effort, scene: str) -> Iterator[Point]:
    """Every method of ours at its budgets, compiled, from draws to unknowns."""
    read = load_scene(SCENES[scene])
    for method, budgets in BUDGETS.items():
        begin = time.perf_counter()
        prepare(read, DEFAULT_RUNG, ways(method, read)[0].coordinates)
        set_up = time.perf_counter() - begin
        posterior = posteriors[method]
        sites_of(posterior, drawn_by(posterior, method, budgets[0], 0))  # compiles
        points = [_mine(posterior, known, effort, scene, method, n) for n in budgets]
        usable = _usable(points, set_up)
        default = METHODS[method].draws
        for point, n in zip(points, budgets, strict=True):
            listed = n == default
            yield point._replace(listed=listed, usable=usable if listed else np.nan)


def _mine(
    posterior: Posterior, known: Reference, effort: Effort, scene: str, method: str, draws: int
) -> Point:
    """A method of ours with so many draws a chain, over several seeds."""
    off, ess, taken, evaluations = [], [], [], np.nan
    for seed in range(effort.repeats):
        begin = time.perf_counter()
        drawn = drawn_by(posterior, method, draws, seed)
        x = sites_of(posterior, drawn)
        taken.append(time.perf_counter() - begin)
        off.append((statistics_of(x) - known.values) / known.values[1])
        ess.append(least_ess(x))
        if "n_steps" in drawn.stats:
            evaluations = float(drawn.stats["n_steps"].sum())
        elif "evaluations" in drawn.attributes:
            evaluations = drawn.attributes["evaluations"]
    budget = f"{CHAINS} × {f'({WARMUP} + {draws})' if method == 'nuts' else draws}"
    measured = (float(np.median(taken)), float(np.median(ess)), evaluations)
    return Point(scene, method, budget, *measured, *worst(np.array(off)))


def _usable(points: Sequence[Point], set_up: float) -> float:
    """Seconds to enough effective draws, finding the coordinates included."""
    enough = [p for p in points if p.ess >= USABLE]
    if not enough:
        return np.nan
    seconds = np.interp(USABLE, [p.ess for p in points], [p.seconds for p in points])
    return float(seconds) + set_up


def theirs(posteriors: Posteriors, known: Reference, effort: Effort, scene: str) -> Iterator[Point]:
    """Every competitor, at parts of its run; what it had no time for is extrapolated."""
    posterior = posteriors["nuts"]
    forward = competitors.Forward(posterior.programs.structure, posterior.data, known.draws)
    for trace in competitors.traces(forward, effort.limit, effort.share):
        yield from _points(trace, forward.sites(trace.u), known, scene)


def _points(trace: competitors.Trace, x: Sites, known: Reference, scene: str) -> Iterator[Point]:
    chains, drawn = trace.u.shape[:2]
    count = len(trace.taken)
    marks = {n: s for k in (8, 4, 2, 1) for s, n in [trace.taken[max(count // k, 1) - 1]]}
    points = []
    for n, seconds in marks.items():
        part = {name: x[name][:, :n] for name in ASKED}
        mean, sd, limits = worst((statistics_of(part) - known.values)[None] / known.values[1])
        cost = (trace.warm + seconds, least_ess(part), trace.evaluations * n / drawn)
        guessed = trace.name == competitors.SCIPY_NAME
        points.append(Point(scene, trace.name, f"{chains} × {n}", *cost, mean, sd, limits, guessed))
    last, times = points[-1], trace.whole / drawn
    drawing = (last.seconds - trace.warm) * times
    if times > 1:  # as draws grow in number, so do time and effective draws; errors by their root
        more = last._replace(
            budget=f"{chains} × {trace.whole}",
            seconds=trace.warm + drawing,
            ess=last.ess * times,
            evaluations=last.evaluations * times,
            mean=last.mean / times**0.5,
            sd=last.sd / times**0.5,
            limits=last.limits / times**0.5,
            extrapolated=True,
        )
        points.append(more)
    last = points.pop()
    yield from points
    usable = trace.warm + drawing * USABLE / last.ess
    yield last._replace(listed=True, compile=trace.compile, usable=usable, note=trace.note)


def targets(points: Sequence[Point]) -> Iterator[Remark]:
    """How many times our default's effective draws a second, beside what was asked."""
    listed = [p for p in points if p.listed]
    for scene in SCENES:
        rate = {p.method: p.ess / p.seconds for p in listed if p.scene == scene}
        for what, methods, asked in TARGETS:
            times = rate["nuts"] / max(rate[m] for m in methods)
            met = "met" if times >= asked else "MISSED"
            yield "targets", f"{scene}: {times:,.0f} times {what} (asked: {asked:,.0f}): {met}"
            if times < asked:
                yield "why", f"{scene}, {what}: {_reason(listed, scene, methods)}"


def _reason(listed: Sequence[Point], scene: str, methods: Sequence[str]) -> str:
    """Where the ratio comes from: evaluations for an effective draw, and what one costs."""
    by_name = {p.method: p for p in listed if p.scene == scene}
    mine = by_name["nuts"]
    other = max((by_name[m] for m in methods), key=lambda p: p.ess / p.seconds)
    return (
        f"{other.evaluations / other.ess:.0f} evaluations for an effective draw against"
        f" {mine.evaluations / mine.ess:.1f}; warm-up included, {other.seconds / other.ess * 1e3:.1f} ms"
        f" against {mine.seconds / mine.ess * 1e3:.2f}"
    )


COLUMNS = (
    *("scene", "method", "budget", "seconds", "ess", "ess_per_second", "evaluations"),
    *("ess_per_1000_evaluations", "compile_seconds", "seconds_to_ess_400", "nuts_is_times_faster"),
    *("error_mean_sd", "error_sd_sd", "error_limits_sd", "extrapolated", "listed", "note"),
)


def write(points: Sequence[Point], remarks: Sequence[Remark], file: Path) -> None:
    """Write `inference.csv`."""
    default = {p.scene: p.ess / p.seconds for p in points if p.listed and p.method == "nuts"}
    rows = []
    for p in points:
        rate = p.ess / p.seconds
        numbers = [p.seconds, p.ess, rate, p.evaluations, 1e3 * p.ess / p.evaluations]
        numbers += [p.compile, p.usable, default[p.scene] / rate, p.mean, p.sd, p.limits]
        flags = ["yes" if flag else "" for flag in (p.extrapolated, p.listed)]
        rows.append([*p[:3], *numbers, *flags, p.note])
    tables.write(file, COLUMNS, rows, remarks)
