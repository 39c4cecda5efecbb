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

NUMBER = 500  # scenes with locked wheels
ROLLING = 100  # scenes with rolling ones
BATCH = 1000  # the scenes, repeated
FIXED = (64, 128, 256, 512, 1024)
INFERENCE = 64  # about the steps that inference begins with, 48
DEFAULT = "rest (W, Dopri8), in turn"
LAST = 1e-5  # of W: from here to rest in closed form, as after adaptive steps in retrodict
SLOWLY = 0.01  # m/s: below this W, regularised friction fades
SINGLE = 20  # scenes that are timed one by one
FEWER = 10  # adaptive Jacobians take long: every tenth scene makes their batch
SCIPY_EVERY = 10  # of the scenes are run by solve_ivp
SCIPY = (("RK45", 1e-4), ("RK45", 1e-6), ("DOP853", 1e-6), ("DOP853", 1e-8))
TURNS, LENGTH = 2.0, 40.0  # an ordinary run-out has fewer turns and a shorter path, m
AWAY = 0.3  # m: a wheel that rests nearer to an edge is at a kink
GRADIENTS = 50
SHORTEST = 20  # rolling scenes whose derivatives are compared
GRADIENT_STEPS = 512
POSITION, HEADING, WORST = 1.0, 0.01, 50.0  # targets: mm, degrees, mm
BATCHED, JACOBIAN, FASTER = 20.0, 5.0, 500.0  # targets: µs, times, times

