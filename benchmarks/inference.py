"""Speed against accuracy: our methods beside what a user would pick instead, on one density.

python3 -m uv run --group bench python -m benchmarks.inference [share folder]

With a share of the work (0.05, say) and a folder: a trial, which writes there only. Every method is
measured against a reference posterior that two exact methods agree on.
"""

from __future__ import annotations

import csv
import sys
import textwrap
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from arviz_stats.base import array_stats
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from benchmarks import competitors, synthetic
from benchmarks.competitors import Array, Sites
from benchmarks.integrators import machine
from retrodict import load_scene
from retrodict.inference import Unanswerable
from retrodict.inference.methods import METHODS, Draws, Task
from retrodict.inference.posterior import Posterior, prepare
from retrodict.inference.reconstruct import DEFAULT_RUNG

ROOT = Path(__file__).resolve().parents[1]
SCENES = {
    "paper": ROOT / "examples" / "brach-1977" / "scene.toml",
    "berm": ROOT / "examples" / "brach-1977-berm" / "scene.toml",
}
ASKED = ("speed_b", "e", "e_m", "mu")
STATISTICS = ("mean", "sd", "lower", "upper")  # the last two limit 95 %
CHAINS, WARMUP = 4, 150  # of our methods, as `reconstruct` has them
BUDGETS = {
    "nuts": (50, 150, 500, 1500),
    "importance": (100, 250, 750, 2500, 10_000),
    "smc": (600,),  # particles; its budgets are one, two and four runs
    "laplace": (100, 250, 600, 2500, 10_000),
    "monte-carlo": (100, 250, 600, 2500, 10_000),
    "linear": (100, 250, 600, 2500, 10_000),
}
COMPARED = {"nuts": 500, "importance": 2500, "smc": 600}  # draws in the comparison of many scenes
USABLE = 400.0  # effective draws, as the checks ask
TARGETS = (
    ("NumPyro NUTS at its defaults", (competitors.DEFAULT_NAME,), 100.0),
    ("the best plain NumPyro", (competitors.DEFAULT_NAME, competitors.DENSE_NAME), 15.0),
    ("emcee on SciPy", (competitors.SCIPY_NAME,), 1000.0),
)

Remark = tuple[str, str]  # its kind, which is where it goes in docs/inference.md; its text


class Effort(NamedTuple):
    """How much is done.

    Args:
        share: of the iterations of the competitors.
        limit: seconds of sampling for each of them.
        nuts: draws of each of four chains for the reference.
        importance: likewise, before they are weighed.
        repeats: seeds over which our errors are averaged.
        scenes: at random, in the comparison of many scenes.
        long: draws of each chain of nuts in their reference; of importance four times as many.
    """

    share: float = 1.0
    limit: float = 20.0
    nuts: int = 22_500
    importance: int = 60_000
    repeats: int = 4
    scenes: int = 8
    long: int = 5_000

    def scaled(self, share: float) -> Effort:
        """A part of it."""
        counts = [max(least, int(n * share)) for n, least in zip(self[2:], _LEAST, strict=True)]
        return Effort(share, self.limit * share, *counts)


_LEAST = (500, 500, 1, 1, 500)


class Reference(NamedTuple):
    """A posterior as well as it is known: statistics (statistic, quantity), their errors, the draws."""

    values: Array
    errors: Array
    draws: Sites


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


# --- draws, their statistics and Monte Carlo errors ---------------------------------------------


def _draw(posterior: Posterior, method: str, chains: int, draws: int, seed: int) -> Draws:
    return METHODS[method].draw(Task(posterior, chains, draws, WARMUP, seed, lambda *_: None))


def _sites(posterior: Posterior, drawn: Draws) -> Sites:
    """The unknowns at a method's draws, and what follows from them, shape (chains, draws)."""
    told = drawn.known(posterior)
    return {k: v.reshape(*drawn.w.shape[:2], *v.shape[1:]) for k, v in told.items()}


def _values(x: Sites) -> Array:
    """Mean, sd and both limits (rows) of each quantity (columns)."""
    draws = np.array([x[name].ravel() for name in ASKED])
    limits = np.quantile(draws, [0.025, 0.975], axis=1)
    return np.array([draws.mean(1), draws.std(1, ddof=1), *limits])


