"""Reconstructs staged collisions and scores the posteriors by speeds that were measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.errors import Interrupted, Unanswerable
from retrodict.progress import Progress, prefixed, silent
from retrodict.scene.errors import Problem, SceneError
from retrodict.scene.load import load_scene
from retrodict.scene.names import parsed
from retrodict.studies.fit import Summary, summary
from retrodict.studies.narrowing import Narrowed, narrowing

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Measured, Scene
    from retrodict.scene.truth import Truth

SCENE, TRUTH = "scene.toml", "truth.toml"
MAX_NARROWING = 3  # quantities that would narrow an answer

Run = Callable[["Scene", Progress], "Outcome"]


@dataclass(frozen=True, slots=True)
class Score:
    """A speed that was sought, and its measured true value (m/s).

    Args:
        case: name of the case's folder.
        quantity: speed_a or speed_b; empty where a faulty file hides it.
        truth: the measured speed; None where a faulty file hides it.
        model: the rung that the answer comes from.
        answer: posterior summary of the speed; None where there is none.
        reasons: reasons why the answer is not to be relied on; empty where it is.
        published: speeds that others reconstructed, by name of the program or author.
        note: remark of the truth file; empty where there is none.
        narrowed: quantities that would narrow the answer the most, if known exactly.
    """

    case: str
    quantity: str = ""
    truth: float | None = None
    model: str = ""
    answer: Summary | None = None
    reasons: tuple[str, ...] = ()
    published: dict[str, float] = field(default_factory=dict)
    note: str = ""
    narrowed: tuple[Narrowed, ...] = ()

    @property
    def counts(self) -> bool:
        """Whether there is an answer that can be relied on."""
        return self.answer is not None and not self.reasons

    @property
    def error(self) -> float | None:
        """Median less truth, m/s; None where the answer is withheld."""
        if not self.counts or self.answer is None or self.truth is None:
            return None
        return self.answer.median - self.truth

    def inside(self, level: int) -> bool:
        """Whether the central interval of so many per cent holds the truth."""
        if not self.counts or self.answer is None or self.truth is None:
            return False
        low, high = self.answer.intervals[level]
        return low <= self.truth <= high


@dataclass(frozen=True, slots=True)
class Coverage:
    """How many intervals hold the truth.

    Args:
        inside, of: number of intervals that hold the truth, and number of all intervals.
        low, high: 95 % limits of the share that holds the truth (Clopper and Pearson 1934).
    """

    inside: int
    of: int
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Validation:
    """Every case's scores.

    Args:
        scores: scores of all cases, a score for each speed.
        model, method: names of the model and the method that were asked for.
        faults: lines on files that could not be used.
        complete: False when interrupted.
    """

    scores: tuple[Score, ...]
    model: str
    method: str
    faults: tuple[str, ...] = ()
    complete: bool = True

    def __repr__(self) -> str:
        counted = (
            f"{len(self.scores)} speeds, {sum(score.counts for score in self.scores)} answered"
        )
        return f"<Validation of {self.model} by {self.method}: {counted}>"

    def coverage(self, level: int) -> Coverage:
        """How many central intervals of so many per cent hold the truth, of answers that count."""
        from scipy.stats import binomtest

        inside = [score.inside(level) for score in self.scores if score.counts]
        if not inside:
            return Coverage(0, 0, 0.0, 1.0)
        limits = binomtest(sum(inside), len(inside)).proportion_ci(0.95, method="exact")
        return Coverage(sum(inside), len(inside), float(limits.low), float(limits.high))


def cases(folder: Path) -> tuple[Path, ...]:
    """The folders in a folder that hold a truth file, by name.

    Args:
        folder: folder that holds the folders of the cases.

    Returns:
        Paths of the cases' folders, at least one.

    Raises:
        ValueError: there is none.
    """
    found = tuple(sorted(file.parent for file in folder.glob(f"*/{TRUTH}")))
    if not found:
        raise ValueError(
            f"{folder}: no case in it; write a folder whose folders hold {SCENE} and {TRUTH}"
        )
    return found


def validate(
    folders: tuple[Path, ...],
    run: Run,
    *,
    model: str,
    method: str,
    progress: Progress | None = None,
    keep: Callable[[Validation], None] | None = None,
) -> Validation:
    """Reconstruct every case, and only then read its true speeds.

    Args:
        folders: folders of the cases, each with scene.toml and truth.toml.
        run: function that reconstructs a scene, and reports its stages to the progress it is given.
        model, method: names of the model and the method that `run` uses, for the record.
        progress: called with (case, done, of all), and with the stages within each case.
        keep: called with the scores so far after each case.

    Returns:
        The scores; when interrupted, those of the cases that were finished. A file that cannot be
        used, and a scene that has no posterior, leave a score without an answer.
    """
    progress = progress or silent
    scores: list[Score] = []
    faults: list[str] = []

    def found(complete: bool) -> Validation:
        return Validation(tuple(scores), model, method, tuple(faults), complete)

    for i, folder in enumerate(folders, 1):
        place = f"{folder.name} ({i} of {len(folders)})"
        progress(place, 0, 1)
        try:
            scores += _scored(folder, run, prefixed(progress, place))
        except SceneError as error:
            faults += str(error).splitlines()
            place = Path(error.file).name
            scores.append(Score(folder.name, reasons=(f"{place}: {error.problems[0]}",)))
        except (KeyboardInterrupt, Interrupted):
            return found(complete=False)
        progress(place, 1, 1)
        if keep:
            keep(found(complete=folder == folders[-1]))
    return found(complete=True)


def _scored(folder: Path, run: Run, progress: Progress) -> list[Score]:
    scene = load_scene(folder / SCENE)
    outcome, refused = None, ""
    try:
        outcome = run(scene, progress)
    except Unanswerable as error:
        refused = str(error)
    if outcome and not outcome.complete:
        raise Interrupted("stopped before the case was finished")

    from retrodict.scene.truth import load_truth  # not sooner: nothing above may know of it

    truth = load_truth(folder / TRUTH)
    return [
        Score(
            case=folder.name,
            quantity=name,
            truth=speed.value,
            model=outcome.description.name if outcome else "",
            answer=summary(np.asarray(outcome.idata["posterior"][name]).ravel())
            if outcome
            else None,
            reasons=outcome.checks.reasons if outcome else (refused,),
            published={p.name: p.speeds[name] for p in truth.published if name in p.speeds},
            note=truth.note,
            narrowed=narrowing(outcome, name)[:MAX_NARROWING]
            if outcome and outcome.checks.passed
            else (),
        )
        for name, speed in _sought(scene, truth, folder).items()
    ]


def _sought(scene: Scene, truth: Truth, folder: Path) -> dict[str, Measured]:
    """The true speeds that the scene does not know."""
    left = {
        n: m for n, m in truth.speeds.items() if scene.approach[parsed(n).vehicle].speed is None
    }
    if not left:
        fix = f"{SCENE} knows every speed in it; take one of them out there"
        raise SceneError(str(folder / TRUTH), [Problem("", "", fix)])
    return left
