"""Which clock, which solver, how many steps: error of the rest pose against what it costs.

Every method starts from the same scenes, with the friction of `retrodict.mechanics` (smoothed over
a contact patch, not by a fixed speed), and is measured against `benchmarks.reference`.
"""

from __future__ import annotations

import csv
import functools
import os
import platform
import textwrap
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from benchmarks import reference
from benchmarks.reference import Scene
from retrodict.mechanics import Car, Ground, Wheels, Zone, rest
from retrodict.mechanics.runout import slope

NUMBER = 600  # scenes with locked wheels
ROLLING = 100  # scenes with rolling ones
BATCH = 1000  # the scenes, repeated
FIXED = (24, 32, 48, 64, 96, 192, 384, 768)
IN_TURN = (384,)
INFERENCE = 64  # steps that inference begins with
DEFAULT = "rest (W, Dopri8), in turn"
LAST = 1e-3  # of W: from here to rest in closed form, as in retrodict
SINGLE = 20  # scenes that are timed one by one
FEWER = 10  # adaptive Jacobians take long: every tenth scene makes their batch
SCIPY_EVERY = 5  # of the scenes are run by solve_ivp
SCIPY = (("RK45", 1e-4), ("RK45", 1e-6), ("DOP853", 1e-6), ("DOP853", 1e-8))
TURNS, LENGTH = 2.0, 40.0  # an ordinary run-out has fewer turns and a shorter path, m
AWAY = 0.3  # m: a wheel that rests nearer to an edge is at a kink
GRADIENTS = 50
GRADIENT_STEPS = 384
POSITION, HEADING, WORST = 1.0, 0.01, 50.0  # targets: mm, degrees, mm
BATCHED, JACOBIAN, FASTER = 20.0, 5.0, 500.0  # targets: µs, times, times

Solve = Callable[[Any, Any, Any, Any], Any]  # start, car, ground, tolerance -> pose
Remark = tuple[str, str]  # its kind, which is where it goes in docs/run-out.md; its text


class Method(NamedTuple):
    """A way to rest.

    Args:
        name: clock and solver.
        setting: steps or tolerance, to be read.
        solve: the pose at rest.
        tolerance: what `solve` takes as its last argument.
        mark: what it is the default of.
        in_turn: whether a batch is one scene after another in one program, and not abreast.
        fixed: whether its steps are.
        reverse: whether its derivatives are in reverse mode.
        halved: whether it is also timed with half the batch in each of two threads.
    """

    name: str
    setting: str
    solve: Solve
    tolerance: float = 0.0
    mark: str = ""
    in_turn: bool = False
    fixed: bool = False
    reverse: bool = False
    halved: bool = False


class Row(NamedTuple):
    """A method on a set of scenes: errors of each, cost of one in µs."""

    scenes: str
    method: str
    setting: str
    mark: str
    of: np.ndarray  # indices of the scenes
    position: np.ndarray  # mm
    heading: np.ndarray  # degrees
    batched: float
    halved: float  # batched, half of it in each of two threads
    single: float
    jacobian: float


# --- the methods --------------------------------------------------------------------------------


def _rest(start: Any, car: Car, ground: Ground, _: Any) -> Any:
    return rest(start[:3], start[3:], car, ground)


@functools.cache
def _steps(steps: int) -> Solve:
    return lambda start, car, ground, _: rest(start[:3], start[3:], car, ground, steps)


def _slope(car: Car, ground: Ground) -> Callable[[Any], Any]:
    """d(pose, velocity, time)/dW of one array."""
    rate = slope(car, ground)
    return lambda y: jnp.stack(rate((*y[:6], jnp.zeros(()))))


def _speed(car: Car, y: Any) -> Any:
    return jnp.sqrt(y[3] ** 2 + y[4] ** 2 + car.k2 * y[5] ** 2)


def _halt(y: Any, W: Any, rate: Any) -> Any:
    """The rest pose when W is left and the state changes at this rate with W."""
    return y[:3] - W * rate[:3] / 2


