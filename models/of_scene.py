"""A scene as arrays: which structure it has, and its numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Array
from retrodict.models.arrays import OF_B, STEPS, Data, Structure
from retrodict.models.run_out import RunOut

from retrodict.mechanics import Zone
from retrodict.mechanics.runout import fixed_steps
from retrodict.scene.records import Scene


def of_scene(
    scene: Scene, rung: str, run_out: RunOut, explained: Callable[[str], bool], loose: bool
) -> tuple[Structure, Data]:
    """A scene as a program's structure and its arguments.

    Args:
        scene: as the rung's run-out sees it.
        rung: its name.
        run_out: of it.
        explained: whether it predicts an item of evidence.
        loose: whether rest poses are too uncertain to be coordinates.
    """
    inputs, ways = scene.inputs(), run_out.ways(scene)
    uncertain: list[tuple[str, str]] = [
        (k, m.law) for k, m in inputs.items() if m.sd > 0 and k not in OF_B
    ]
    numbers: dict[str, Array | np.ndarray] = {
        k: np.array(m.location_and_scale) for k, m in inputs.items()
    }
    if "speed_a" not in inputs:  # unknown: its prior stands in, as of an input
        uncertain.append(("speed_a", "halfnormal"))
        numbers["speed_a"] = np.array([0.0, *scene.priors["speed_a"].numbers])
    if "direction_a" not in inputs:  # so too where A slid
        uncertain.append(("direction_a", "uniform"))
        numbers["direction_a"] = np.array([scene.vehicles["a"].heading.value, np.pi])
    if "omega_a" not in inputs:
        uncertain.append(("omega_a", "normal"))
        numbers["omega_a"] = np.array([0.0, *scene.priors["omega_a"].numbers])
    records = {v: own.record for v, own in scene.approach.items() if own.record is not None}
    for v, record in records.items():
        uncertain.append((f"time_zero_{v}", "uniform"))
        half = (record.high - record.low) / 2
        numbers[f"time_zero_{v}"] = np.array([record.low + half, half])
        # the error of a recorded speed: what the moment adds comes with that
        numbers[f"speed_{v}"] = np.array([numbers[f"speed_{v}"][0], record.sd])
    evidence = {k: m for k, m in scene.evidence().items() if explained(k)}
    marks = {
        f"mark_{i}{item}_{v}": mark
        for v in scene.marks
        for i, mark in enumerate(scene.marks[v], 1)
        for item in ("", "_speed", "_course")
    }
    edges = [s.edge for s in scene.surfaces if s.edge is not None]
    sign = {"left": 1.0, "right": -1.0}
    angles = np.array([e.direction for e in edges])
    turn = np.array([sign[e.side] for e in edges])
    zones = Zone(
        point=np.array([[e.x, e.y] for e in edges]).reshape(-1, 2),
        inward=(turn * np.stack([-np.sin(angles), np.cos(angles)])).T.reshape(-1, 2),
    )
    outlines = tuple(np.array(s.outline.corners) for s in scene.surfaces if s.outline is not None)
    structure = Structure(
        rung=rung,
        uncertain=tuple(uncertain),
        surfaces=tuple(s.name for s in scene.surfaces),
        known_of_b=tuple(k for k in OF_B if k in inputs),
        constant_friction=all(
            s.speed_dependence.value == 0 == s.speed_dependence.sd for s in scene.surfaces
        ),
        rolling=scene.rolling,
        integrated=run_out.integrated(scene),
        rests=run_out.rests,
        evidence=tuple(evidence),
        marks=tuple((k, mark.of) for k, mark in marks.items() if k in evidence),
        robust=scene.robust,
        interlocked=scene.contact.interlocked,
        ways=tuple((v, len(way)) for v, way in ways.items()),
        recorded=tuple((v, len(record.within)) for v, record in records.items()),
        vehicles=tuple(scene.vehicles),
        outlines=tuple(map(len, outlines)),
    )
    data = Data(
        inputs=numbers,
        evidence={k: np.array([m.value, m.sd]) for k, m in evidence.items()},
        marks={k: np.array([marks[k].x, marks[k].y]) for k, _ in structure.marks},
        priors={k: np.array(prior.numbers) for k, prior in scene.priors.items()},
        edges=zones,
        outlines=outlines,
        steps=fixed_steps(STEPS),
        ways=ways,
        records={v: np.array(record.within) for v, record in records.items()},
    )
    # one vehicle's rest pose determines fewer velocities than an impact has unknowns; regressions over
    # inputs do not reach around a circle
    if (
        "direction_a" not in inputs
        or loose
        or structure.barrier
        or structure.unmeasured == structure.rest_components
    ):
        structure = replace(structure, transform="standard")
    # a path by steps that are an argument has as many rows, whatever their number
    if structure.followed and not structure.paced:
        structure = replace(structure, steps=STEPS)
    return structure, data