def _mcse(x: Sites) -> Array:
    """Monte Carlo errors of `_values`."""

    def of(draws: Array) -> list[float]:
        limits = [array_stats.mcse(draws, method="quantile", prob=p) for p in (0.025, 0.975)]
        moments = [array_stats.mcse(draws, method=method) for method in ("mean", "sd")]
        return [float(value) for value in moments + limits]

    return np.array([of(x[name]) for name in ASKED]).T


def _ess(x: Sites) -> float:
    return min(float(array_stats.ess(x[name], method="bulk")) for name in ASKED)


def _worst(off: Array) -> tuple[float, float, float]:
    """Of mean, sd and limits, from errors in sd of shape (repeats, statistic, quantity)."""
    size = np.sqrt(np.mean(off**2, axis=0)).max(axis=1)
    return float(size[0]), float(size[1]), float(size[2:].max())


# --- the reference ------------------------------------------------------------------------------


def _long_runs(posterior: Posterior, nuts: int, importance: int) -> dict[str, tuple[Sites, str]]:
    """Long runs of both methods that a reference is made of, and what is at fault with each."""
    drawn = {
        "nuts": _draw(posterior, "nuts", CHAINS, nuts, 1000),
        "importance": _draw(posterior, "importance", CHAINS, importance, 2000),
    }
    return {name: (_sites(posterior, each), _fault(each)) for name, each in drawn.items()}


def _fault(drawn: Draws) -> str:
    if "diverging" in drawn.stats and drawn.stats["diverging"].any():
        return f"{int(drawn.stats['diverging'].sum())} divergences"
    return "; ".join(drawn.faults)


def _pooled(values: Sequence[Array], errors: Sequence[Array]) -> tuple[Array, Array]:
    """The mean of several runs' statistics, and its error."""
    return np.mean(values, axis=0), np.sqrt(np.sum(np.square(errors), axis=0)) / len(errors)


def refer(posterior: Posterior, effort: Effort, scene: str) -> tuple[Reference, Remark]:
    """The posterior from long runs of nuts and importance, and how they agree."""
    long = _long_runs(posterior, effort.nuts, effort.importance)
    runs = {name: x for name, (x, _) in long.items()}
    values, errors = [_values(x) for x in runs.values()], [_mcse(x) for x in runs.values()]
    z = (values[0] - values[1]) / np.hypot(*errors)
    row, column = np.unravel_index(np.argmax(np.abs(z)), z.shape)
    both, error = _pooled(values, errors)
    largest = np.abs((values[0] - values[1]) / both[1]).max()
    ess = {name: _ess(x) for name, x in runs.items()}
    text = (
        f"{scene}: {ess['nuts']:,.0f} effective draws of nuts and {ess['importance']:,.0f} of importance"
        f" agree: the worst of {z.size} differences is {abs(z[row, column]):.1f} Monte Carlo errors"
        f" ({STATISTICS[row]} of {ASKED[column]}), {np.mean(np.abs(z) > 2):.0%} are beyond two; none"
        f" exceeds {largest:.4f} posterior sd. Reference: the mean of both."
    )
    pick = np.random.default_rng(0).permutation(runs["nuts"]["e"].size)[:500]
    spread = {k: v.reshape(-1, *v.shape[2:])[pick] for k, v in runs["nuts"].items()}
    return Reference(both, error, spread), ("reference", text)


# --- what each method costs ---------------------------------------------------------------------