# start, car, ground, tolerance -> pose, evaluations of the slope
Solve = Callable[[Any, Any, Any, Any], tuple[Any, Any]]
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
        twin: takes the same steps, and counts them.
        aside: off the frontier: its Jacobian is not timed.
    """

    name: str
    setting: str
    solve: Solve
    tolerance: float = 0.0
    mark: str = ""
    in_turn: bool = False
    fixed: bool = False
    reverse: bool = False
    twin: Solve | None = None
    aside: bool = False


class Row(NamedTuple):
    """A method on a set of scenes: errors of each, cost of one on average, in µs."""

    scenes: str
    method: str
    setting: str
    mark: str
    of: np.ndarray  # indices of the scenes
    position: np.ndarray  # mm
    heading: np.ndarray  # degrees
    evaluations: float  # of the slope, on average
    batched: float
    threads: float  # a batch in each of two threads
    single: float
    jacobian: float
    plain: float = np.nan  # SciPy's `single` with a right-hand side in plain numbers


# --- the methods --------------------------------------------------------------------------------


def _rest(start: Any, car: Car, ground: Ground, _: Any) -> tuple[Any, Any]:
    return rest(start[:3], start[3:], car, ground), jnp.nan


@functools.cache
def _steps(steps: int) -> Solve:
    def solve(start: Any, car: Car, ground: Ground, _: Any) -> tuple[Any, Any]:
        return rest(start[:3], start[3:], car, ground, steps), jnp.asarray(4.0 * steps)

    return solve


def _slope(car: Car, ground: Ground) -> Callable[[Any], Any]:
    """d(pose, velocity, time)/dW of one array."""
    rate = slope(car, ground)
    return lambda y: jnp.stack(rate((*y[:6], jnp.zeros(()))))


def _speed(car: Car, y: Any) -> Any:
    return jnp.sqrt(y[3] ** 2 + y[4] ** 2 + car.k2 * y[5] ** 2)


def _halt(y: Any, W: Any, rate: Any) -> Any:
    """The rest pose when W is left and the state changes at this rate with W."""
    return y[:3] - W * rate[:3] / 2


def _last_in_time(tolerance: Any) -> Any:
    """Share of W at which a clock of time stops: where its tolerance can still tell W from none."""
    return jnp.clip(10 * tolerance, LAST, 1e-3)


@functools.cache
def _on_w(solver: type[diffrax.AbstractERK]) -> Solve:
    """Adaptive, over the share of W that is lost: the end is known."""

    def solve(start: Any, car: Car, ground: Ground, tolerance: Any) -> tuple[Any, Any]:
        slope, W_0 = _slope(car, ground), _speed(car, start)
        term = diffrax.ODETerm(lambda s, y, args: -W_0 * slope(y)[:6])
        y, evaluations = _diffrax(term, solver, 1 - LAST, start, tolerance, W_0, None)
        return _halt(y, LAST * W_0, slope(y)), evaluations

    return solve


@functools.cache
def _on_time(solver: type[diffrax.AbstractERK], regularised: bool) -> Solve:
    """Adaptive, over time: an event ends it.

    Regularised, friction fades with W below `SLOWLY`: the end is no kink, and where exactly the
    event strikes does not matter, but the last of the way is crept.
    """

    def solve(start: Any, car: Car, ground: Ground, tolerance: Any) -> tuple[Any, Any]:
        slope, W_0 = _slope(car, ground), _speed(car, start)

        def field(t: Any, y: Any, args: Any) -> Any:
            rate = slope(y)
            rate = rate[:6] / rate[6]
            if not regularised:
                return rate
            W = _speed(car, y)
            return jnp.concatenate([rate[:3], rate[3:] * W / jnp.hypot(W, SLOWLY)])

        def left(t: Any, y: Any, args: Any, **_: Any) -> Any:
            W = _speed(car, y)
            return W - 0.01 * SLOWLY if regularised else W / W_0 - _last_in_time(tolerance)

        finder = None if regularised else optimistix.Newton(1e-10, 1e-10)
        event, term = diffrax.Event(left, finder), diffrax.ODETerm(field)
        y, evaluations = _diffrax(term, solver, jnp.inf, start, tolerance, W_0, event)
        return y[:3] if regularised else _halt(y, _speed(car, y), slope(y)), evaluations

    return solve


def _diffrax(
    term: Any,
    solver: type[diffrax.AbstractERK],
    end: Any,
    start: Any,
    tolerance: Any,
    W_0: Any,
    event: Any,
) -> tuple[Any, Any]:
    solution = diffrax.diffeqsolve(
        term,
        solver(),
        0.0,
        end,
        1e-3,
        start,
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=0.1 * tolerance * W_0),
        adjoint=diffrax.ForwardMode(),
        event=event,
        max_steps=50_000,
        throw=False,
    )
    a_step = solver.tableau.num_stages - solver.tableau.fsal
    return solution.ys[-1], 1.0 * a_step * solution.stats["num_steps"]


def _methods() -> Iterator[Method]:
    """All that are compared, but for SciPy's."""
    tsit5, dopri8 = _on_w(diffrax.Tsit5), _on_w(diffrax.Dopri8)
    mark = "default of rest"
    yield Method(DEFAULT, "1e-09", _rest, 1e-9, mark, in_turn=True, reverse=True, twin=dopri8)
    for steps in FIXED:
        mark = "about what inference begins with" if steps == INFERENCE else ""
        yield Method("W, RK4", f"{steps} steps", _steps(steps), 0.0, mark, fixed=True)
    steps = FIXED[-2]
    yield Method("W, RK4, in turn", f"{steps} steps", _steps(steps), in_turn=True, aside=True)
    event, faded = (_on_time(diffrax.Tsit5, regularised) for regularised in (False, True))
    adaptive: tuple[tuple[str, Solve, tuple[float, ...], bool, bool], ...] = (
        ("W, Tsit5", tsit5, (1e-6,), False, True),
        ("W, Tsit5, in turn", tsit5, (1e-4, 1e-6, 1e-8), True, False),
        ("W, Dopri8, in turn", dopri8, (1e-6, 1e-7), True, False),
        ("time, Tsit5, event, in turn", event, (1e-4, 1e-6, 1e-8), True, False),
        ("time, Tsit5, regularised, in turn", faded, (1e-6,), True, True),
    )
    for name, solve, tolerances, in_turn, aside in adaptive:
        for tolerance in tolerances:
            yield Method(name, f"{tolerance:.0e}", solve, tolerance, in_turn=in_turn, aside=aside)


class Programs(NamedTuple):
    """Singly, batched, and batched with d(rest)/d(start pose, start velocity)."""

    single: Any
    batched: Any
    jacobian: Any


@functools.cache
def _programs(solve: Solve, in_turn: bool = False, reverse: bool = False) -> Programs:
    def over_scenes(function: Any) -> Any:
        if not in_turn:
            return jax.jit(jax.vmap(function, (0, 0, 0, None)))
        return jax.jit(lambda *a: jax.lax.map(lambda scene: function(*scene, a[3]), a[:3]))

    jacobian = (jax.jacrev if reverse else jax.jacfwd)(solve, has_aux=True)
    return Programs(jax.jit(solve), over_scenes(solve), over_scenes(jacobian))


