"""Reconstructs staged collisions and scores the posteriors by speeds that were measured."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.errors import Interrupted, Unanswerable
from retrodict.progress import Progress, prefixed, silent
from retrodict.scene.edit import build_scene
from retrodict.scene.errors import Problem, SceneError
from retrodict.scene.load import load_scene, read_text, tables_of
from retrodict.scene.names import parsed
from retrodict.studies.fit import Summary, summary
from retrodict.studies.narrowing import Narrowed, narrowing
from retrodict.studies.rewritten import exchanged, in_other_units, same_numbers

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Measured, Scene
    from retrodict.scene.truth import Truth

SCENE, TRUTH = "scene.toml", "truth.toml"
MAX_NARROWING = 3  # quantities that would narrow an answer
KIND = "kind"  # the group that every case has
_OTHER = {"speed_a": "speed_b", "speed_b": "speed_a"}

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
        below: share of the draws below the truth (probability integral transform); None where there is
            no answer.
        groups: groups that the case is counted with, a label by the group's name: its kind ("whole
            scene", "impact only" or "barrier"), of whole scenes whether wheels roll, and those of the
            truth file.
        seconds: duration of the reconstruction, s; None where there was none.
        digests: SHA-256 of scene.toml and truth.toml, by name.
        exchanged: answer for the same vehicle where A and B were exchanged; None where there is none.
        exchanged_reasons: reasons why that answer is not to be relied on.
        units_agree: whether the scene in other units has the same numbers; None where not tried.
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
    below: float | None = None
    groups: dict[str, str] = field(default_factory=dict)
    seconds: float | None = None
    digests: dict[str, str] = field(default_factory=dict)
    exchanged: Summary | None = None
    exchanged_reasons: tuple[str, ...] = ()
    units_agree: bool | None = None

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

    @property
    def standardised(self) -> float | None:
        """Error over the posterior's sd; None where the answer is withheld."""
        if self.error is None or self.answer is None:
            return None
        return self.error / self.answer.sd

    @property
    def moved(self) -> float | None:
        """How far the exchange of A and B moves the median, in sd; None without both answers."""
        if self.exchanged is None or self.exchanged_reasons or not self.counts:
            return None
        assert self.answer is not None
        return (self.exchanged.median - self.answer.median) / self.answer.sd

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

    def groups(self) -> dict[tuple[str, str], Validation]:
        """The scores of each group, by the group's name and label; kinds come first."""
        labels = dict.fromkeys(label for score in self.scores for label in score.groups.items())
        ordered = sorted(labels, key=lambda label: (label[0] != KIND, label))
        return {
            (name, label): replace(
                self, scores=tuple(s for s in self.scores if s.groups.get(name) == label)
            )
            for name, label in ordered
        }

    def evenness(self) -> float | None:
        """How probable it is that shares below the truth lie as unevenly, if all answers are calibrated.

        Returns:
            The probability of the test of Kolmogorov and Smirnov, which takes the speeds as independent;
            None for fewer than five.
        """
        from scipy.stats import kstest

        shares = [s.below for s in self.scores if s.counts and s.below is not None]
        return float(kstest(shares, "uniform").pvalue) if len(shares) >= 5 else None


def cases(*folders: Path) -> tuple[Path, ...]:
    """The folders in some folders that hold a truth file, by name within each.

    Args:
        folders: folders that hold the folders of the cases.

    Returns:
        Paths of the cases' folders, at least one of each.

    Raises:
        ValueError: there is none in one of them.
    """
    found: list[Path] = []
    for folder in folders:
        here = sorted(file.parent for file in folder.glob(f"*/{TRUTH}"))
        if not here:
            raise ValueError(
                f"{folder}: no case in it; write a folder whose folders hold {SCENE} and {TRUTH}"
            )
        found += here
    return tuple(found)


