"""How the rest pose and its derivative behave across two kinks, beside complex steps of the reference.

Along a line of starting velocities, a wheel's slip vanishes during the run-out (the wheel is the
instant centre for a moment), or a wheel comes to rest just where a second surface begins.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from benchmarks import tables
from benchmarks.integrators.solvers import poses_and_jacobians
from tests.shared import reference
from tests.shared.reference import Scene

POINTS = 61
POSE = ("x", "y", "heading")
STEPS: dict[str, int | None] = {"rest": None, "64 steps": 64, "512 steps": 512}
LOOKS = {"rest": ("#009E73", "o"), "64 steps": ("#0072B2", "s"), "512 steps": ("#E69F00", "^")}
WITHIN = 1e-4  # of derivatives, relative


class Line(NamedTuple):
    """Starting velocities, and what comes near to zero along them."""

    name: str
    parameter: str  # what varies
    of: int  # which of x, y, heading at rest is shown
    by: int  # which of Vx, Vy, Omega varies
    near: str  # what `nearness` is
    scenes: list[Scene]
    nearness: Callable[[Scene], float]
    kink: tuple[float, float]  # nearness at the kink, from and to


class Curve(NamedTuple):
    """Along a line: position, m or rad, and its derivative, s or 1."""

    position: np.ndarray
    derivative: np.ndarray


def _least_slip(scene: Scene) -> float:
    """Of the left rear wheel over W, while more than a twentieth of W is left."""
    _, states, _ = reference.solve(scene, rtol=1e-8)
    arm_x, arm_y = (arm[:, 2] for arm in reference.wheels(states, scene))
    slip = np.hypot(states[:, 3] - states[:, 5] * arm_y, states[:, 4] + states[:, 5] * arm_x)
    W = reference.generalised_speed(states, scene)
    moving = W / W[0] > 0.05
    return float((slip / W)[moving].min())


def _deepest(scene: Scene) -> float:
    """How far the foremost wheel rests beyond the edge, m."""
    end, _, _ = reference.solve(scene, rtol=1e-10)
    return float(reference.depth(end, scene).max())


def lines(points: int = POINTS) -> list[Line]:
    """Both lines; the kink is near the middle."""
    turning = [
        reference.CAR._replace(velocity=np.array([3.0, v, 4.0]))
        for v in np.linspace(5.6, 6.4, points)
    ]
    edge = np.array([6.0, 0.0])
    touching = [
        reference.CAR._replace(velocity=np.array([v, 1.0, 2.0]), point=edge)
        for v in np.linspace(7.7, 8.3, points)
    ]
    half = reference.TYRE_WIDTH / 2
    return [
        Line(
            "a wheel's slip vanishes",
            "starting Vy, m/s",
            *(1, 1, "the left rear wheel's least slip over W", turning, _least_slip),
            (0.0, 0.01),
        ),
        Line(
            "a wheel at rest touches an edge",
            "starting Vx, m/s",
            *(0, 0, "the foremost wheel's way beyond the edge, m", touching, _deepest),
            (-half, half),
        ),
    ]


def _curve(line: Line, steps: int | None) -> Curve:
    """As `rest` has it: adaptive steps have derivatives in reverse only, fixed ones both ways."""
    poses, jacobians = poses_and_jacobians(line.scenes, steps)
    return Curve(poses[:, line.of], jacobians[:, line.of, 3 + line.by])


def _truth(line: Line) -> Curve:
    runs, slopes = reference.runs(line.scenes), reference.jacobians(line.scenes)
    return Curve(np.array([run.rest[line.of] for run in runs]), slopes[:, line.of, 3 + line.by])


def _error(curve: Curve, truth: Curve) -> np.ndarray:
    """Of the derivative, relative to the largest on the line."""
    return np.abs(curve.derivative - truth.derivative) / np.abs(truth.derivative).max()


def _remarks(line: Line, near: np.ndarray, truth: Curve, curves: dict[str, Curve]) -> list[str]:
    at = (near >= line.kink[0]) & (near <= line.kink[1])
    found = []
    for name, curve in curves.items():
        error, away = _error(curve, truth), np.abs(curve.position - truth.position).max() * 1e3
        found.append(
            f"{line.name}, {name}: derivative off by {error[at].max():.1e} at most at the kink and"
            f" {error[~at].max():.1e} beside it, relative ({(error <= WITHIN).mean():.0%} within"
            f" {WITHIN:.0e}); position off by {away:.2g} mm at most"
        )
    return found


def draw(found: list[tuple[Line, np.ndarray, Curve, dict[str, Curve]]], file: Path) -> None:
    """A column a line: position, its derivative, the derivative's error."""
    figure = Figure(figsize=(12, 9.5), layout="constrained")
    panels = figure.subplots(3, len(found), sharex="col", squeeze=False)
    for column, (line, near, truth, curves) in enumerate(found):
        at = np.array([scene.velocity[line.by] for scene in line.scenes])
        top, middle, bottom = panels[:, column]
        marked = at[(near >= line.kink[0]) & (near <= line.kink[1])]
        for axes in panels[:, column]:
            axes.axvspan(marked[0], marked[-1], color="#eeeeee")
            axes.grid(color="#d9d9d9", linewidth=0.5)
        top.plot(at, truth.position, color="black", linewidth=1, label="reference (complex steps)")
        middle.plot(at, truth.derivative, color="black", linewidth=1)
        for name, curve in curves.items():
            colour, marker = LOOKS[name]
            look: dict[str, Any] = {"color": colour, "marker": marker, "markersize": 3.5}
            top.plot(at, curve.position, linestyle="", label=name, **look)
            middle.plot(at, curve.derivative, linestyle="", **look)
            bottom.plot(at, _error(curve, truth) + 1e-16, linewidth=0.8, **look)
        bottom.axhline(WITHIN, color="#777777", linewidth=0.8, linestyle=":")
        of, by = POSE[line.of], ("Vx", "Vy", "Omega")[line.by]
        low, high = line.kink
        grey = f"grey: {line.near}, from {low:g} to {high:g}"
        top.set_title(f"{line.name}\n{grey}", fontsize=10)
        top.set(ylabel=f"{of} at rest, m")
        middle.set(ylabel=f"d({of} at rest)/d({by}), s")
        bottom.set(yscale="log", ylabel="its relative error", xlabel=line.parameter)
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), fontsize=9)
    figure.savefig(file, dpi=140)


def main(charts: Path, points: int = POINTS) -> None:
    """Write `kinks.csv` and `kinks.png` into the folder."""
    found = []
    for line in lines(points):
        near = np.array([line.nearness(scene) for scene in line.scenes])
        curves = {name: _curve(line, steps) for name, steps in STEPS.items()}
        found.append((line, near, _truth(line), curves))
    remarks = [text for row in found for text in _remarks(*row)]
    names, rows = ["reference", *STEPS], []
    for line, near, truth, curves in found:
        for i, scene in enumerate(line.scenes):
            all_ = [truth, *curves.values()]
            numbers = [scene.velocity[line.by], near[i]]
            numbers += [c.position[i] for c in all_] + [c.derivative[i] for c in all_]
            rows.append([line.name, *(f"{number:.10g}" for number in numbers)])
    cells = [f"{what} {name}" for what in ("position", "derivative") for name in names]
    columns = ["kink", "velocity", "nearness", *cells]
    tables.write(charts / "kinks.csv", columns, rows, (("kinks", text) for text in remarks))
    draw(found, charts / "kinks.png")
    print(*remarks, sep="\n")
