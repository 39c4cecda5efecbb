"""Errors of each method against the reference, and what a scene costs it."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import numpy as np

from benchmarks.integrators.rows import Row
from benchmarks.integrators.solvers import (
    BATCH,
    FEWER,
    Method,
    as_jax,
    compiled,
    last_in_time,
    repeated,
    take,
)
from tests.shared import reference
from tests.shared.reference import Scene

SINGLE = 20  # scenes that are timed one by one
SCIPY_EVERY = 10  # of the scenes are run by solve_ivp
SCIPY = (("RK45", 1e-4), ("RK45", 1e-6), ("DOP853", 1e-6), ("DOP853", 1e-8))


def measure(
    method: Method, sets: dict[str, np.ndarray], of: Sequence[Scene], truth: np.ndarray
) -> Iterator[Row]:
    """One row a set; each is repeated to `BATCH` scenes, so one program serves all."""
    single, batched, derivative = compiled(method.solve, method.in_turn, method.reverse)
    every = as_jax(of)
    whole = (*repeated(every, np.arange(len(of)), BATCH), method.tolerance)
    poses, counts = (np.asarray(v)[: len(of)] for v in batched(*whole))
    if method.twin is not None:
        counts = np.asarray(compiled(method.twin, method.in_turn).batched(*whole)[1])[: len(of)]
    position, heading = _errors(poses, truth)
    jax.block_until_ready(single(*take(every, 0), method.tolerance))
    every_nth = 1 if method.fixed else FEWER
    for name, index in sets.items():
        args = (*repeated(every, index, BATCH), method.tolerance)
        part = (*take(args[:3], slice(None, None, every_nth)), method.tolerance)
        some = [(*take(every, i), method.tolerance) for i in index[:: len(index) // SINGLE or 1]]
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


def by_scipy(sets: dict[str, np.ndarray], of: Sequence[Scene], truth: np.ndarray) -> Iterator[Row]:
    """What one would write first: solve_ivp over time, with an event, on some of the scenes.

    Its right-hand side is in NumPy; the same in plain numbers is timed besides.
    """
    chosen = np.arange(0, len(of), SCIPY_EVERY)
    for method, rtol in SCIPY:
        last = float(last_in_time(rtol))
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