def ours(posterior: Posterior, known: Reference, effort: Effort, scene: str) -> Iterator[Point]:
    """Every method of ours at its budgets, compiled, from draws to unknowns."""
    begin = time.perf_counter()
    prepare(load_scene(SCENES[scene]), DEFAULT_RUNG)
    set_up = time.perf_counter() - begin
    for method, budgets in BUDGETS.items():
        if method == "smc":
            yield from _smc(posterior, known, budgets[0], scene, set_up)
            continue
        _sites(posterior, _draw(posterior, method, CHAINS, budgets[0], 0))  # compiles
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
        drawn = _draw(posterior, method, CHAINS, draws, seed)
        x = _sites(posterior, drawn)
        taken.append(time.perf_counter() - begin)
        off.append((_values(x) - known.values) / known.values[1])
        ess.append(_ess(x))
        if "n_steps" in drawn.stats:
            evaluations = float(drawn.stats["n_steps"].sum())
        elif "evaluations" in drawn.attributes:
            evaluations = drawn.attributes["evaluations"]
    budget = f"{CHAINS} × {f'({WARMUP} + {draws})' if method == 'nuts' else draws}"
    measured = (float(np.median(taken)), float(np.median(ess)), evaluations)
    return Point(scene, method, budget, *measured, *_worst(np.array(off)))


def _smc(
    posterior: Posterior, known: Reference, particles: int, scene: str, set_up: float
) -> Iterator[Point]:
    """One, two and four runs of it, the clock read after each."""
    marks: list[float] = []
    _draw(posterior, "smc", 1, particles, 0)  # compiles
    begin = time.perf_counter()
    task = Task(
        *(posterior, CHAINS, particles, WARMUP, 1),
        lambda *_: marks.append(time.perf_counter() - begin),
    )
    x = _sites(posterior, METHODS["smc"].draw(task))
    points = []
    for runs in (1, 2, CHAINS):
        part = {name: x[name][:runs] for name in ASKED}
        off = (_values(part) - known.values) / known.values[1]
        budget = f"{runs} × {particles}"
        measured = (marks[runs - 1], _ess(part), np.nan)
        points.append(Point(scene, "smc", budget, *measured, *_worst(off[None])))
    yield from points[:-1]
    yield points[-1]._replace(listed=True, usable=_usable(points, set_up))


def _usable(points: Sequence[Point], set_up: float) -> float:
    """Seconds to enough effective draws, finding the coordinates included."""
    enough = [p for p in points if p.ess >= USABLE]
    if not enough:
        return np.nan
    seconds = np.interp(USABLE, [p.ess for p in points], [p.seconds for p in points])
    return float(seconds) + set_up


def theirs(posterior: Posterior, known: Reference, effort: Effort, scene: str) -> Iterator[Point]:
    """Every competitor, at parts of its run; what it had no time for is extrapolated."""
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
        mean, sd, limits = _worst((_values(part) - known.values)[None] / known.values[1])
        cost = (trace.warm + seconds, _ess(part), trace.evaluations * n / drawn)
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


# --- many scenes --------------------------------------------------------------------------------


class Compared(NamedTuple):
    """A method on a scene: differences from the reference, and in Monte Carlo errors of both."""

    scene: str
    method: str
    ess: float
    fault: str
    off: Array  # in sd, (statistic, quantity)
    z: Array


def compare(posterior: Posterior, known: Reference, scene: str) -> Iterator[Compared]:
    """Every method of ours beside the reference of a scene."""
    for method, entry in METHODS.items():
        chains = 2 if method == "smc" else CHAINS
        drawn = _draw(posterior, method, chains, COMPARED.get(method, 10_000), 1)
        x = _sites(posterior, drawn)
        with np.errstate(all="ignore"):
            off = _values(x) - known.values
            z = off / np.hypot(_mcse(x), known.errors) if entry.exact else np.full((4, 4), np.nan)
        yield Compared(scene, method, _ess(x), _fault(drawn), off / known.values[1], z)


def at_random(effort: Effort) -> Iterator[Compared]:
    """Crashes of `benchmarks.synthetic`, the first seeds that are answered.

    Their reference is the mean of a long run of nuts and one of importance, without one that is at
    fault by itself where the other is not.
    """
    done, seed = 0, 0
    while done < effort.scenes:
        made, _ = synthetic.scene(np.random.default_rng(seed))
        name, seed = f"synthetic {seed}", seed + 1
        try:
            posterior = prepare(made, DEFAULT_RUNG)
        except Unanswerable:
            continue
        long = [*_long_runs(posterior, effort.long, 4 * effort.long).values()]
        sound = [x for x, fault in long if not fault] or [x for x, _ in long]
        known = Reference(*_pooled([_values(x) for x in sound], [_mcse(x) for x in sound]), {})
        yield from compare(posterior, known, name)
        print(name, flush=True)
        done += 1


