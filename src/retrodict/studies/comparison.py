"""What a comparison of models comes to, rung by rung: plain records."""

from __future__ import annotations

from dataclasses import dataclass, field

from retrodict.inference.misfit import MIN_PROBABILITY
from retrodict.scene.records import Scene
from retrodict.studies.fit import Fit, Summary

SHARE = 0.25  # of a fuller rung's standard deviation: the most that it may move an answer
FACTOR = 1.25  # the most by which it may widen or narrow the answer


@dataclass(frozen=True, slots=True)
class Reweighted:
    """The sought speed under another prior of the unknown speeds, by reweighting the draws.

    Args:
        prior: "halved" or "doubled" (the half-normals' scale), or "flat".
        median, sd: median and standard deviation of the sought speed, m/s.
        pareto_k: Pareto k of the weights, which cannot be relied on above 0.7.
    """

    prior: str
    median: float
    sd: float
    pareto_k: float


@dataclass(frozen=True, slots=True)
class Step:
    """One rung on one scene.

    Args:
        name: name of the rung.
        below: rungs nested in this one: it is at least as full in impact and in run-out.
        verdict: why the rung was chosen or not, or not run, in one line.
        answers: posterior of each asked quantity.
        fit: fit to the evidence; None where the rung did not run.
        log_evidence, log_evidence_sd: log marginal likelihood and its error; to be compared between
            rungs that explain the same data only.
        parameters: number of unknowns and uncertain inputs.
        seconds: duration of the run without compilation, s.
        reasons: reasons why the draws are not to be relied on; empty where they are.
        priors: the sought speed under other priors of the unknown speeds.
        enough: whether the rung counts, and no fuller rung that is itself enough moves its answer too
            far.
    """

    name: str
    below: tuple[str, ...]
    verdict: str = ""
    answers: dict[str, Summary] = field(default_factory=dict)
    fit: Fit | None = None
    log_evidence: float | None = None
    log_evidence_sd: float | None = None
    parameters: int | None = None
    seconds: float | None = None
    reasons: tuple[str, ...] = ()
    priors: tuple[Reweighted, ...] = ()
    enough: bool = False

    @property
    def counts(self) -> bool:
        """Whether it ran, its draws can be relied on and it fits the evidence."""
        return self.fit is not None and not self.reasons and self.fit.probability >= MIN_PROBABILITY


@dataclass(frozen=True, slots=True)
class Ladder:
    """What every rung says of a scene, and which of them is to be taken.

    Args:
        scene: the measured scene.
        question: names of the quantities asked for, from `REPORTED`.
        steps: steps of the rungs, from simplest to fullest.
        choice: name of the rung to be taken; None where none will do.
        reason: reason for the choice, in one sentence.
        seed: integer seed of all random numbers.
        complete: False when interrupted; then no rung is chosen.
        share: limit on the shift of an answer by a fuller rung, in standard deviations of the latter.
        factor: limit on the ratio of the standard deviations of the two answers.
    """

    scene: Scene
    question: tuple[str, ...]
    steps: tuple[Step, ...]
    choice: str | None
    reason: str
    seed: int
    complete: bool = True
    share: float = SHARE
    factor: float = FACTOR

    def __repr__(self) -> str:
        counted = f"{len(self.steps)} models"
        return f"<Ladder of {self.scene.name!r}: {counted}, choice {self.choice or 'none'}>"

    def step(self, name: str) -> Step:
        """What a rung says."""
        return next(step for step in self.steps if step.name == name)
