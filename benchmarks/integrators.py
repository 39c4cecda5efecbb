"""Which clock, which solver, how many steps: error of the rest pose against what it costs.

Every method starts from the same scenes, with the friction of `retrodict.mechanics` (smoothed over
a contact patch, not by a fixed speed), and is measured against `benchmarks.reference`.
"""

from __future__ import annotations

import csv
import functools
import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
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

from benchmarks import reference
from benchmarks.reference import Scene
from retrodict.mechanics import Car, Ground, Zone, rest
from retrodict.mechanics.runout import slope

NUMBER = 600  # scenes
FIXED = (24, 32, 48, 64, 96, 192, 384, 768)
IN_TURN = (64, 96, 384)
MARKED = {64: "default of inference"}
LAST = 1e-3  # of W: from here to rest in closed form, as in retrodict
SINGLE = 20  # scenes that are timed one by one
FEWER = 12  # adaptive Jacobians take long: every twelfth scene makes their batch
SCIPY_EVERY = 5  # of the scenes are run by solve_ivp
SCIPY = (("RK45", 1e-4), ("RK45", 1e-6), ("DOP853", 1e-6), ("DOP853", 1e-8))
TURNS, LENGTH = 2.0, 40.0  # an ordinary run-out has fewer turns and a shorter path, m
AWAY = 0.3  # m: a wheel that rests nearer to an edge is at a kink
GRADIENTS = 50
GRADIENT_STEPS = 384
POSITION, HEADING, WORST = 1.0, 0.01, 50.0  # targets: mm, degrees, mm
BATCHED, JACOBIAN, FASTER = 20.0, 5.0, 500.0  # targets: µs, times, times

Solve = Callable[[Any, Any, Any, Any], Any]  # start, car, ground, tolerance -> pose


class Method(NamedTuple):
    """A way to rest.

    Args:
        name: clock and solver.
        setting: steps or tolerance, to be read.
        solve: the pose at rest.
        tolerance: what `solve` takes as its last argument.
        mark: what it is the default of.
        in_turn: whether a batch is one scene after another in one program, and not abreast.
    """

    name: str
    setting: str
    solve: Solve
    tolerance: float = 0.0
    mark: str = ""
    in_turn: bool = False


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
    single: float
    jacobian: float


# --- the methods --------------------------------------------------------------------------------


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
    for steps in FIXED:
        yield Method("W, RK4", f"{steps} steps", _steps(steps), mark=MARKED.get(steps, ""))
    for steps in IN_TURN:
        yield Method("W, RK4, in turn", f"{steps} steps", _steps(steps), in_turn=True)
    tsit5 = _on_w(diffrax.Tsit5())
    adaptive: tuple[tuple[str, Solve, tuple[float, ...], bool], ...] = (
        ("W, Tsit5", tsit5, (1e-4, 1e-6), False),
        ("W, Tsit5, in turn", tsit5, (1e-4, 1e-6, 1e-8), True),
        ("W, Dopri8", _on_w(diffrax.Dopri8()), (1e-4, 1e-6), False),
        ("time, Tsit5, event", _on_time(diffrax.Tsit5()), (1e-4, 1e-6), False),
    )
    for name, solve, tolerances, in_turn in adaptive:
        for tolerance in tolerances:
            yield Method(name, f"{tolerance:.0e}", solve, tolerance, in_turn=in_turn)


@functools.cache
def _programs(solve: Solve, in_turn: bool = False) -> tuple[Any, Any, Any]:
    """Singly, batched, and batched with d(rest)/d(start pose, start velocity)."""

    def over_scenes(function: Solve) -> Any:
        if not in_turn:
            return jax.jit(jax.vmap(function, (0, 0, 0, None)))
        return jax.jit(lambda *a: jax.lax.map(lambda scene: function(*scene, a[3]), a[:3]))

    return jax.jit(solve), over_scenes(solve), over_scenes(jax.jacfwd(solve))


# --- measuring ----------------------------------------------------------------------------------


def _as_jax(of: Sequence[Scene]) -> tuple[Any, Car, Ground]:
    column = {name: jnp.array([getattr(s, name) for s in of]) for name in Scene._fields}
    start = jnp.concatenate([column["pose"], column["velocity"]], axis=1)
    car = Car(column["k2"], column["front_axle"], column["rear_axle"], column["track"])
    zone = Zone(column["point"][:, None], column["inward"][:, None])
    return start, car, Ground(column["coefficients"], column["speed_dependence"], zone)