def _on_w(solver: diffrax.AbstractSolver) -> Solve:
    """Adaptive, over the share of W that is lost: the end is known."""

    def solve(start: Any, car: Car, ground: Ground, tolerance: Any) -> Any:
        slope, W_0 = _slope(car, ground), _speed(car, start)
        term = diffrax.ODETerm(lambda s, y, args: -W_0 * slope(y)[:6])
        y = _diffrax(term, solver, 1 - LAST, start, tolerance, W_0, None)
        return _halt(y, LAST * W_0, slope(y))

    return solve


def _on_time(solver: diffrax.AbstractSolver) -> Solve:
    """Adaptive, over time: an event, found to the root, ends it."""

    def solve(start: Any, car: Car, ground: Ground, tolerance: Any) -> Any:
        slope, W_0 = _slope(car, ground), _speed(car, start)

        def field(t: Any, y: Any, args: Any) -> Any:
            rate = slope(y)
            return rate[:6] / rate[6]

        def left(t: Any, y: Any, args: Any, **_: Any) -> Any:
            return _speed(car, y) / W_0 - LAST

        event = diffrax.Event(left, optimistix.Newton(1e-10, 1e-10))
        y = _diffrax(diffrax.ODETerm(field), solver, jnp.inf, start, tolerance, W_0, event)
        return _halt(y, _speed(car, y), slope(y))

    return solve


def _diffrax(
    term: Any, solver: Any, end: Any, start: Any, tolerance: Any, W_0: Any, event: Any
) -> Any:
    return diffrax.diffeqsolve(
        term,
        solver,
        0.0,
        end,
        1e-3,
        start,
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=0.1 * tolerance * W_0),
        adjoint=diffrax.ForwardMode(),
        event=event,
        max_steps=50_000,
        throw=False,
    ).ys[-1]


def _methods() -> Iterator[Method]:
    """All that are compared, but for SciPy's."""
    mark = "default of rest"
    yield Method(DEFAULT, "1e-09", _rest, 0.0, mark, in_turn=True, reverse=True, halved=True)
    for steps in FIXED:
        mark = "default of inference" if steps == INFERENCE else ""
        yield Method("W, RK4", f"{steps} steps", _steps(steps), 0.0, mark, fixed=True, halved=True)
    for steps in IN_TURN:
        name = "W, RK4, in turn"
        yield Method(name, f"{steps} steps", _steps(steps), in_turn=True, fixed=True, halved=True)
    tsit5 = _on_w(diffrax.Tsit5())
    adaptive: tuple[tuple[str, Solve, tuple[float, ...], bool], ...] = (
        ("W, Tsit5", tsit5, (1e-6,), False),
        ("W, Tsit5, in turn", tsit5, (1e-4, 1e-6, 1e-8), True),
        ("W, Dopri8", _on_w(diffrax.Dopri8()), (1e-6,), False),
        ("time, Tsit5, event", _on_time(diffrax.Tsit5()), (1e-4, 1e-6), False),
    )
    for name, solve, tolerances, in_turn in adaptive:
        for tolerance in tolerances:
            yield Method(name, f"{tolerance:.0e}", solve, tolerance, in_turn=in_turn)


@functools.cache
def _programs(solve: Solve, in_turn: bool = False, reverse: bool = False) -> tuple[Any, Any, Any]:
    """Singly, batched, and batched with d(rest)/d(start pose, start velocity)."""

    def over_scenes(function: Solve) -> Any:
        if not in_turn:
            return jax.jit(jax.vmap(function, (0, 0, 0, None)))
        return jax.jit(lambda *a: jax.lax.map(lambda scene: function(*scene, a[3]), a[:3]))

    jacobian = (jax.jacrev if reverse else jax.jacfwd)(solve)
    return jax.jit(solve), over_scenes(solve), over_scenes(jacobian)


# --- measuring ----------------------------------------------------------------------------------


def _as_jax(of: Sequence[Scene]) -> tuple[Any, Car, Ground]:
    """The scenes, all locked or all rolling."""
    names = [name for name, value in zip(Scene._fields, of[0], strict=True) if value is not None]
    column = {name: jnp.array([getattr(s, name) for s in of]) for name in names}
    start = jnp.concatenate([column["pose"], column["velocity"]], axis=1)
    wheels = Wheels(column["drag"], column["steer"]) if "drag" in column else None
    car = Car(*(column[name] for name in ("k2", "front_axle", "rear_axle", "track")), wheels)
    zone = Zone(column["point"][:, None], column["inward"][:, None])
    return start, car, Ground(column["coefficients"], column["speed_dependence"], zone)


