"""How far each difference between two scenes of one crash, by itself, moves an answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from retrodict.inference.errors import Unanswerable
from retrodict.inference.reconstruct import reconstruct
from retrodict.options import RunOptions
from retrodict.progress import Progress, prefixed, silent
from retrodict.scene.edit import change
from retrodict.scene.errors import SceneError
from retrodict.scene.records import Scene


@dataclass(frozen=True, slots=True)
class Step:
    """One difference of two scenes, made alone (SI units).

    Args:
        key: dotted key, as in the scene file; empty for the first scene itself.
        old: value in the first scene, as text.
        new: value in the second scene, as text; empty where it has none.
        mean: posterior mean of the answer with this change alone; None where there is no answer.
        sd: posterior standard deviation of the same answer; None where there is no answer.
        why: reason why there is no answer; empty where there is one.
    """

    key: str
    old: str
    new: str
    mean: float | None = None
    sd: float | None = None
    why: str = ""


def each_alone(
    scene: Scene,
    changes: Mapping[str, tuple[str, str | None]],
    model: str,
    name: str,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[Step, ...]:
    """How far each change of a scene moves an answer, all else as it is.

    Args:
        scene: the first scene.
        changes: values in both scenes, as text, by dotted key; None where the second has none.
        model: a rung's name.
        name: flat name of the answer.
        seed: integer seed of the draws.
        progress: called with the stages of each reconstruction.

    Returns:
        A step for the first scene as it is, whose key is empty, and one for each change.
    """
    options = RunOptions(model=model, method="importance", seed=seed)

    def answered(changed: Scene, key: str, old: str, new: str) -> Step:
        within = prefixed(progress or silent, key or "as it is")
        try:
            outcome = reconstruct(changed, options, progress=within, pictured=False)
        except Unanswerable as error:
            return Step(key, old, new, why=str(error))
        if not outcome.checks.passed:
            return Step(key, old, new, why="withheld: checks of its draws failed")
        draws = np.asarray(outcome.idata["posterior"][name])
        return Step(key, old, new, float(draws.mean()), float(draws.std(ddof=1)))

    steps = [answered(scene, "", "", "")]
    for key, (old, wanted) in changes.items():
        new = wanted or ""
        try:
            changed = change(scene, {key: None if wanted is None else _value(wanted)})
        except (SceneError, ValueError, KeyError) as error:
            steps.append(Step(key, old, new, why=f"cannot be changed alone: {error}"))
            continue
        steps.append(answered(changed, key, old, new))
    return tuple(steps)


def _value(text: str) -> object:
    """A value of a scene file from its text: a number, a truth value, or a quantity in words."""
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text