def _take(tree: Any, index: Any) -> Any:
    return jax.tree.map(lambda leaf: leaf[index], tree)


def _seconds(call: Callable[[], Any], most: float = 1.0) -> float:
    """The median of up to seven runs after a first, at least two, for about `most` seconds."""
    jax.block_until_ready(call())
    taken: list[float] = []
    while len(taken) < 2 or (len(taken) < 7 and sum(taken) < most):
        begin = time.perf_counter()
        jax.block_until_ready(call())
        taken.append(time.perf_counter() - begin)
    return float(np.median(taken))


def _errors(poses: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    off = np.nan_to_num(poses - truth, nan=np.inf)
    return np.hypot(off[:, 0], off[:, 1]) * 1e3, np.degrees(np.abs(off[:, 2]))


def _measure(
    method: Method, sets: dict[str, np.ndarray], of: Sequence[Scene], truth: np.ndarray
) -> Iterator[Row]:
    """One row a set; each is repeated to as many scenes as there are in all, so programs serve."""
    single, batched, derivative = _programs(method.solve, method.in_turn)
    every = _as_jax(of)
    errors = _errors(np.asarray(batched(*every, method.tolerance)), truth)
    for name, index in sets.items():
        args = (*_take(every, np.resize(index, len(of))), method.tolerance)
        fewer = slice(None, None, FEWER if method.tolerance else 1)
        part = (*_take(args[:3], fewer), method.tolerance)
        some = [(*_take(every, i), method.tolerance) for i in index[:: len(index) // SINGLE]]
        yield Row(
            name,
            method.name,
            method.setting,
            method.mark,
            index,
            errors[0][index],
            errors[1][index],
            _seconds(functools.partial(batched, *args)) / len(of) * 1e6,
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
            yield Row(name, label, f"{rtol:.0e}", "", chosen[here], *errors, np.nan, cost, np.nan)


# --- what it shows ------------------------------------------------------------------------------

COLUMNS = (
    *("scenes", "method", "setting", "mark", "number"),
    *("position_mm_median", "position_mm_p99", "position_mm_worst"),
    *("heading_deg_median", "heading_deg_p99", "heading_deg_worst"),
    *("share_within_1mm_0.01deg", "us_batched", "us_single", "us_batched_jacobian"),
)


def _figures(row: Row) -> list[float]:
    quantiles = [f(e) for e in (row.position, row.heading) for f in (np.median, _p99, np.max)]
    return [*quantiles, _within(row), row.batched, row.single, row.jacobian]


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


def verdicts(rows: Sequence[Row]) -> list[str]:
    """The targets, each met or missed, on all scenes and on the ordinary ones."""
    lines = []
    for scenes in dict.fromkeys(row.scenes for row in rows):
        fixed = _fixed(rows, scenes)
        for row in fixed:
            if row.mark or row is fixed[-1]:
                ratio = row.jacobian / row.batched
                lines += [
                    f"{scenes}, {row.setting}: {_within(row):.1%} within 1 mm and 0.01 deg"
                    f" (99 %), worst {row.position.max():.3g} mm (50): {_judge(_accurate(row))}",
                    f"{scenes}, {row.setting}: {row.batched:.1f} us a scene batched (20):"
                    f" {_judge(row.batched <= BATCHED)};"
                    f" with its Jacobian {ratio:.1f} times that (5): {_judge(ratio <= JACOBIAN)}",
                ]
        reach = [r for r in rows if r.scenes == scenes and r.batched > 0 and _accurate(r)]
        if reach:
            best = min(reach, key=lambda r: r.batched)
            what = f"{best.method} {best.setting}, {best.batched:.0f} us batched"
        else:
            what = "none that was tried"
        lines.append(f"{scenes}: cheapest that meets the accuracy: {what}")
        lines += [_faster(row, fixed) for row in rows if row.scenes == scenes and _is_scipy(row)]
    return lines


def _is_scipy(row: Row) -> bool:
    return "SciPy" in row.method


def _faster(slow: Row, fixed: Sequence[Row]) -> str:
    """The fewest steps that err no more than SciPy does, on the same scenes, and their cost."""
    begin = f"{slow.scenes}: against {slow.method} {slow.setting} ({slow.single / 1e3:.0f} ms)"
    for by, of in (("median and p99", (np.median, _p99)), ("median", (np.median,))):
        for row in fixed:
            same = row.position[np.isin(row.of, slow.of)]
            if all(f(same) <= f(slow.position) for f in of):
                times = slow.single / row.batched
                return (
                    f"{begin}, at no greater {by} error with {row.setting}: {times:.0f} times"
                    f" faster batched (500), {slow.single / row.single:.0f} singly:"
                    f" {_judge(times >= FASTER and by != 'median')}"
                )
    return f"{begin}: no number of steps errs as little: MISSED"


def gradients(of: Sequence[Scene], known: Sequence[reference.Run], ordinary: Any) -> list[str]:
    """How well automatic derivatives of `rest` agree with complex steps of the reference."""
    edge = np.array([known[i].edge_distance for i in ordinary])
    groups = {
        f"no wheel at rest within {AWAY} m of an edge": ordinary[edge > AWAY][:GRADIENTS],
        "a wheel at rest on an edge": ordinary[edge < reference.TYRE_WIDTH / 2][: GRADIENTS // 2],
    }
    lines = []
    for name, index in groups.items():
        chosen = [of[i] for i in index]
        truth = reference.jacobians(chosen)
        for steps in (min(MARKED), GRADIENT_STEPS):
            _, _, derivative = _programs(_steps(steps))
            found = np.asarray(derivative(*_as_jax(chosen), 0.0))
            error = np.abs(found - truth).max((1, 2)) / np.abs(truth).max((1, 2))
            lines.append(
                f"gradients at {len(chosen)} ordinary scenes, {name}, {steps} steps: relative"
                f" error median {np.median(error):.1e}, max {error.max():.1e};"
                f" {(error <= 1e-4).mean():.0%} within 1e-4 (all): {_judge(error.max() <= 1e-4)}"
            )
    return lines


def _turns(scene: Scene, run: reference.Run) -> float:
    return abs(float(run.rest[2] - scene.pose[2])) / (2 * np.pi)


def worst(rows: Sequence[Row], of: Sequence[Scene], known: Sequence[reference.Run]) -> list[str]:
    """The five scenes of most error at the most steps, and what is special about them."""
    last = _fixed(rows, "all")[-1]
    lines = []
    for i in np.argsort(-last.position)[:5]:
        scene, run = of[i], known[i]
        lines.append(
            f"scene {i}, off by {last.position[i]:.0f} mm after {last.setting}:"
            f" {np.hypot(*scene.velocity[:2]):.1f} m/s, {scene.velocity[2]:.1f} rad/s, friction"
            f" {scene.coefficients[0]:.2f} then {scene.coefficients[1]:.2f};"
            f" {_turns(scene, run):.1f} turns over {run.length:.0f} m, {run.crossings} wheels over"
            f" the edge, {run.evaluations} right-hand sides of the reference"
        )
    return lines


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
    "W, RK4": ("#0072B2", "o"),
    "W, RK4, in turn": ("#56B4E9", "P"),
    "W, Tsit5": ("#D55E00", "s"),
    "W, Tsit5, in turn": ("#E69F00", "v"),
    "W, Dopri8": ("#009E73", "^"),
    "time, Tsit5, event": ("#CC79A7", "D"),
    "time, SciPy RK45": ("#555555", "x"),
    "time, SciPy DOP853": ("#555555", "+"),
}


def _curve(axes: Axes, rows: Sequence[Row], cost: str, error: Any, **look: Any) -> None:
    for name, (colour, marker) in LOOKS.items():
        mine = [row for row in rows if row.method == name and getattr(row, cost) > 0]
        x, y = [getattr(row, cost) for row in mine], [error(row.position) for row in mine]
        if look["linestyle"] == "--":
            look["markerfacecolor"] = "white"
        axes.plot(x, y, color=colour, marker=marker, markersize=5, linewidth=1.2, **look)


def _panel(axes: Axes, rows: Sequence[Row], curves: Any) -> None:
    for cost, error, linestyle in curves:
        _curve(axes, rows, cost, error, linestyle=linestyle)
        for row in rows:
            if row.mark:
                at = (getattr(row, cost), error(row.position))
                axes.plot(*at, "o", markersize=11, markerfacecolor="none", color="black")
                axes.annotate(row.setting.split()[0], at, (7, 5), textcoords="offset points")
    axes.axhline(POSITION, color="#777777", linewidth=0.8, linestyle=":")
    axes.set(xscale="log", yscale="log", ylabel="position error, mm")
    axes.grid(which="major", color="#d9d9d9", linewidth=0.5)


def draw(rows: Sequence[Row], file: Path, below: str) -> None:
    """Error against cost: batched on the left, singly and with Jacobian on the right."""
    sets = list(dict.fromkeys(row.scenes for row in rows))
    figure = Figure(figsize=(11, 4.2 * len(sets) + 0.8), layout="constrained")
    panels = figure.subplots(len(sets), 2, squeeze=False)
    for (left, right), name in zip(panels, sets, strict=True):
        mine = [row for row in rows if row.scenes == name]
        number = max(len(row.of) for row in mine)
        _panel(left, mine, [("batched", np.median, "-"), ("batched", _p99, "--")])
        left.axvline(BATCHED, color="#777777", linewidth=0.8, linestyle=":")
        left.set_title(f"{name} ({number} scenes), batched: solid median, dashed p99", loc="left")
        left.set_xlabel("µs a scene, all in one batch")
        _panel(right, mine, [("single", np.median, "-"), ("jacobian", np.median, "--")])
        right.set_title(f"{name}: solid singly, dashed batched with Jacobian", loc="left")
        right.set_xlabel("µs a scene; the error is the median")
    for name, (colour, marker) in LOOKS.items():
        panels[0][1].plot([], [], color=colour, marker=marker, label=name)
    panels[0][1].legend(fontsize=8, loc="upper right", title="clock, solver")
    figure.supxlabel(
        f"Circles: the defaults, 64 steps of inference and {STEPS} of rest. Dotted: targets,"
        f" 1 mm and 20 µs.\n{below}",
        fontsize=8,
    )
    figure.savefig(file, dpi=160)


# --- all of it ----------------------------------------------------------------------------------


def _write(rows: Sequence[Row], remarks: Sequence[str], file: Path) -> None:
    with file.open("w", newline="", encoding="utf-8") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(COLUMNS)
        for row in rows:
            numbers = [_number(value) for value in _figures(row)]
            table.writerow([*row[:4], len(row.of), *numbers])
        out.writelines(f"# {line}\n" for line in remarks)


def main(charts: Path) -> None:
    """Measure, then write `integrators.csv` and `integrators.png` into the folder."""
    of = reference.scenes(NUMBER)
    known = reference.runs(of)
    truth = np.array([run.rest for run in known])
    turns = np.array([_turns(scene, run) for scene, run in zip(of, known, strict=True)])
    length = np.array([run.length for run in known])
    ordinary = np.flatnonzero((turns < TURNS) & (length < LENGTH))
    sets = {"all": np.arange(NUMBER), "ordinary": ordinary}
    rows: list[Row] = []
    for method in _methods():
        rows += _measure(method, sets, of, truth)
        print(*rows[-2][1:3], [_number(value) for value in _figures(rows[-2])], flush=True)
    rows += _scipy(sets, of, truth)
    rows.sort(key=lambda row: row.scenes)
    crossed = np.mean([run.crossings > 0 for run in known])
    remarks = [
        machine(),
        f"{NUMBER} scenes, {crossed:.0%} with a wheel over the edge; ordinary are the"
        f" {len(ordinary)} of fewer than {TURNS:.0f} turns and less than {LENGTH:.0f} m",
        "friction is smoothed by a contact patch of 0.08 m (slip² = v² + (0.08 Omega)²) in all",
        "Jacobian: of the rest pose by start pose and start velocity, 3 by 6, forward mode; adaptive"
        f" ones in batches of {NUMBER // FEWER}",
        *verdicts(rows),
        *gradients(of, known, ordinary),
        *worst(rows, of, known),
    ]
    _write(rows, remarks, charts / "integrators.csv")
    draw(rows, charts / "integrators.png", remarks[0])
    print(*remarks, sep="\n")