def poses_and_jacobians(of: Sequence[Scene], steps: int | None) -> tuple[np.ndarray, np.ndarray]:
    """Rest poses and Jacobians of up to a hundred scenes by `rest`, by the programs that are timed."""
    programs = _programs(_rest, True, True) if steps is None else _programs(_steps(steps))
    sizes = (BATCH, BATCH // FEWER if steps is None else BATCH)
    every = _as_jax(of)
    poses, jacobians = (
        np.asarray(program(*_repeated(every, np.arange(len(of)), size), 0.0)[0])[: len(of)]
        for program, size in zip((programs.batched, programs.jacobian), sizes, strict=True)
    )
    return poses, jacobians


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


def _repeated(tree: Any, index: np.ndarray, size: int) -> Any:
    """So many scenes, those of the index again and again: one program serves all sets."""
    return _take(tree, np.resize(index, size))


def _seconds(call: Callable[[], Any], most: float = 1.0) -> float:
    """The median of up to seven runs, for about `most` seconds; to be called once before."""
    taken: list[float] = []
    while len(taken) < 7 and sum(taken) < most:
        begin = time.perf_counter()
        jax.block_until_ready(call())
        taken.append(time.perf_counter() - begin)
    return float(np.median(taken))


def _two_threads(pool: ThreadPoolExecutor, call: Callable[[], Any]) -> Callable[[], Any]:
    """Runs it twice at once."""
    return lambda: list(pool.map(lambda _: jax.block_until_ready(call()), range(2)))


def _errors(poses: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    off = np.nan_to_num(poses - truth, nan=np.inf)
    return np.hypot(off[:, 0], off[:, 1]) * 1e3, np.degrees(np.abs(off[:, 2]))


def _measure(
    method: Method, sets: dict[str, np.ndarray], of: Sequence[Scene], truth: np.ndarray
) -> Iterator[Row]:
    """One row a set; each is repeated to `BATCH` scenes, so one program serves all."""
    single, batched, derivative = _programs(method.solve, method.in_turn, method.reverse)
    every = _as_jax(of)
    whole = (*_repeated(every, np.arange(len(of)), BATCH), method.tolerance)
    poses, counts = (np.asarray(v)[: len(of)] for v in batched(*whole))
    if method.twin is not None:
        counts = np.asarray(_programs(method.twin, method.in_turn).batched(*whole)[1])[: len(of)]
    position, heading = _errors(poses, truth)
    jax.block_until_ready(single(*_take(every, 0), method.tolerance))
    every_nth = 1 if method.fixed else FEWER
    for name, index in sets.items():
        args = (*_repeated(every, index, BATCH), method.tolerance)
        part = (*_take(args[:3], slice(None, None, every_nth)), method.tolerance)
        some = [(*_take(every, i), method.tolerance) for i in index[:: len(index) // SINGLE or 1]]
        threads = jacobian = np.nan
        if method.mark or method.fixed:
            with ThreadPoolExecutor(2) as pool:
                both = _two_threads(pool, functools.partial(batched, *args))
                threads = _seconds(both) / BATCH / 2 * 1e6
        if not method.aside:
            jax.block_until_ready(derivative(*part))
            taken = _seconds(functools.partial(derivative, *part))
            jacobian = taken / len(part[0]) * 1e6
        yield Row(
            name,
            method.name,
            method.setting,
            method.mark,
            index,
            position[index],
            heading[index],
            float(counts[index].mean()),
            _seconds(functools.partial(batched, *args)) / BATCH * 1e6,
            threads,
            float(np.mean([_seconds(functools.partial(single, *a), 0.05) for a in some])) * 1e6,
            jacobian,
        )


def _scipy(sets: dict[str, np.ndarray], of: Sequence[Scene], truth: np.ndarray) -> Iterator[Row]:
    """What one would write first: solve_ivp over time, with an event, on some of the scenes.

    Its right-hand side is in NumPy; the same in plain numbers is timed besides.
    """
    chosen = np.arange(0, len(of), SCIPY_EVERY)
    for method, rtol in SCIPY:
        last = float(_last_in_time(rtol))
        runs, taken = [], []
        for i in chosen:
            for first_written in (True, False):
                begin = time.perf_counter()
                runs.append(reference.solve(of[int(i)], method, rtol, last, first_written))
                taken.append(time.perf_counter() - begin)
        position, heading = _errors(np.array([pose for pose, _, _ in runs[::2]]), truth[chosen])
        counts, cost = np.array([n for _, _, n in runs[::2]]), np.reshape(taken, (-1, 2)) * 1e6
        for name, index in sets.items():
            here = np.isin(chosen, index)
            if not here.any():
                continue
            label = f"time, SciPy {method}"
            errors, single = (position[here], heading[here]), cost[here].mean(axis=0)
            costs = (np.nan, np.nan, single[0], np.nan, single[1])
            count = float(counts[here].mean())
            yield Row(name, label, f"{rtol:.0e}", "", chosen[here], *errors, count, *costs)


# --- what it shows ------------------------------------------------------------------------------

COLUMNS = (
    *("scenes", "method", "setting", "mark", "number"),
    *("position_mm_median", "position_mm_p99", "position_mm_worst"),
    *("heading_deg_median", "heading_deg_p99", "heading_deg_worst"),
    *("share_within_1mm_0.01deg", "evaluations", "us_batched", "us_batched_two_threads"),
    *("us_single", "us_batched_jacobian"),
)


def _figures(row: Row) -> list[float]:
    quantiles = [f(e) for e in (row.position, row.heading) for f in (np.median, _p99, np.max)]
    costs = (row.batched, row.threads, row.single, row.jacobian)
    return [*quantiles, _within(row), row.evaluations, *costs]


def _p99(errors: np.ndarray) -> float:
    return float(np.quantile(errors, 0.99))


def _within(row: Row) -> float:
    return float(((row.position <= POSITION) & (row.heading <= HEADING)).mean())


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.4g}"


def _judge(met: bool) -> str:
    return "met" if met else "MISSED"


def _accurate(row: Row) -> bool:
    return _within(row) >= 0.99 and bool(row.position.max() <= WORST)


def _best(row: Row) -> float:
    """µs a scene batched, in one thread or two."""
    return float(np.nanmin([row.batched, row.threads]))


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


def against_scipy(rows: Sequence[Row]) -> Iterator[str]:
    """How much faster than SciPy at no greater error on the same scenes."""
    slow = [row for row in rows if _is_scipy(row)]
    for row in slow:
        yield _faster(row, [r for r in rows if r.scenes == row.scenes and r.batched > 0])
    gain = [row.single / row.plain for row in slow]
    yield (
        "SciPy's right-hand side here is in NumPy; written wheel by wheel in plain numbers, as the"
        f" reference has it, SciPy is {min(gain):.1f} to {max(gain):.1f} times as fast, and the factors"
        " above are that much smaller"
    )


def _is_scipy(row: Row) -> bool:
    return "SciPy" in row.method


def _faster(slow: Row, mine: Sequence[Row]) -> str:
    """The cheapest that errs no more than SciPy does, on the same scenes, and why it is not enough."""

    def as_good(row: Row) -> bool:
        same = row.position[np.isin(row.of, slow.of)]
        return all(f(same) <= f(slow.position) for f in (np.median, _p99))

    begin = f"{slow.scenes}: against {slow.method} {slow.setting} ({slow.single / 1e3:.0f} ms)"
    good = [row for row in mine if as_good(row)]
    if not good:
        return f"{begin}: none errs as little: MISSED"
    best, single = min(good, key=_best), min(good, key=lambda row: row.single)
    times = slow.single / _best(best)
    text = (
        f"{begin}, at no greater median and p99 error: batched {times:.0f} times faster"
        f" ({FASTER:.0f}) by {best.method} {best.setting}; singly {slow.single / single.single:.0f}"
        f" by {single.method} {single.setting}: {_judge(times >= FASTER)}"
    )
    if times >= FASTER:
        return text
    return (
        f"{text}, for SciPy asks {slow.evaluations:.0f} slopes of"
        f" {slow.single / slow.evaluations:.0f} µs, and this {best.evaluations:.0f} of"
        f" {_best(best) / best.evaluations:.2g} µs"
    )


def reasons(rows: Sequence[Row]) -> Iterator[str]:
    """Why targets are missed, with what was measured: how many slopes, and what each costs."""
    for scenes, mine in _of(rows).items():
        marked = {row.method: row for row in mine if row.mark}
        default, fixed = marked[DEFAULT], marked["W, RK4"]
        timed = [row for row in mine if row.batched > 0]
        for text in (
            *_why_accuracy(fixed, [row for row in timed if row.method == fixed.method][-1]),
            *_why_cost(default, fixed, timed),
            *_why_jacobian(default, fixed, timed),
        ):
            yield f"{scenes}, {text}"


def _why_accuracy(fixed: Row, most: Row) -> Iterator[str]:
    if not _accurate(fixed):
        stiff = (
            "W falls slowly while slip angles settle fast, so that the clock is stiff"
            if fixed.scenes == "rolling"
            else "a step spans a large part of a turn where scenes on little friction turn dozens of"
            " times"
        )
        yield (
            f"accuracy of {fixed.setting}: {stiff}. With {most.setting}, {4 * _number_of(most)} slopes,"
            f" {_within(most):.0%} are within 1 mm and 0.01°, worst {most.position.max():.3g} mm."
            " Inference doubles its steps till the scene's measurements cannot tell."
        )


def _number_of(fixed: Row) -> int:
    return int(fixed.setting.split()[0])


def _why_cost(default: Row, fixed: Row, timed: Sequence[Row]) -> Iterator[str]:
    abreast = _best(fixed) / fixed.evaluations  # µs a slope
    if _best(fixed) > BATCHED:
        yield (
            f"cost of {fixed.setting}: {fixed.evaluations:.0f} slopes of {abreast * 1e3:.0f} ns each"
            f" are {_best(fixed):.0f} µs; the target leaves {BATCHED / fixed.evaluations * 1e3:.0f} ns."
        )
    if _best(default) <= BATCHED:
        return
    slope = _best(default) / default.evaluations
    yield (
        f"cost of rest ({_best(default):.0f} µs): {default.evaluations:.0f} slopes a scene on average,"
        f" {slope * 1e3:.0f} ns each; the target pays for {BATCHED / slope:.0f}. It runs one scene"
        " after another, since abreast all wait for the slowest, and only four wheels are left to"
        " vectorise."
    )
    accurate = [row for row in timed if _accurate(row)]
    if accurate:
        least = min(accurate, key=lambda row: row.evaluations)
        floor = least.evaluations * abreast
        yield (
            f"accuracy at this cost: the fewest slopes that met the accuracy were"
            f" {least.evaluations:.0f} a scene ({least.method} {least.setting}). Even at"
            f" {abreast * 1e3:.0f} ns each, the price abreast without waiting, they are {floor:.0f} µs"
            f" against {BATCHED:.0f}."
        )


def _why_jacobian(default: Row, fixed: Row, timed: Sequence[Row]) -> Iterator[str]:
    ratio, own = fixed.jacobian / fixed.batched, default.jacobian / default.batched
    if ratio > JACOBIAN:
        yield (
            f"Jacobian of {fixed.setting}: six directions, each {(ratio - 1) / 6:.1f} times a run"
            f" without; {JACOBIAN:.0f} times in all would leave {(JACOBIAN - 1) / 6:.1f}."
        )
    if own > JACOBIAN:
        forward = min(
            row.jacobian / row.batched for row in timed if row.method == "W, Tsit5, in turn"
        )
        yield (
            f"Jacobian of rest: {own:.0f} times a run, for three outputs in reverse; how many steps"
            " there are is not known beforehand, so that checkpoints have to be kept. The same in six"
            f" forward directions takes {forward:.1f} times at best, but could not give gradients."
        )


def gradients(groups: dict[str, Sequence[Scene]]) -> Iterator[Remark]:
    """How well automatic derivatives of `rest` agree with complex steps of the reference."""
    for name, of in groups.items():
        if not of:
            continue
        truth = reference.jacobians(of)
        for steps in (None, INFERENCE, GRADIENT_STEPS):
            _, jacobians = poses_and_jacobians(of, steps)
            error = np.abs(jacobians - truth).max((1, 2)) / np.abs(truth).max((1, 2))
            way = "rest" if steps is None else f"{steps} steps"
            yield (
                "gradients",
                f"{len(of)} {name}, {way}: relative error median"
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


def machine(packages: Sequence[str] = ("jax", "diffrax", "numpy", "scipy")) -> str:
    """Cores, processor, and versions of Python and packages."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model = next(line.split(":")[1].strip() for line in lines if "model name" in line)
    except (OSError, StopIteration):
        model = platform.machine()
    versions = ", ".join(f"{name} {version(name)}" for name in packages)
    return f"{os.cpu_count()} cores, {model}, Python {platform.python_version()}, {versions}"


# --- the chart ----------------------------------------------------------------------------------

LOOKS = {
    DEFAULT: ("#000000", "*"),
    "W, RK4": ("#0072B2", "o"),
    "W, RK4, in turn": ("#56B4E9", "P"),
    "W, Tsit5": ("#D55E00", "s"),
    "W, Tsit5, in turn": ("#E69F00", "v"),
    "W, Dopri8, in turn": ("#009E73", "^"),
    "time, Tsit5, event, in turn": ("#CC79A7", "D"),
    "time, Tsit5, regularised, in turn": ("#882255", "d"),
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
    _write(rows, remarks, charts / "integrators.csv")
    missed = [*why, *(text for text in compared if "MISSED" in text)]
    below = ["Targets that are missed, and why:", *(f"– {text}" for text in missed)]
    draw(rows, charts / "integrators.png", [*below, remarks[0][1]])
    print(*(f"{kind}: {text}" for kind, text in remarks), sep="\n")
