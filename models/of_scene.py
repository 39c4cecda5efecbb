"""A scene as arrays: which structure it has, and its numbers."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Any

import jax
import numpy as np
from jaxtyping import Array
from retrodict.models.arrays import OF_B, STEPS, Data, Structure
from retrodict.models.run_out import RunOut

from retrodict.mechanics import Zone
from retrodict.mechanics.integration import fixed_steps
from retrodict.scene.priors import OF_PYTHON, Prior
from retrodict.scene.records import Mark, Measured, Scene


def of_scene(
    scene: Scene, rung: str, run_out: RunOut, explained: Callable[[str], bool], loose: bool
) -> tuple[Structure, Data]:
    """A scene as a program's structure and its arguments.

    Args:
        scene: scene with only the effects that the rung's run-out models.
        rung: name of the rung.
        run_out: run-out model of the rung.
        explained: function that says of the name of an item of evidence whether the rung predicts it.
        loose: whether rest poses are too uncertain to be coordinates.
    """
    _require_code(scene)
    inputs, ways = scene.inputs(), run_out.ways(scene)
    records = {v: own.record for v, own in scene.approach.items() if own.record is not None}
    uncertain, numbers = _uncertain(scene, inputs)
    evidence = {k: m for k, m in scene.evidence().items() if explained(k)}
    marks = _marks(scene)
    outlines = tuple(np.array(s.outline.corners) for s in scene.surfaces if s.outline is not None)
    approaches = scene.approach.items()
    structure = Structure(
        rung=rung,
        uncertain=tuple(uncertain),
        surfaces=tuple(s.name for s in scene.surfaces),
        known_of_b=tuple(k for k in OF_B if k in inputs),
        constant_friction=all(
            s.speed_dependence.value == 0 == s.speed_dependence.sd
            for s in (*scene.surfaces, *scene.skidded_on)
        ),
        skids=tuple((v, tuple(p.surface for p in own.skids)) for v, own in approaches if own.skids),
        yaw_marks=tuple((v, own.yaw_mark.surface) for v, own in approaches if own.yaw_mark),
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
        families=tuple((k, _family(prior)) for k, prior in scene.priors.items() if prior.family),
        own=tuple(scene.extra.items()),
    )
    data = Data(
        inputs=numbers,
        evidence={k: np.array([m.value, m.sd]) for k, m in evidence.items()},
        marks={k: np.array([marks[k].x, marks[k].y]) for k, _ in structure.marks},
        priors={k: _numbers(prior) for k, prior in scene.priors.items()},
        edges=_zones(scene),
        outlines=outlines,
        steps=fixed_steps(STEPS),
        ways=ways,
        records={v: np.array(record.within) for v, record in records.items()},
    )
    pinned = "direction_a" in inputs and not loose
    return _completed(structure, pinned=pinned), data


def _completed(structure: Structure, *, pinned: bool) -> Structure:
    """The structure with its coordinates and, where it has to be fixed, its number of steps.

    Args:
        structure: structure in rest poses.
        pinned: whether the scene's numbers allow rest poses as coordinates.
    """
    # regressions over inputs do not reach around a circle, and bounds of rest poses are the defaults'
    if not pinned or structure.families or not _determines_the_motion(structure):
        structure = replace(structure, transform="standard")
    # where the number of steps is an argument, a path has the same number of rows whatever it is
    if structure.followed and not structure.paced:
        structure = replace(structure, steps=STEPS)
    return structure


def _require_code(scene: Scene) -> None:
    """Refuse a stored scene without the priors and terms of the user's own that no file holds."""
    lost = [f'extra["{name}"]' for name, term in scene.extra.items() if term is None]
    lost += [
        f'priors["{name}"]'
        for name, prior in scene.priors.items()
        if prior.family == OF_PYTHON and prior.law is None
    ]
    if lost:
        raise ValueError(
            f"the scene is of a stored result that had {', '.join(lost)} of the user's own, which no "
            "file holds; give them again"
        )


def _uncertain(
    scene: Scene, inputs: dict[str, Measured]
) -> tuple[list[tuple[str, str]], dict[str, Array | np.ndarray]]:
    """Name and law of each uncertain input, and location and scale of every input by name."""
    uncertain: list[tuple[str, str]] = [
        (k, m.law) for k, m in inputs.items() if m.sd > 0 and k not in OF_B
    ]
    numbers: dict[str, Array | np.ndarray] = {
        k: np.array(m.location_and_scale) for k, m in inputs.items()
    }
    # what is unknown of A's approach (its direction, if it slid): its prior stands in for an input
    for name, law, prior in _priors_of_a(scene):
        if name in inputs:
            continue
        if name in scene.priors and scene.priors[name].fixed:
            numbers[name] = np.array([*scene.priors[name].numbers, 0.0])
            continue
        uncertain.append((name, law))
        numbers[name] = prior
    for v, own in scene.approach.items():
        if own.record is None:
            continue
        uncertain.append((f"time_zero_{v}", "uniform"))
        half = (own.record.high - own.record.low) / 2
        numbers[f"time_zero_{v}"] = np.array([own.record.low + half, half])
        # the recorder's error alone: `time_zero` adds that of the moment of the impact
        numbers[f"speed_{v}"] = np.array([numbers[f"speed_{v}"][0], own.record.sd])
    return uncertain, numbers


def _priors_of_a(scene: Scene) -> tuple[tuple[str, str, np.ndarray], ...]:
    """Name, law, and location and scale of the prior of each part of A's approach."""
    speed, yaw = scene.priors["speed_a"], scene.priors["omega_a"].numbers
    of_speed = ("speed_a", "halfnormal", np.array([0.0, *speed.numbers]))
    if speed.family:
        of_speed = ("speed_a", "own", np.array([0.0, 1.0]))
    return (
        of_speed,
        ("direction_a", "uniform", np.array([scene.vehicles["a"].heading.value, np.pi])),
        ("omega_a", "normal", np.array([0.0, *yaw])),
    )


def _numbers(prior: Prior) -> Any:
    """What a program takes of a prior: its numbers, or the user's distribution as a tree of numbers."""
    if prior.law is None:
        return np.array(prior.numbers)
    return jax.tree.map(lambda leaf: np.asarray(leaf, float), prior.law)


def _family(prior: Prior) -> Hashable:
    """What is compiled of a prior that is the user's own."""
    return prior.family if prior.law is None else jax.tree.structure(prior.law)


def _marks(scene: Scene) -> dict[str, Mark]:
    """The mark of each item of evidence there may be at one, by name of the item."""
    return {
        f"mark_{i}{item}_{v}": mark
        for v in scene.marks
        for i, mark in enumerate(scene.marks[v], 1)
        for item in ("", "_speed", "_course")
    }


def _determines_the_motion(structure: Structure) -> bool:
    """Whether rest poses may be coordinates: one vehicle's determines too few velocities."""
    return not structure.single and structure.unmeasured != structure.rest_components


def _zones(scene: Scene) -> Zone:
    """The half-planes beyond the edges of the surfaces."""
    edges = [s.edge for s in scene.surfaces if s.edge is not None]
    sign = {"left": 1.0, "right": -1.0}
    angles = np.array([e.direction for e in edges])
    turn = np.array([sign[e.side] for e in edges])
    return Zone(
        point=np.array([[e.x, e.y] for e in edges]).reshape(-1, 2),
        inward=(turn * np.stack([-np.sin(angles), np.cos(angles)])).T.reshape(-1, 2),
    )