def _take(tree: Any, index: Any) -> Any:
    return jax.tree.map(lambda leaf: leaf[index], tree)


def _seconds(call: Callable[[], Any], most: float = 1.0) -> float:
    """The median of up to seven runs after a first, for about `most` seconds."""
    jax.block_until_ready(call())
    taken: list[float] = []
    while len(taken) < 7 and sum(taken) < most:
        begin = time.perf_counter()
        jax.block_until_ready(call())
        taken.append(time.perf_counter() - begin)
    return float(np.median(taken))


def _halves(pool: ThreadPoolExecutor, program: Any, args: Any) -> Callable[[], Any]:
    """Runs one program twice at once, for half of the scenes each."""
    *trees, tolerance = args
    parts = [_take(tuple(trees), slice(i, None, 2)) for i in (0, 1)]
    return lambda: list(
        pool.map(lambda part: jax.block_until_ready(program(*part, tolerance)), parts)
    )


def _errors(poses: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    off = np.nan_to_num(poses - truth, nan=np.inf)
    return np.hypot(off[:, 0], off[:, 1]) * 1e3, np.degrees(np.abs(off[:, 2]))


def _measure(
    method: Method, sets: dict[str, np.ndarray], of: Sequence[Scene], truth: np.ndarray
) -> Iterator[Row]:
    """One row a set; each is repeated to `BATCH` scenes, so one program serves all."""
    single, batched, derivative = _programs(method.solve, method.in_turn, method.reverse)
    every = _as_jax(of)
    repeated = _take(every, np.resize(np.arange(len(of)), BATCH))
    errors = _errors(np.asarray(batched(*repeated, method.tolerance))[: len(of)], truth)
    for name, index in sets.items():
        args = (*_take(every, np.resize(index, BATCH)), method.tolerance)
        fewer = slice(None, None, 1 if method.fixed else FEWER)
        part = (*_take(args[:3], fewer), method.tolerance)
        some = [(*_take(every, i), method.tolerance) for i in index[:: len(index) // SINGLE or 1]]
        halved = np.nan
        if method.halved:
            with ThreadPoolExecutor(2) as pool:
                halved = _seconds(_halves(pool, batched, args)) / BATCH * 1e6
        yield Row(
            name,
            method.name,
            method.setting,
            method.mark,
            index,
            errors[0][index],
            errors[1][index],
            _seconds(functools.partial(batched, *args)) / BATCH * 1e6,
            halved,
            float(np.mean([_seconds(functools.partial(single, *a), 0.05) for a in some])) * 1e6,
            _seconds(functools.partial(derivative, *part)) / len(part[0]) * 1e6,
        )


def _scipy_one(scene: Scene, method: str, rtol: float) -> tuple[np.ndarray, float]:
    begin = time.perf_counter()
    pose, _, _ = reference.solve(scene, method, rtol, LAST)
    return pose, time.perf_counter() - begin


def _scipy(sets: dict[str, np.ndarray], of: Sequence[Scene], truth: np.ndarray) -> Iterator[Row]:
    """What one would write first: solve_ivp over time, with an event, on every fifth scene."""
    chosen = np.arange(0, len(of), SCIPY_EVERY)
    for method, rtol in SCIPY:
        found = [_scipy_one(of[int(i)], method, rtol) for i in chosen]
        poses, taken = np.array([f[0] for f in found]), np.array([f[1] for f in found])
        position, heading = _errors(poses, truth[chosen])
        for name, index in sets.items():
            here = np.isin(chosen, index)
            cost = float(taken[here].mean()) * 1e6
            label = f"time, SciPy {method}"
            errors = (position[here], heading[here])
            costs = (np.nan, np.nan, cost, np.nan)
            yield Row(name, label, f"{rtol:.0e}", "", chosen[here], *errors, *costs)


# --- what it shows ------------------------------------------------------------------------------

COLUMNS = (
    *("scenes", "method", "setting", "mark", "number"),
    *("position_mm_median", "position_mm_p99", "position_mm_worst"),
    *("heading_deg_median", "heading_deg_p99", "heading_deg_worst"),
    *("share_within_1mm_0.01deg", "us_batched", "us_batched_two_threads", "us_single"),
    "us_batched_jacobian",
)


def _figures(row: Row) -> list[float]:
    quantiles = [f(e) for e in (row.position, row.heading) for f in (np.median, _p99, np.max)]
    return [*quantiles, _within(row), row.batched, row.halved, row.single, row.jacobian]


def _p99(errors: np.ndarray) -> float:
    return float(np.quantile(errors, 0.99))


def _within(row: Row) -> float:
    return float(((row.position <= POSITION) & (row.heading <= HEADING)).mean())


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.4g}"


def _fixed(rows: Sequence[Row], scenes: str) -> list[Row]:
    return [row for row in rows if row.scenes == scenes and row.method == "W, RK4"]


def _judge(met: bool) -> str:
    return "met" if met else "MISSED"


def _accurate(row: Row) -> bool:
    return _within(row) >= 0.99 and bool(row.position.max() <= WORST)


def _best(row: Row) -> float:
    """µs a scene batched, in one thread or two."""
    return float(np.nanmin([row.batched, row.halved]))


def _of(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows by set of scenes."""
    sets = dict.fromkeys(row.scenes for row in rows)
    return {name: [row for row in rows if row.scenes == name] for name in sets}


def targets(rows: Sequence[Row]) -> Iterator[Remark]:
    """The targets of accuracy and cost, each met or missed by the defaults."""
    for scenes, mine in _of(rows).items():
        for row in mine:
            if not row.mark:
                continue
            of, ratio = f"{scenes}, {row.setting} ({row.mark})", row.jacobian / row.batched
            yield (
                "targets",
                f"{of}: {_within(row):.1%} within 1 mm and 0.01° (99 %), worst"
                f" {row.position.max():.3g} mm ({WORST:.0f}): {_judge(_accurate(row))}",
            )
            yield (
                "targets",
                f"{of}: {_best(row):.1f} µs a scene batched ({BATCHED:.0f}):"
                f" {_judge(_best(row) <= BATCHED)}; with its Jacobian {ratio:.1f} times that"
                f" ({JACOBIAN:.0f}): {_judge(ratio <= JACOBIAN)}",
            )
        reach = [row for row in mine if row.batched > 0 and _accurate(row)]
        what = "none that was tried"
        if reach:
            best = min(reach, key=_best)
            what = f"{best.method} {best.setting}, {_best(best):.0f} µs batched"
        yield "targets", f"{scenes}: cheapest that meets the accuracy: {what}"


def against_scipy(rows: Sequence[Row]) -> Iterator[Remark]:
    """How much faster than SciPy at no greater error on the same scenes."""
    for mine in _of(rows).values():
        for slow in (row for row in mine if _is_scipy(row)):
            yield "scipy", _faster(slow, [row for row in mine if row.batched > 0])


def _is_scipy(row: Row) -> bool:
    return "SciPy" in row.method


def _faster(slow: Row, mine: Sequence[Row]) -> str:
    """The cheapest that errs no more than SciPy does, on the same scenes."""

    def as_good(row: Row) -> bool:
        same = row.position[np.isin(row.of, slow.of)]
        return all(f(same) <= f(slow.position) for f in (np.median, _p99))

    begin = f"{slow.scenes}: against {slow.method} {slow.setting} ({slow.single / 1e3:.0f} ms)"
    good = [row for row in mine if as_good(row)]
    if not good:
        return f"{begin}: none errs as little: MISSED"
    best, single = min(good, key=_best), min(good, key=lambda row: row.single)
    times = slow.single / _best(best)
    return (
        f"{begin}, at no greater median and p99 error: batched {times:.0f} times faster"
        f" ({FASTER:.0f}) by {best.method} {best.setting}; singly {slow.single / single.single:.0f}"
        f" by {single.method} {single.setting}: {_judge(times >= FASTER)}"
    )


def reasons(rows: Sequence[Row]) -> Iterator[Remark]:
    """Why targets are missed, with what was measured."""
    sets = _of(rows)
    mine = sets["locked"]
    default = default_of(mine)
    fixed = next(row for row in mine if row.mark and row.method == "W, RK4")
    steps = int(fixed.setting.split()[0])
    if not _accurate(fixed):
        yield (
            "why",
            f"accuracy of {fixed.setting}: scenes on little friction turn dozens of times, over"
            " hundreds of metres; a step then spans a large part of a turn. Inference doubles its"
            " steps till the scene's measurements cannot tell; ordinary scenes need fewer.",
        )
    for row in (r for r in mine if r.mark):
        if _best(row) <= BATCHED:
            continue
        if row is fixed:
            text = (
                f"{4 * steps} slopes of {row.batched / 4 / steps * 1e3:.0f} ns each; the target"
                f" leaves {BATCHED / 4 / steps * 1e3:.0f}."
            )
        else:
            text = (
                "it takes the steps each scene needs, one scene after another, since abreast all"
                " wait for the slowest; nothing is then left to vectorise but four wheels."
            )
        yield "why", f"cost of {row.mark} ({_best(row):.0f} µs): {text}"
    ratio = fixed.jacobian / fixed.batched
    own = default.jacobian / default.batched if default else 0.0
    if ratio > JACOBIAN:
        yield (
            "why",
            f"Jacobian of {fixed.setting}: six directions, each {(ratio - 1) / 6:.1f} times a run"
            f" without; {JACOBIAN:.0f} times in all would leave {(JACOBIAN - 1) / 6:.1f}.",
        )
    if own > JACOBIAN:
        yield (
            "why",
            f"Jacobian of rest: {own:.0f} times a run, for three outputs in reverse; how many"
            " steps there are is not known beforehand, so that checkpoints have to be kept.",
        )
    rolling = next((r for r in sets.get("rolling", []) if r.method == "W, RK4" and r.mark), None)
    if rolling and not _accurate(rolling):
        most = _fixed(rows, "rolling")[-1]
        yield (
            "why",
            "rolling, fixed steps: W falls slowly while slip angles settle fast, so that the clock is"
            f" stiff; with {most.setting} {_within(most):.0%} are within 1 mm and 0.01°, and fewer steps"
            " may be unstable.",
        )
    end = default_of(sets.get("rolling", []))
    if end and not _accurate(end):
        yield (
            "why",
            "rolling, accuracy of rest: no tolerance helps, for what errs is the closed form of the"
            f" last thousandth of W (worst {end.position.max():.2g} mm, {end.heading.max():.2g}°).",
        )


def default_of(rows: Sequence[Row]) -> Row | None:
    """The row of `rest` as it comes."""
    return next((row for row in rows if row.method == DEFAULT), None)


def gradients(
    of: Sequence[Scene], known: Sequence[reference.Run], ordinary: np.ndarray
) -> Iterator[Remark]:
    """How well automatic derivatives of `rest` agree with complex steps of the reference."""
    edge = np.array([known[i].edge_distance for i in ordinary])
    groups = {
        f"no wheel at rest within {AWAY} m of an edge": ordinary[edge > AWAY][:GRADIENTS],
        "a wheel at rest on an edge": ordinary[edge < reference.TYRE_WIDTH / 2][: GRADIENTS // 2],
    }
    ways = {"rest": _programs(_rest, in_turn=True, reverse=True)} | {
        f"{steps} steps": _programs(_steps(steps)) for steps in (INFERENCE, GRADIENT_STEPS)
    }
    for name, index in groups.items():
        if not len(index):
            continue
        chosen = [of[i] for i in index]
        truth = reference.jacobians(chosen)
        for way, (_, _, derivative) in ways.items():
            found = np.asarray(derivative(*_as_jax(chosen), 0.0))
            error = np.abs(found - truth).max((1, 2)) / np.abs(truth).max((1, 2))
            yield (
                "gradients",
                f"{len(chosen)} ordinary scenes, {name}, {way}: relative error median"
                f" {np.median(error):.1e}, max {error.max():.1e}; {(error <= 1e-4).mean():.0%}"
                f" within 1e-4 (all): {_judge(error.max() <= 1e-4)}",
            )


def _turns(scene: Scene, run: reference.Run) -> float:
    return abs(float(run.rest[2] - scene.pose[2])) / (2 * np.pi)


def worst(
    row: Row, of: Sequence[Scene], known: Sequence[reference.Run], number: int = 3
) -> Iterator[Remark]:
    """The scenes of most error, and what is special about them."""
    for i in np.argsort(-row.position)[:number]:
        scene, run = of[i], known[i]
        drag = "" if scene.drag is None else f", least drag {scene.drag.min():.2f}"
        yield (
            "worst",
            f"{row.scenes} scene {i}, off by {row.position[i]:.3g} mm with {row.setting}:"
            f" {np.hypot(*scene.velocity[:2]):.1f} m/s, {scene.velocity[2]:.1f} rad/s, friction"
            f" {scene.coefficients[0]:.2f} then {scene.coefficients[1]:.2f}{drag};"
            f" {_turns(scene, run):.1f} turns over {run.length:.0f} m, {run.crossings} wheels over"
            f" the edge, {run.evaluations} right-hand sides of the reference",
        )


def machine() -> str:
    """Cores, processor and versions."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model = next(line.split(":")[1].strip() for line in lines if "model name" in line)
    except (OSError, StopIteration):
        model = platform.machine()
    packages = ("jax", "diffrax", "numpy", "scipy")
    versions = ", ".join(f"{name} {version(name)}" for name in packages)
    return f"{os.cpu_count()} cores, {model}, Python {platform.python_version()}, {versions}"


# --- the chart ----------------------------------------------------------------------------------

LOOKS = {
    DEFAULT: ("#000000", "*"),
    "W, RK4": ("#0072B2", "o"),
    "W, RK4, in turn": ("#56B4E9", "P"),
    "W, Tsit5": ("#D55E00", "s"),
    "W, Tsit5, in turn": ("#E69F00", "v"),
    "W, Dopri8": ("#009E73", "^"),
    "time, Tsit5, event": ("#CC79A7", "D"),
    "time, SciPy RK45": ("#555555", "x"),
    "time, SciPy DOP853": ("#555555", "+"),
}
Error = Callable[[np.ndarray], Any]


def _curve(axes: Axes, rows: Sequence[Row], cost: str, error: Error, linestyle: str) -> None:
    for name, (colour, marker) in LOOKS.items():
        mine = [row for row in rows if row.method == name and getattr(row, cost) > 0]
        x, y = [getattr(row, cost) for row in mine], [error(row.position) for row in mine]
        look: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": linestyle}
        if linestyle != "-":
            look["markerfacecolor"] = "white"
        axes.plot(x, y, markersize=8 if marker == "*" else 5, linewidth=1.2, **look)
    for row in rows:
        if row.mark:
            at = (getattr(row, cost), error(row.position))
            axes.plot(*at, "o", markersize=12, markerfacecolor="none", color="black")
            text = row.setting.split()[0] if row.method == "W, RK4" else "rest"
            if linestyle != ":":
                axes.annotate(text, at, (7, 5), textcoords="offset points", fontsize=9)


def draw(rows: Sequence[Row], file: Path, below: Sequence[str]) -> None:
    """Error against cost, a row a set of scenes: batched twice, then singly and with Jacobian."""
    sets = _of(rows)
    figure = Figure(figsize=(16, 3.9 * len(sets) + 2.2), layout="constrained")
    panels = figure.subplots(len(sets), 3, squeeze=False)
    for (name, mine), (left, middle, right) in zip(sets.items(), panels, strict=True):
        number = max(len(row.of) for row in mine)
        _curve(left, mine, "batched", np.median, "-")
        _curve(middle, mine, "batched", _p99, "--")
        _curve(middle, mine, "batched", np.max, ":")
        _curve(right, mine, "single", np.median, "-")
        _curve(right, mine, "jacobian", np.median, "--")
        left.set_title(f"{name} ({number} scenes), batched: median", loc="left", fontsize=10)
        middle.set_title("batched: dashed p99, dotted worst", loc="left", fontsize=10)
        right.set_title("median: solid singly, dashed with Jacobian", loc="left", fontsize=10)
        for axes in (left, middle, right):
            axes.axhline(POSITION, color="#777777", linewidth=0.8, linestyle=":")
            axes.set(xscale="log", yscale="log", xlabel="µs a scene")
            axes.grid(which="major", color="#d9d9d9", linewidth=0.5)
        for axes in (left, middle):
            axes.axvline(BATCHED, color="#777777", linewidth=0.8, linestyle=":")
        middle.axhline(WORST, color="#777777", linewidth=0.8, linestyle=":")
        left.set_ylabel("position error, mm")
    handles = [
        Line2D([], [], color=colour, marker=marker, label=name)
        for name, (colour, marker) in LOOKS.items()
    ]
    figure.legend(handles=handles, loc="outside right upper", fontsize=9, title="clock, solver")
    lines = [
        f"Circles: the defaults, of rest and of inference ({INFERENCE} steps). Dotted lines:"
        f" targets, {POSITION:.0f} mm for 99 %, {WORST:.0f} mm for the worst, {BATCHED:.0f} µs.",
        *below,
    ]
    text = "\n".join(textwrap.fill(line, 240, subsequent_indent="   ") for line in lines)
    figure.supxlabel(text, fontsize=8.5, x=0.01, ha="left")
    figure.savefig(file, dpi=120)


# --- all of it ----------------------------------------------------------------------------------


def _write(rows: Sequence[Row], remarks: Sequence[Remark], file: Path) -> None:
    with file.open("w", newline="", encoding="utf-8") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(COLUMNS)
        for row in rows:
            numbers = [_number(value) for value in _figures(row)]
            table.writerow([*row[:4], len(row.of), *numbers])
        out.writelines(f"# {kind}: {text}\n" for kind, text in remarks)


def main(charts: Path, number: int = NUMBER) -> None:
    """Measure, then write `integrators.csv` and `integrators.png` into the folder.

    Args:
        charts: the folder.
        number: of scenes with locked wheels.
    """
    of = reference.scenes(number)
    rolling = reference.rolling_scenes(ROLLING * number // NUMBER)
    known, known_rolling = reference.runs(of), reference.runs(rolling)
    turns = np.array([_turns(scene, run) for scene, run in zip(of, known, strict=True)])
    length = np.array([run.length for run in known])
    ordinary = np.flatnonzero((turns < TURNS) & (length < LENGTH))
    groups = (
        ({"locked": np.arange(number), "ordinary": ordinary}, of, known),
        ({"rolling": np.arange(len(rolling))}, rolling, known_rolling),
    )
    rows: list[Row] = []
    for sets, scenes, runs in groups:
        truth = np.array([run.rest for run in runs])
        for method in _methods():
            rows += _measure(method, sets, scenes, truth)
            print(*rows[-1][:3], [_number(value) for value in _figures(rows[-1])], flush=True)
        rows += _scipy(sets, scenes, truth)
    rows = [row for mine in _of(rows).values() for row in mine]
    last = {row.scenes: row for row in rows if row.setting == f"{FIXED[-1]} steps"}
    default = {row.scenes: row for row in rows if row.method == DEFAULT}
    crossed = np.mean([run.crossings > 0 for run in known])
    why = list(reasons(rows))
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
            f" of adaptive steps in batches of {BATCH // FEWER}",
        ),
        *targets(rows),
        *against_scipy(rows),
        *why,
        *gradients(of, known, ordinary),
        *worst(last["locked"], of, known),
        *worst(default["locked"], of, known),
        *worst(last["rolling"], rolling, known_rolling),
        *worst(default["rolling"], rolling, known_rolling),
    ]
    _write(rows, remarks, charts / "integrators.csv")
    below = ["Targets that are missed, and why:", *(f"– {text}" for _, text in why)]
    draw(rows, charts / "integrators.png", [*below, remarks[0][1]])
    print(*(f"{kind}: {text}" for kind, text in remarks), sep="\n")
