"""What a comparison of models comes to, rung by rung: plain records."""

from __future__ import annotations

from dataclasses import dataclass, field

from retrodict.inference.misfit import MIN_PROBABILITY
from retrodict.scene.records import Scene
from retrodict.studies.fit import Fit, Summary

SHARE = 0.25  # of its standard deviation: how far a fuller rung may move an answer
FACTOR = 1.25  # by which it may widen or narrow it


@dataclass(frozen=True, slots=True)
class Reweighted:
    """The answer on B's speed under another prior of the unknown speeds, by reweighting the draws.

    Args:
        prior: "halved" or "doubled" (the half-normals' scale), or "flat".
        median, sd: m/s.
        pareto_k: of the weights; above 0.7 they cannot be relied on.
    """

    prior: str
    median: float
    sd: float
    pareto_k: float


@dataclass(frozen=True, slots=True)
class Step:
    """One rung on one scene.

    Args:
        name: of the rung.
        below: rungs that this one is at least as full as, in impact and in run-out.
        verdict: why it was chosen or not, or not run, in one line.
        answers: posterior of each asked quantity.
        fit: to the evidence.
        log_evidence, log_evidence_sd: log marginal likelihood and its error; to be compared between
            rungs that explain the same data only.
        parameters: unknowns and uncertain inputs.
        seconds: of the run, without compilation.
        reasons: why its draws are not to be relied on, if they are not.
        priors: the answer on B's speed under other priors of it.
        enough: whether it counts and no fuller rung that is enough itself moves its answer too far.
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
        scene: what was measured.
        question: what is asked, of `REPORTED`.
        steps: one a rung, from simplest to fullest.
        choice: name of the rung to be taken; None where none will do.
        reason: for the choice, in one sentence.
        seed: of every random number.
        complete: False when interrupted; then no rung is chosen.
        share: of its standard deviation that a fuller rung might move an answer by.
        factor: by which it might widen or narrow it.
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
