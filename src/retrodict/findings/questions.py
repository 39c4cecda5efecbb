"""The questions a court puts, each put to its study and answered, or withheld with the reason."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from retrodict.findings.answers import (
    Answered,
    Kind,
    Numbers,
    answer_avoidability,
    answer_checks,
    answer_corners,
    answer_likelihood_ratio,
    answer_one_at_a_time,
    answer_probability,
    answer_time_distance,
    in_both_units,
    share_in_words,
    with_sentences,
)
from retrodict.findings.in_units import clause, exact
from retrodict.scene.quantities import SPEEDS, SYSTEMS, Units, describe
from retrodict.studies.avoidability import avoidability, time_distance
from retrodict.studies.corners import corners
from retrodict.studies.draws import NotAnswered
from retrodict.studies.named_checks import named_checks
from retrodict.studies.one_at_a_time import one_at_a_time
from retrodict.studies.probability import Probability, bounded, likelihood_ratio, probability

if TYPE_CHECKING:
    from retrodict.findings.statistics import Quantity
    from retrodict.inference.outcome import Outcome
    from retrodict.inference.points import Estimate
    from retrodict.scene.asked import Avoidance, Proposition, Questions
    from retrodict.studies.conflict import LeftOut

WITHHELD = "Withheld, because checks of the draws failed."


def answers_to(
    outcome: Outcome,
    questions: Questions,
    quantities: dict[str, Quantity],
    left_out: tuple[LeftOut, ...],
) -> tuple[Answered, ...]:
    """The answers to all questions, in the order of the record.

    Args:
        outcome: the reconstruction.
        questions: questions asked of the reconstruction.
        quantities: reported and derived quantities, by name.
        left_out: leave-one-out prediction of each item of evidence.

    Returns:
        One record a question; withheld where checks failed.
    """
    further = _asked(outcome, questions, quantities, left_out)
    return (
        *(probability_of(outcome, quantities, each) for each in questions.probabilities),
        *(_answer(outcome, quantities, each.blanks, each.study, each.words) for each in further),
    )


class _Asked(NamedTuple):
    """A question, with the study that has its numbers and the function that words its answer."""

    kind: Kind
    title: Callable[[Units], str]
    study: Callable[[], Numbers]
    words: Callable[..., Answered]
    quantity: str | None = None
    figure: str | None = None

    @property
    def blanks(self) -> dict[Units, Answered]:
        """The question without its answer, by the units that come first in it."""
        return {
            units: Answered(
                self.kind, self.title(units), figure=self.figure, quantity=self.quantity
            )
            for units in SYSTEMS
        }


def _asked(
    outcome: Outcome,
    questions: Questions,
    quantities: dict[str, Quantity],
    left_out: tuple[LeftOut, ...],
) -> Iterator[_Asked]:
    """The questions other than probabilities; arguments as of `answers_to`."""
    for written in questions.comparisons:
        comparison = written.meant(outcome.scene.travelled)
        name = comparison.first.name
        title = f"Likelihood ratio of two propositions about the {describe(name)[0]}"
        ratio = partial(likelihood_ratio, outcome, comparison)
        words = partial(answer_likelihood_ratio, comparison)
        yield _Asked("likelihood_ratio", _same(title), ratio, words, name)
    for asked in questions.avoidance:
        yield _Asked(
            "avoidability",
            partial(_avoidability_title, asked),
            partial(avoidability, outcome, asked),
            partial(answer_avoidability, outcome, asked),
        )
    if (before := questions.time_distance) is not None:
        of_both = "" if outcome.scene.single else " of both vehicles"
        title = f"Times and distances{of_both} before the impact"
        study = partial(time_distance, outcome, before)
        yield _Asked("time_distance", _same(title), study, answer_time_distance, figure="timeline")
    if questions.corners and "speed_b" in quantities:
        title = f"Corner range of the {describe('speed_b')[0]}"
        words = partial(answer_corners, quantities["speed_b"])
        yield _Asked("corners", _same(title), partial(corners, outcome), words, "speed_b")
    if questions.one_at_a_time:
        for name in [name for name in SPEEDS if name in quantities and not _follows(outcome, name)]:
            title = f"Effect of each measurement on the {describe(name)[0]}"
            effects = partial(one_at_a_time, outcome, name)
            words = partial(answer_one_at_a_time, outcome, name)
            yield _Asked("one_at_a_time", _same(title), effects, words, name, "tornado")
    if questions.checks and not outcome.scene.alone:
        title = "Named checks: measured against predicted"
        yield _Asked(
            "checks", _same(title), partial(named_checks, outcome, left_out), answer_checks
        )


def _same(title: str) -> Callable[[Units], str]:
    """A title without units."""
    return lambda _: title


def _avoidability_title(asked: Avoidance, units: Units) -> str:
    limit = exact(asked.limit, "speed", units)
    return f"Would the impact have been avoided, had {asked.vehicle.upper()} kept to {limit}?"


def _follows(outcome: Outcome, name: str) -> bool:
    """Whether a speed is that at the impact of a vehicle whose speed before its skid is asked."""
    return name in [f"speed_{v}" for v in outcome.scene.travelled]


def probability_of(
    outcome: Outcome, quantities: dict[str, Quantity], proposition: Proposition
) -> Answered:
    """How probable a proposition is, in words.

    Args:
        outcome: the reconstruction.
        quantities: reported and derived quantities, by name.
        proposition: proposition about quantities that the outcome has draws of.

    Returns:
        The answer, or why there is none; `numbers` is a `Probability`.
    """
    meant = proposition.meant(outcome.scene.travelled)
    study = partial(probability, outcome, meant)
    found = _answer(
        outcome, quantities, _of_probability(meant), study, answer_probability, meant.names
    )
    if found.numbers is None or not _asks_before(proposition, meant) or outcome.scene.alone:
        return found
    return _with_impact_speed(found, proposition, probability(outcome, proposition))


def _asks_before(proposition: Proposition, meant: Proposition) -> bool:
    """Whether a name that may be of the speed before the skid or at the impact means the former."""
    return len(meant.names) == 1 and meant.names[0] == f"travelling_{proposition.names[0]}"


def _with_impact_speed(asked: Answered, proposition: Proposition, found: Probability) -> Answered:
    """The answer on the speed before the skid, and that on the impact speed: speed_a may mean either."""
    v = proposition.names[0][-1]
    remark = (
        f"This is the speed at which {v.upper()} travelled before it skidded, which a speed limit is "
        f"about. Of its impact speed (impact_speed_{v}) {share_in_words(found)}."
    )
    return in_both_units(
        {u: asked.in_units(u) for u in SYSTEMS}, lambda own, _: with_sentences(own, remark)
    )


def _of_probability(meant: Proposition) -> dict[Units, Answered]:
    """A question about a proposition, without its answer."""
    return {
        units: Answered(
            "probability",
            f"Probability that {clause(meant, units)}",
            quantity=meant.names[0] if len(meant.names) == 1 else None,
        )
        for units in SYSTEMS
    }


def probability_by_points(estimate: Estimate, proposition: Proposition) -> Answered:
    """How probable a proposition is by the weighted points of a session, in words.

    Args:
        estimate: the weighted points.
        proposition: proposition about quantities that the points have.

    Returns:
        The answer, as from `probability_of`.
    """
    meant = proposition.meant(estimate.scene.travelled)
    blanks = _of_probability(meant)
    if not estimate.checks.passed:
        return in_both_units(blanks, lambda blank, _: with_sentences(blank, WITHHELD))
    if missing := [name for name in meant.names if name not in estimate.quantities]:
        reason = f"Not answered: the model has no {missing[0]}."
        return in_both_units(blanks, lambda blank, _: with_sentences(blank, reason))
    found = _share_of_points(estimate, meant)
    said = f"Given the model and the inputs, {share_in_words(found)}."
    answered = in_both_units(
        blanks, lambda blank, _: replace(with_sentences(blank, said), numbers=found)
    )
    if (
        not _asks_before(proposition, meant)
        or proposition.names[0] not in estimate.quantities
        or estimate.scene.alone
    ):
        return answered
    return _with_impact_speed(answered, proposition, _share_of_points(estimate, proposition))


def _share_of_points(estimate: Estimate, proposition: Proposition) -> Probability:
    holds = proposition.holds_for(estimate.quantities.__getitem__).astype(float)
    value, error = estimate.weighted.mean(holds)
    effective = value * (1 - value) / error**2 if error > 0 else estimate.checks.min_ess_bulk
    known_error = error if error > 0 else None
    return bounded(proposition, value, known_error, effective, estimate.checks.pareto_k)


def _answer(
    outcome: Outcome,
    quantities: dict[str, Quantity],
    blanks: Mapping[Units, Answered],
    study: Callable[[], Numbers],
    words: Callable[..., Answered],
    names: tuple[str, ...] = (),
) -> Answered:
    """A question with its answer; withheld where checks failed, or with the reason for none.

    Args:
        outcome: the reconstruction.
        quantities: reported and derived quantities, by name.
        blanks: the question without its answer, by the units that come first in it.
        study: function that computes the numbers.
        words: function of the numbers, the question and the units; returns the question with its
            answer.
        names: flat names of the quantities asked about; without any, that of the question.
    """

    def without(reason: str) -> Answered:
        return in_both_units(
            blanks, lambda blank, _: replace(with_sentences(blank, reason), figure=None)
        )

    asked = names or (blanks["si"].quantity or "",)
    if not outcome.checks.passed or any(
        quantities[name].withheld for name in asked if name in quantities
    ):
        return without(WITHHELD)
    try:
        numbers = study()
    except NotAnswered as reason:
        return without(f"Not answered: {reason}.")
    return in_both_units(
        blanks, lambda blank, units: replace(words(numbers, blank, units), numbers=numbers)
    )