def kind_of(scene: Scene) -> dict[str, str]:
    """The groups that follow from a scene: its kind and, of a whole scene, whether wheels roll."""
    if scene.barrier:
        return {KIND: "barrier"}
    if scene.alone:
        return {KIND: "one vehicle"}
    if not scene.followed:
        return {KIND: "impact only"}
    rolls = any(vehicle.wheels for vehicle in scene.vehicles.values())
    return {KIND: "whole scene", "wheels": "rolling" if rolls else "locked"}


def validate(
    folders: tuple[Path, ...],
    run: Run,
    *,
    model: str,
    method: str,
    progress: Progress | None = None,
    keep: Callable[[Validation], None] | None = None,
    exchange: bool = False,
) -> Validation:
    """Reconstruct every case, and only then read its true speeds.

    Args:
        folders: folders of the cases, each with scene.toml and truth.toml.
        run: function that reconstructs a scene, and reports its stages to the progress it is given.
        model, method: names of the model and the method that `run` uses, for the record.
        progress: called with (case, done, of all), and with the stages within each case.
        keep: called with the scores so far after each case.
        exchange: whether each case is also run with A and B exchanged, and read in other units.

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
            scores += _scored(folder, run, prefixed(progress, place), exchange)
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


def _scored(folder: Path, run: Run, progress: Progress, exchange: bool) -> list[Score]:
    scene = load_scene(folder / SCENE)
    begin = time.perf_counter()
    outcome, reasons = _answer(scene, run, progress)
    seconds = time.perf_counter() - begin
    other, agree = None, None
    other_reasons: tuple[str, ...] = ()
    if exchange:
        document = tables_of(read_text(folder / SCENE), SCENE)
        agree = same_numbers(build_scene(scene.name, **in_other_units(document)), scene)
        tables = exchanged(document)
        if tables is not None and outcome:
            other, other_reasons = _answer(
                build_scene(scene.name, **tables), run, prefixed(progress, "A and B exchanged")
            )

    from retrodict.scene.truth import load_truth  # not sooner: nothing above may know of it

    truth = load_truth(folder / TRUTH)
    shared = Score(
        case=folder.name,
        model=outcome.description.name if outcome else "",
        reasons=reasons,
        note=truth.note,
        groups=kind_of(scene) | truth.groups,
        seconds=seconds,
        digests={name: digest(folder / name) for name in (SCENE, TRUTH)},
        units_agree=agree,
    )
    scores = []
    for name, speed in _sought(scene, truth, folder).items():
        score = replace(
            shared,
            quantity=name,
            truth=speed.value,
            published={p.name: p.speeds[name] for p in truth.published if name in p.speeds},
        )
        if outcome:
            drawn = _draws(outcome, name)
            score = replace(
                score,
                answer=summary(drawn),
                below=float(np.mean(drawn < speed.value)),
                narrowed=narrowing(outcome, name)[:MAX_NARROWING] if outcome.checks.passed else (),
                exchanged=summary(_draws(other, _OTHER[name])) if other else None,
                exchanged_reasons=other_reasons,
            )
        scores.append(score)
    return scores


def _answer(scene: Scene, run: Run, progress: Progress) -> tuple[Outcome | None, tuple[str, ...]]:
    """The outcome, if there is one, and the reasons not to rely on it."""
    try:
        outcome = run(scene, progress)
    except Unanswerable as error:
        return None, (str(error),)
    if not outcome.complete:
        raise Interrupted("stopped before the case was finished")
    return outcome, outcome.checks.reasons


def _draws(outcome: Outcome, name: str) -> np.ndarray:
    return np.asarray(outcome.idata["posterior"][name]).ravel()


def digest(file: Path) -> str:
    """SHA-256 of a file, in hexadecimal digits."""
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _sought(scene: Scene, truth: Truth, folder: Path) -> dict[str, Measured]:
    """The true speeds that the scene does not know."""
    left = {
        n: m for n, m in truth.speeds.items() if scene.approach[parsed(n).vehicle].speed is None
    }
    if not left:
        fix = f"{SCENE} knows every speed in it; take one of them out there"
        raise SceneError(str(folder / TRUTH), [Problem("", "", fix)])
    return left