def agreement(rows: Sequence[Compared]) -> Iterator[Remark]:
    """Whether the exact ones are, and how far off the others."""
    for method, entry in METHODS.items():
        mine = [row for row in rows if row.method == method]
        faulty = [row.scene for row in mine if row.fault]
        told = f"; {len(faulty)} faulted by itself ({', '.join(faulty)})" if faulty else ""
        if entry.exact:
            mine = [row for row in mine if not row.fault] or mine
            z = np.abs(np.array([row.z[:2] for row in mine]))
            i = np.unravel_index(np.argmax(z), z.shape)
            yield (
                "agreement",
                f"{method}: {len(mine)} scenes, {z.size} differences of means and sds: worst"
                f" {z.max():.1f} Monte Carlo errors ({STATISTICS[i[1]]} of {ASKED[i[2]]},"
                f" {mine[i[0]].scene}), {np.mean(z > 2):.1%} beyond two (5 % by chance){told}:"
                f" {'agrees' if z.max() < 4 else 'DISAGREES'}",
            )
            continue
        off = np.abs(np.array([row.off for row in mine]))
        cells = []
        for what, part in (("mean", off[:, :1]), ("sd", off[:, 1:2]), ("limits", off[:, 2:])):
            of_scene = part.max(axis=(1, 2))
            i = np.unravel_index(np.argmax(part), part.shape)
            cells.append(
                f"{what} off by {np.median(of_scene):.2g} (median scene) and {part.max():.2g} sd"
                f" ({ASKED[i[2]]}, {mine[i[0]].scene})"
            )
        bad = int((off.max(axis=(1, 2)) > 0.2).sum())
        yield (
            "approximate",
            f"{method}: {', '.join(cells)}; more than 0.2 sd off in {bad} of {len(mine)} scenes{told}",
        )


# --- what it shows ------------------------------------------------------------------------------


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


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.4g}"


def _write(points: Sequence[Point], remarks: Sequence[Remark], file: Path) -> None:
    default = {p.scene: p.ess / p.seconds for p in points if p.listed and p.method == "nuts"}
    with file.open("w", newline="", encoding="utf-8") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(COLUMNS)
        for p in points:
            rate = p.ess / p.seconds
            numbers = [p.seconds, p.ess, rate, p.evaluations, 1e3 * p.ess / p.evaluations]
            numbers += [p.compile, p.usable, default[p.scene] / rate, p.mean, p.sd, p.limits]
            flags = ["yes" if flag else "" for flag in (p.extrapolated, p.listed)]
            table.writerow([*p[:3], *map(_number, numbers), *flags, p.note])
        out.writelines(f"# {kind}: {text}\n" for kind, text in remarks)


def _write_compared(rows: Sequence[Compared], remarks: Sequence[Remark], file: Path) -> None:
    with file.open("w", newline="", encoding="utf-8") as out:
        table = csv.writer(out, lineterminator="\n")
        columns = [f"{what}_{s}" for what in ("error_sd", "z") for s in STATISTICS]
        table.writerow(["scene", "method", "quantity", "ess", *columns, "fault"])
        for row in rows:
            for i, name in enumerate(ASKED):
                numbers = [row.ess, *row.off[:, i], *row.z[:, i]]
                table.writerow([row.scene, row.method, name, *map(_number, numbers), row.fault])
        out.writelines(f"# {kind}: {text}\n" for kind, text in remarks)


LOOKS = {
    "nuts": ("#000000", "*"),
    "importance": ("#0072B2", "o"),
    "smc": ("#56B4E9", "P"),
    "laplace": ("#009E73", "^"),
    "monte-carlo": ("#E69F00", "v"),
    "linear": ("#CC79A7", "D"),
    competitors.DEFAULT_NAME: ("#D55E00", "s"),
    competitors.DENSE_NAME: ("#D55E00", "d"),
    competitors.BLACKJAX_NAME: ("#8B0000", "h"),
    competitors.EMCEE_NAME: ("#555555", "x"),
    competitors.SCIPY_NAME: ("#555555", "+"),
}


