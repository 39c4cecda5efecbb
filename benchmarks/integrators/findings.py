"""What the measurements show: targets met and missed, and why; derivatives; the worst scenes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.integrators.rows import (
    BATCHED,
    FASTER,
    JACOBIAN,
    WORST,
    Row,
    by_set,
    p99,
)
from benchmarks.integrators.solvers import DEFAULT, INFERENCE, poses_and_jacobians
from benchmarks.tables import Remark
from tests.shared import reference
from tests.shared.reference import Scene

GRADIENT_STEPS = 512


def targets(rows: Sequence[Row]) -> Iterator[Remark]:
    """The targets of accuracy and cost, each met or missed by the defaults."""
    for scenes, mine in by_set(rows).items():
        for row in mine:
            if not row.mark:
                continue
            of, ratio = f"{scenes}, {row.setting} ({row.mark})", row.jacobian / row.batched
            yield (
                "targets",
                f"{of}: {row.share_within:.1%} within 1 mm and 0.01° (99 %), worst"
                f" {row.position.max():.3g} mm ({WORST:.0f}): {_judge(row.accurate)}",
            )
            yield (
                "targets",
                f"{of}: {row.cost:.1f} µs a scene batched ({BATCHED:.0f}):"
                f" {_judge(row.cost <= BATCHED)}; with its Jacobian {ratio:.1f} times that"
                f" ({JACOBIAN:.0f}): {_judge(ratio <= JACOBIAN)}",
            )
        reach = [row for row in mine if row.batched > 0 and row.accurate]
        what = "none that was tried"
        if reach:
            best = min(reach, key=lambda row: row.cost)
            what = f"{best.method} {best.setting}, {best.cost:.0f} µs batched"
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
        return all(f(same) <= f(slow.position) for f in (np.median, p99))

    begin = f"{slow.scenes}: against {slow.method} {slow.setting} ({slow.single / 1e3:.0f} ms)"
    good = [row for row in mine if as_good(row)]
    if not good:
        return f"{begin}: none errs as little: MISSED"
    best, single = min(good, key=lambda row: row.cost), min(good, key=lambda row: row.single)
    times = slow.single / best.cost
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
        f" {best.cost / best.evaluations:.2g} µs"
    )


def reasons(rows: Sequence[Row]) -> Iterator[str]:
    """Why targets are missed, with what was measured: how many slopes, and what each costs."""
    for scenes, mine in by_set(rows).items():
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
    if not fixed.accurate:
        stiff = (
            "W falls slowly while slip angles settle fast, so that the clock is stiff"
            if fixed.scenes == "rolling"
            else "a step spans a large part of a turn where scenes on little friction turn dozens of"
            " times"
        )
        yield (
            f"accuracy of {fixed.setting}: {stiff}. With {most.setting}, {4 * _number_of(most)} slopes,"
            f" {most.share_within:.0%} are within 1 mm and 0.01°, worst {most.position.max():.3g} mm."
            " Inference doubles its steps until the measurement errors hide the change."
        )


def _number_of(fixed: Row) -> int:
    return int(fixed.setting.split()[0])


def _why_cost(default: Row, fixed: Row, timed: Sequence[Row]) -> Iterator[str]:
    abreast = fixed.cost / fixed.evaluations  # µs a slope
    if fixed.cost > BATCHED:
        yield (
            f"cost of {fixed.setting}: {fixed.evaluations:.0f} slopes of {abreast * 1e3:.0f} ns each"
            f" are {fixed.cost:.0f} µs; the target leaves {BATCHED / fixed.evaluations * 1e3:.0f} ns."
        )
    if default.cost <= BATCHED:
        return
    slope = default.cost / default.evaluations
    yield (
        f"cost of rest ({default.cost:.0f} µs): {default.evaluations:.0f} slopes a scene on average,"
        f" {slope * 1e3:.0f} ns each; the target pays for {BATCHED / slope:.0f}. It runs one scene"
        " after another, since abreast all wait for the slowest, and only four wheels are left to"
        " vectorise."
    )
    accurate = [row for row in timed if row.accurate]
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


def turns_of(scene: Scene, run: reference.Run) -> float:
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
            f" {turns_of(scene, run):.1f} turns over {run.length:.0f} m, {run.crossings} wheels over"
            f" the edge, {run.evaluations} right-hand sides of the reference",
        )


def _judge(met: bool) -> str:
    return "met" if met else "MISSED"
