"""The record of what was found: made once of a reconstruction, then printed, drawn and saved."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from retrodict.findings.answers import Answered
from retrodict.findings.inputs import InputRow, input_rows
from retrodict.findings.questions import answers_to
from retrodict.findings.sentences import (
    answer,
    assumptions,
    question,
    simplifications,
    verdict,
)
from retrodict.findings.severity import hours
from retrodict.findings.statistics import (
    DERIVED,
    Quantity,
    correlations,
    posterior_of,
    reported,
    statistics,
)
from retrodict.options import RunOptions
from retrodict.scene.quantities import SPEEDS, Units
from retrodict.scene.records import VEHICLES
from retrodict.scene.write import SceneText, scene_text
from retrodict.studies.conflict import LeftOut, conflicts
from retrodict.studies.narrowing import Narrowed, narrowing
from retrodict.studies.sliding import BySliding, by_sliding

if TYPE_CHECKING:
    from retrodict.inference.outcome import Checks, Outcome
    from retrodict.models.description import Description
    from retrodict.scene.records import Scene
    from retrodict.studies.comparison import Ladder

_CAUSES = 3  # named, of each speed's uncertainty
SCHEMA: Literal[1] = 1  # raised when a reader of `summary.json` has to change


@dataclass(frozen=True, slots=True)
class Cause:
    """A measured quantity that contributes to the uncertainty of an answer.

    Args:
        name: flat name of the measured quantity.
        share: share of the answer's variance that would vanish if the quantity were known exactly, to
            first order.
        error: Monte Carlo standard error of the share; None where the draws are not judged.
    """

    name: str
    share: float
    error: float | None


@dataclass(frozen=True)
class Findings:
    """All that is reported of a reconstruction (SI units, radians); plain data, without draws.

    Args:
        scene: the measured scene.
        scene_text: scene file of that scene.
        description: the model, in words.
        quantities: reported quantities, by name.
        derived: quantities derived from the same draws, by name.
        hours: share of the draws at each hour of the clock that the force on a vehicle came from, by
            vehicle, the largest share first.
        correlations: coefficients of correlation of the unknowns, by pair of names.
        measured: inputs and evidence, each with its posterior or posterior-predictive statistics.
        left_out: leave-one-out prediction of each item of evidence.
        narrowing: sd of each sought speed if one more quantity were known exactly; empty where checks
            failed.
        causes: measured quantities that contribute most to the uncertainty of each sought speed;
            empty where checks failed.
        assumptions: assumptions of the reconstruction, one line each.
        simplifications: parts of the scene that the answer leaves out, and assumptions that the scene
            file does not state, one sentence each.
        sliding: each sought speed if sliding along the contact line ended within the contact, and if it
            went on, where that makes a difference; empty where checks failed.
        checks: the verdict on the draws.
        verdict: the same verdict in one line.
        question: the question on speeds and impact, in words.
        answers: the answer in sentences, by the system of units that comes first.
        questions: further questions put to the reconstruction, with their answers.
        size: chains, and draws kept of each; None where there are none.
        seconds, versions, seed, settings, asked, complete, notes: fields of `Outcome`.
        ladder: comparison of the models, where the ladder chose this one; None otherwise.
        schema: version of this record and of its serialisation.
    """

    scene: Scene
    scene_text: SceneText
    description: Description
    quantities: dict[str, Quantity]
    derived: dict[str, Quantity]
    hours: dict[str, dict[int, float]]
    correlations: dict[tuple[str, str], float]
    measured: tuple[InputRow, ...]
    left_out: tuple[LeftOut, ...]
    narrowing: dict[str, tuple[Narrowed, ...]]
    causes: dict[str, tuple[Cause, ...]]
    assumptions: tuple[str, ...]
    checks: Checks
    verdict: str
    question: str
    answers: dict[Units, str]
    questions: tuple[Answered, ...]
    size: tuple[int, int] | None
    seconds: dict[str, float]
    versions: dict[str, str]
    seed: int
    settings: dict[str, int | str]
    asked: RunOptions
    complete: bool
    notes: tuple[str, ...]
    ladder: Ladder | None = None
    simplifications: tuple[str, ...] = ()
    sliding: tuple[BySliding, ...] = ()
    schema: Literal[1] = SCHEMA

    def __repr__(self) -> str:
        counted = f"{len(self.quantities)} quantities, {len(self.derived)} derived"
        return f"<Findings of {self.scene.name!r}: {counted}; {self.verdict}>"


def compute(outcome: Outcome, ladder: Ladder | None = None) -> Findings:
    """Compute the findings of a reconstruction.

    Args:
        outcome: the reconstruction.
        ladder: comparison of the models, where the ladder chose this one; None otherwise.

    Returns:
        The record; each statistic in it was computed once.
    """
    names = reported(outcome)
    derived = () if outcome.scene.alone else reported(outcome, DERIVED)
    found = statistics(outcome, dict.fromkeys((*names, *derived)))
    quantities, left_out = {name: found[name] for name in names}, conflicts(outcome)
    posterior = posterior_of(outcome)
    sizes = outcome.idata["posterior"].sizes if "posterior" in outcome.idata.children else None
    narrowed = _narrowing(outcome, quantities)
    return Findings(
        scene=outcome.scene,
        scene_text=scene_text(outcome.scene),
        description=outcome.description,
        quantities=quantities,
        derived={name: found[name] for name in derived},
        hours={
            v: hours(posterior[f"pdof_{v}"].values) for v in VEHICLES if f"pdof_{v}" in posterior
        },
        correlations=correlations(outcome),
        measured=input_rows(outcome),
        left_out=left_out,
        narrowing=narrowed,
        causes={name: _causes(quantities[name], known) for name, known in narrowed.items()},
        assumptions=assumptions(outcome),
        checks=outcome.checks,
        verdict=verdict(outcome),
        question=question(outcome),
        answers={units: answer(outcome, quantities, units) for units in get_args(Units)},
        questions=answers_to(outcome, outcome.scene.questions, found, left_out),
        size=None if sizes is None else (sizes.get("chain", 0), sizes.get("draw", 0)),
        seconds=dict(outcome.seconds),
        versions=dict(outcome.versions),
        seed=int(outcome.seed),
        settings=dict(outcome.settings),
        asked=outcome.asked,
        complete=bool(outcome.complete),
        notes=outcome.notes,
        ladder=ladder,
        simplifications=simplifications(outcome),
        sliding=_sliding(outcome, quantities),
    )


def _narrowing(
    outcome: Outcome, quantities: dict[str, Quantity]
) -> dict[str, tuple[Narrowed, ...]]:
    if not outcome.checks.passed:
        return {}
    sought = [name for name in quantities if name in SPEEDS]
    found = {name: narrowing(outcome, name) for name in sought}
    return {name: known for name, known in found.items() if known}


def _sliding(outcome: Outcome, quantities: dict[str, Quantity]) -> tuple[BySliding, ...]:
    if not outcome.checks.passed:
        return ()
    return by_sliding(
        outcome, *(name for name, each in quantities.items() if name in SPEEDS and each.passed)
    )


def _causes(answer: Quantity, known: tuple[Narrowed, ...]) -> tuple[Cause, ...]:
    """The measured quantities that would narrow an answer the most, if known exactly."""
    if not answer.sd:
        return ()
    causes = []
    for each in [each for each in known if each.measured is not None][:_CAUSES]:
        share = max(0.0, 1 - (each.sd / answer.sd) ** 2)
        size = answer.ess_bulk
        # of a squared coefficient of correlation, by Fisher's transformation
        error = 2 * math.sqrt(share / size) * (1 - share) if size else None
        causes.append(Cause(each.name, share, error))
    return tuple(causes)