def draw(points: Sequence[Point], file: Path, below: Sequence[str]) -> None:
    """Errors of mean, sd and limits against seconds, a row a scene."""
    figure = Figure(figsize=(16, 11), layout="constrained")
    panels = figure.subplots(len(SCENES), 3, sharex=True)
    for scene, row in zip(SCENES, panels, strict=True):
        for axes, what in zip(row, ("mean", "sd", "limits"), strict=True):
            for method, (colour, marker) in LOOKS.items():
                mine = [p for p in points if (p.scene, p.method) == (scene, method)]
                for part, style in ((False, "-"), (True, "--")):
                    chosen = [p for p in mine if p.extrapolated is part]
                    if part and chosen:  # from the last that was measured
                        chosen = [p for p in mine if not p.extrapolated][-1:] + chosen
                    x, y = [p.seconds for p in chosen], [getattr(p, what) for p in chosen]
                    look: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": style}
                    face = "white" if part else colour
                    axes.plot(x, y, linewidth=1.2, markersize=6, markerfacecolor=face, **look)
            axes.set(xscale="log", yscale="log", xlabel="seconds of sampling")
            title = {"limits": "95 % limits"}.get(what, what)
            axes.set_title(f"{scene}: error of the {title}", loc="left", fontsize=10)
            axes.grid(which="major", color="#d9d9d9", linewidth=0.5)
        row[0].set_ylabel("worst of four quantities, posterior sd")
    handles = [
        Line2D([], [], color=colour, marker=marker, label=name)
        for name, (colour, marker) in LOOKS.items()
    ]
    figure.legend(handles=handles, loc="outside upper center", fontsize=9, ncols=4)
    text = "\n".join(textwrap.fill(line, 230, subsequent_indent="   ") for line in below)
    figure.supxlabel(text, fontsize=8.5, x=0.01, ha="left")
    figure.savefig(file, dpi=120)


def main(charts: Path, share: float = 1.0) -> None:
    """Measure, then write `inference.csv`, `inference.png` and `agreement.csv` into the folder.

    Args:
        charts: the folder.
        share: of the work, for a trial.
    """
    effort = Effort() if share == 1 else Effort().scaled(share)
    packages = ("jax", "numpyro", "blackjax", "emcee", "numpy", "scipy")
    remarks: list[Remark] = [("machine", machine(packages))]
    points: list[Point] = []
    rows: list[Compared] = []
    for scene, file in SCENES.items():
        posterior = prepare(load_scene(file), DEFAULT_RUNG)
        known, remark = refer(posterior, effort, scene)
        remarks.append(remark)
        print(*remark, flush=True)
        for found in (ours, theirs):
            for point in found(posterior, known, effort, scene):
                points.append(point)
                print(*point[:3], *map(_number, point[3:9]), point.note, flush=True)
        rows += compare(posterior, known, scene)
    rows += at_random(effort)
    told = list(agreement(rows))
    stopped = [p for p in points if p.listed and p.note]
    remarks += [
        *targets(points),
        *(("stopped", f"{p.scene}, {p.method}: {p.note}") for p in stopped),
    ]
    _write(points, remarks, charts / "inference.csv")
    _write_compared(rows, told, charts / "agreement.csv")
    below = [
        "Dashed, hollow: extrapolated, by draws in proportion to seconds and errors to their root. Our"
        f" errors are root mean squares over {effort.repeats} seeds, others' of one run. All compiled.",
        *(text for kind, text in remarks if kind in ("targets", "machine")),
    ]
    draw(points, charts / "inference.png", below)
    print(*(f"{kind}: {text}" for kind, text in [*remarks, *told]), sep="\n")


if __name__ == "__main__":
    if sys.argv[1:]:
        folder = Path(sys.argv[2])
        folder.mkdir(parents=True, exist_ok=True)
        main(folder, float(sys.argv[1]))
    else:
        from benchmarks import page

        main(ROOT / "docs" / "charts")
        page.refresh(ROOT / "docs" / "inference.md", page.of_inference(ROOT / "docs" / "charts"))
