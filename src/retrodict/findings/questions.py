"""The questions a court puts, answered: numbers from the studies, in sentences and tables.

Speeds, distances and energies stand in SI and US units side by side; `Answered.us` has the latter first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Literal

from retrodict.findings.rounding import NOTHING, format_value, format_with_sd
from retrodict.inference.digits import decimals_of
from retrodict.scene.quantities import (
    SPEEDS,
    SYSTEMS,
    Unit,
    Units,
    describe,
    label_and_unit,
    unit_of,
)
from retrodict.studies.avoidability import (
    Avoidability,
    Share,
    TimeDistance,
    avoidability,
    time_distance,
)
from retrodict.studies.corners import Corner, corners
from retrodict.studies.draws import NotAnswered
from retrodict.studies.named_checks import NamedCheck, named_checks
from retrodict.studies.one_at_a_time import Effect, one_at_a_time
from retrodict.studies.probability import (
    CONFIDENCE,
    LikelihoodRatio,
    Probability,
    bounded,
    likelihood_ratio,
    probability,
)

if TYPE_CHECKING:
    from retrodict.findings.statistics import Quantity
    from retrodict.inference.outcome import Outcome
    from retrodict.inference.points import Estimate
    from retrodict.scene.asked import Avoidance, Comparison, Proposition, Questions
    from retrodict.scene.measured import Measured
    from retrodict.studies.conflict import LeftOut

Kind = Literal[
    "probability", "likelihood_ratio", "avoidability", "time_distance", "corners", "one_at_a_time",
    "checks",
]  # fmt: skip
Numbers = (
    Probability
    | LikelihoodRatio
    | Avoidability
    | TimeDistance
    | tuple[Corner, ...]
    | tuple[Effect, ...]
    | tuple[NamedCheck, ...]
)

# lower limit of each step: ENFSI Guideline for Evaluative Reporting in Forensic Science, 2015
ENFSI = (
    (2.0, "weak"),
    (10.0, "moderate"),
    (100.0, "moderately strong"),
    (1e3, "strong"),
    (1e4, "very strong"),
    (1e6, "extremely strong"),
)
ENFSI_SOURCE = "ENFSI Guideline for Evaluative Reporting in Forensic Science, 2015"
WITHHELD = "Withheld, because checks of the draws failed."
WIDER = (
    "It is wider than the interval because it lets every measurement err in the worst direction at "
    "once, which independent errors hardly ever do, and because it uses no priors and no bounds."
)
_SURE = f"{100 * CONFIDENCE:.0f} %"
_SECOND = Unit("s", 1.0)
_DECELERATION: dict[Units, Unit] = {"si": Unit("m/s²", 1.0), "us": Unit("g", 9.80665)}
_FAR = 2.0  # standard deviations
_MOST = 12  # rows of the table of effects


@dataclass(frozen=True)
class Answered:
    """A question with its answer, ready to be printed.

    Args:
        kind: of the question.
        title: what was asked, in a line.
        sentences: the answer, or why there is none.
        header: of a table's columns; empty without one.
        rows: its cells.
        figure: name of the figure that shows it; None without one.
        quantity: flat name of what was asked about; None where it is not one quantity.
        numbers: the answer's (SI units, radians); None where there is none.
        us: the same in words with US units first; None in those.
    """

    kind: Kind
    title: str
    sentences: tuple[str, ...] = ()
    header: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    figure: str | None = None
    quantity: str | None = None
    numbers: Numbers | None = None
    us: Answered | None = None

    def in_units(self, units: Units) -> Answered:
        """The same in words with these units first."""
        return self.us if units == "us" and self.us else self

    def __repr__(self) -> str:
        return f"<Answered: {' '.join([f'{self.title}:', *self.sentences[:1]])}>"


def answers_to(
    outcome: Outcome,
    questions: Questions,
    quantities: dict[str, Quantity],
    left_out: tuple[LeftOut, ...],
) -> tuple[Answered, ...]:
    """The answers to all questions, in the order of the record.

    Args:
        outcome: the reconstruction.
        questions: what is asked of it.
        quantities: the reported ones and those that follow, by name.
        left_out: what all else says of each item of evidence.

    Returns:
        One record a question; withheld where checks failed.
    """
    found = [probability_of(outcome, quantities, each) for each in questions.probabilities]

    def answer(
        kind: Kind,
        title: Callable[[Units], str],
        study: Callable[[], Numbers],
        words: Callable[..., Answered],
        quantity: str | None = None,
        figure: str | None = None,
    ) -> None:
        blanks = {
            units: Answered(kind, title(units), figure=figure, quantity=quantity)
            for units in SYSTEMS
        }
        found.append(_answer(outcome, quantities, blanks, study, words))

    for written in questions.comparisons:
        comparison = written.meant(outcome.scene.skidded)
        name = comparison.first.name
        title = f"Likelihood ratio of two propositions about the {describe(name)[0]}"
        answer(
            "likelihood_ratio",
            _same(title),
            partial(likelihood_ratio, outcome, comparison),
            partial(_likelihood_ratio, comparison),
            quantity=name,
        )
    for asked in questions.avoidance:
        answer(
            "avoidability",
            partial(_avoidability_title, asked),
            partial(avoidability, outcome, asked),
            partial(_avoidability, outcome, asked),
        )
    if questions.time_distance is not None:
        of_both = "" if outcome.scene.barrier else " of both vehicles"
        title = f"Times and distances{of_both} before the impact"
        study = partial(time_distance, outcome, questions.time_distance)
        answer("time_distance", _same(title), study, _time_distance, figure="timeline")
    if questions.corners and "speed_b" in quantities:
        title = f"Corner range of the {describe('speed_b')[0]}"
        words = partial(_corners, quantities["speed_b"])
        answer("corners", _same(title), partial(corners, outcome), words, quantity="speed_b")
    if questions.one_at_a_time:
        for name in [name for name in SPEEDS if name in quantities and not _follows(outcome, name)]:
            title = f"Effect of each measurement on the {describe(name)[0]}"
            answer(
                "one_at_a_time",
                _same(title),
                partial(one_at_a_time, outcome, name),
                partial(_one_at_a_time, outcome, name),
                quantity=name,
                figure="tornado",
            )
    if questions.checks:
        title = "Named checks: measured against predicted"
        answer("checks", _same(title), partial(named_checks, outcome, left_out), _checks)
    return tuple(found)


def _same(title: str) -> Callable[[Units], str]:
    """A title without units."""
    return lambda _: title


def _avoidability_title(asked: Avoidance, units: Units) -> str:
    limit = _exact(asked.limit, "speed", units)
    return f"Would the impact have been avoided, had {asked.vehicle.upper()} kept to {limit}?"


def _follows(outcome: Outcome, name: str) -> bool:
    """Whether a speed is that at the impact of a vehicle whose speed before its skid is asked."""
    return name in [f"speed_{v}" for v in outcome.scene.skidded]


def probability_of(
    outcome: Outcome, quantities: dict[str, Quantity], proposition: Proposition
) -> Answered:
    """How probable a proposition is, in words.

    Args:
        outcome: the reconstruction.
        quantities: as of `answers_to`.
        proposition: about a quantity that the outcome has draws of.

    Returns:
        The answer, or why there is none; `numbers` is a `Probability`.
    """
    meant = proposition.meant(outcome.scene.skidded)
    study = partial(probability, outcome, meant)
    found = _answer(outcome, quantities, _of_probability(meant), study, _probability)
    if found.numbers is None or meant.name != f"travelling_{proposition.name}":
        return found
    return _with_impact_speed(found, proposition, probability(outcome, proposition))


def _with_impact_speed(asked: Answered, proposition: Proposition, found: Probability) -> Answered:
    """Who writes speed_a may mean either speed of a skidded car: which was answered, and the other."""
    v = proposition.name[-1]
    beside = (
        f"This is the speed at which {v.upper()} travelled before it skidded, which a speed limit is "
        f"about. Of its impact speed (impact_speed_{v}) {_share_in_words(found)}."
    )
    return _in_both({u: asked.in_units(u) for u in SYSTEMS}, lambda own, _: _with(own, beside))


def _of_probability(meant: Proposition) -> dict[Units, Answered]:
    """A question about a proposition, without its answer."""
    return {
        units: Answered(
            "probability", f"Probability that the {_in_words(meant, units)}", quantity=meant.name
        )
        for units in SYSTEMS
    }


def _with(asked: Answered, *sentences: str) -> Answered:
    return replace(asked, sentences=(*asked.sentences, *sentences))


def _in_both(
    blanks: Mapping[Units, Answered], words: Callable[[Answered, Units], Answered]
) -> Answered:
    """A question answered in words with SI units first, and with US units first in `us`."""
    return replace(words(blanks["si"], "si"), us=words(blanks["us"], "us"))


def probability_by_points(estimate: Estimate, proposition: Proposition) -> Answered:
    """How probable a proposition is by the weighted points of a session, in words.

    Args:
        estimate: the points.
        proposition: about a quantity that they have.

    Returns:
        As of `probability_of`.
    """
    meant = proposition.meant(estimate.scene.skidded)
    blanks = _of_probability(meant)
    if not estimate.checks.passed:
        return _in_both(blanks, lambda blank, _: _with(blank, WITHHELD))
    if meant.name not in estimate.quantities:
        reason = f"Not answered: the model has no {meant.name}."
        return _in_both(blanks, lambda blank, _: _with(blank, reason))
    found = _share_of_points(estimate, meant)
    said = f"Given the model and the inputs, {_share_in_words(found)}."
    answered = _in_both(blanks, lambda blank, _: replace(_with(blank, said), numbers=found))
    if (
        meant.name != f"travelling_{proposition.name}"
        or proposition.name not in estimate.quantities
    ):
        return answered
    return _with_impact_speed(answered, proposition, _share_of_points(estimate, proposition))


def _share_of_points(estimate: Estimate, proposition: Proposition) -> Probability:
    holds = proposition.holds(estimate.quantities[proposition.name]).astype(float)
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
) -> Answered:
    """A question with its answer; withheld where checks failed, or with the reason for none.

    Args:
        outcome: the reconstruction.
        quantities: as of `answers_to`.
        blanks: the question, by the units that stand first in it.
        study: finds the numbers.
        words: of the numbers, the question and the units, the question with its answer.
    """

    def without(reason: str) -> Answered:
        return _in_both(blanks, lambda blank, _: replace(_with(blank, reason), figure=None))

    found = quantities.get(blanks["si"].quantity or "")
    if not outcome.checks.passed or (found is not None and found.withheld):
        return without(WITHHELD)
    try:
        numbers = study()
    except NotAnswered as reason:
        return without(f"Not answered: {reason}.")
    return _in_both(
        blanks, lambda blank, units: replace(words(numbers, blank, units), numbers=numbers)
    )


def _probability(found: Probability, blank: Answered, _: Units) -> Answered:
    sentences = [f"Given the model and the inputs, {_share_in_words(found)}."]
    if found.pareto_k is not None:
        sentences.append(
            f"Pareto k of the importance weights is {format_value(found.pareto_k, 2)}."
        )
    return _with(blank, *sentences)


def _share_in_words(found: Probability) -> str:
    """A probability with its error, or the bound where no draw tells."""
    if not found.few and found.error is not None:
        decimals = decimals_of(100 * found.error, digits=1)
        value, error = (format_value(100 * x, decimals) for x in (found.value, found.error))
        return f"the probability is {value} %, with a Monte Carlo error of {error} %"
    if math.isinf(found.effective):
        return f"the probability is {100 * found.value:.0f} %"
    draws = format_value(found.effective, 0)
    sure = f"with {_SURE} confidence, by {draws} effective draws"
    if found.value < 0.5:
        most = format_value(100 * found.at_most, decimals_of(found.at_most * 100, digits=1))
        return f"the probability is below {most} % {sure}"
    least = format_value(100 * found.at_least, decimals_of(100 * (1 - found.at_least), digits=1))
    return f"the probability is above {least} % {sure}"


def _likelihood_ratio(
    comparison: Comparison, found: LikelihoodRatio, blank: Answered, units: Units
) -> Answered:
    ratio, bound = found.value, str(found.bound)
    one, other = comparison.first, comparison.second
    if ratio < 1:
        opposite = {"": "", "at least": "at most", "at most": "at least"}
        ratio, bound, one, other = 1 / ratio, opposite[bound], other, one
    support = verbal(ratio)
    if found.error is None:
        times = f"{bound} {format_value(ratio, decimals_of(ratio))} times (with {_SURE} confidence)"
        support = f"{bound} {support}"
    else:
        decimals = decimals_of(ratio * found.error, digits=1)
        value, error = (format_value(x, decimals) for x in (ratio, ratio * found.error))
        times = f"{value} times (Monte Carlo error {error})"
        ends = [verbal(ratio * math.exp(k * found.error)) for k in (-2, 2)]
        if ends[0] != ends[1]:
            support += f" ({ends[0]} to {ends[1]} within two Monte Carlo errors)"
    rows = tuple(
        (
            f"the {_in_words(each.proposition, units)}",
            f"{100 * prior:.3g} %",
            _of_draws(each).removesuffix(" of the draws"),
        )
        for each, prior in ((found.first, found.prior_first), (found.second, found.prior_second))
    )
    return replace(
        blank,
        sentences=(
            f"The evidence is {times} as probable if the {_in_words(one, units)} as if it is "
            f"{_range(other, units)}.",
            f"Support for the former rather than the latter, by the scale of the {ENFSI_SOURCE}: "
            f"{support}.",
            f"Under each proposition the speed has the model's prior ({found.prior}), cut to it. The "
            "ratio is the posterior odds of the two over their prior odds.",
        ),
        header=("proposition", "prior probability", "posterior probability"),
        rows=rows,
    )


def verbal(ratio: float) -> str:
    """A likelihood ratio of at least 1 in words.

    Args:
        ratio: how many times as probable the evidence is.

    Returns:
        The step of the scale; below 2, which the scale leaves out, "none".

    Source:
        ENFSI Guideline for Evaluative Reporting in Forensic Science, 2015.
    """
    words = [word for least, word in ENFSI if ratio >= least]
    return words[-1] if words else "none"


def _avoidability(
    outcome: Outcome, asked: Avoidance, found: Avoidability, blank: Answered, units: Units
) -> Answered:
    v = asked.vehicle.upper()
    barrier = outcome.scene.barrier
    other = "B" if v == "A" else "A"
    if asked.seen_time or asked.seen_distance:
        where = "when or where the question says"
    else:
        where = "one reaction time before the skid"
    avoided = (
        "At the limit, or at its own speed where that was lower, it would have stopped before the point "
        f"of impact in {_of_draws(found.stopped)}"
    )
    meanwhile = ""
    if not barrier:
        avoided += (
            f"; it would not, but {other} would have been out of the way in {_of_draws(found.passed)}; "
            f"the impact would have been avoided in {_of_draws(found.avoided)}"
        )
        meanwhile = f"; {other} moves as it did and goes on at its speed at the impact"
    sentences = [
        f"{avoided}.",
        f"{v} went faster than the limit in {_of_draws(found.too_fast)}.",
        f"Assumed: the hazard is perceived {where}; reaction {_measured(asked.reaction, _SECOND)}, then "
        f"braking at {_measured(asked.deceleration, _DECELERATION[units])}{meanwhile}.",
    ]
    rows = [
        _quantile_row(
            "distance to the impact when the hazard is perceived", found.distance, "length", units
        ),
        _quantile_row("distance to stop at the limit", found.stopping, "length", units),
    ]
    if not barrier:
        way = f"distance that {other} still had to travel to be clear"
        rows.append(_quantile_row(way, found.clear, "length", units))
    if found.speed:
        rows.append(_quantile_row("speed at an impact not avoided", found.speed, "speed", units))
    return replace(
        blank,
        sentences=tuple(sentences),
        header=("", "median", "95 % of the draws"),
        rows=tuple(rows),
    )


def _time_distance(found: TimeDistance, blank: Answered, units: Units) -> Answered:
    rows = []
    for i, time in enumerate(found.times[:-1]):  # the last is the impact
        cells = [
            _quantile_row("", found.distances[v][i], "length", units)[1:] for v in found.distances
        ]
        rows.append((f"{time:.3g}", *(cell for pair in cells for cell in pair)))
    return replace(
        blank,
        sentences=(
            "Distances are along each vehicle's path to where it was at the impact, at a constant speed "
            "but for a measured skid.",
        ),
        header=(
            "seconds before the impact",
            *(
                heading
                for v in found.distances
                for heading in (f"distance of {v.upper()}", "95 % of the draws")
            ),
        ),
        rows=tuple(rows),
    )


def _corners(speed: Quantity, found: tuple[Corner, ...], blank: Answered, units: Units) -> Answered:
    said = [
        f"with every measurement within ± {c.limit:g} sd it lies between "
        f"{_to_tenths(c.least, 'speed', units)} and {_to_tenths(c.greatest, 'speed', units)}"
        for c in found
    ]
    low, high = speed.intervals[95]
    ranges = [(f"every measurement within ± {c.limit:g} sd", c.least, c.greatest) for c in found]
    if low is not None and high is not None:
        ranges.append(("95 % interval of the reconstruction", low, high))
    return replace(
        blank,
        sentences=(f"W{'; '.join(said)[1:]}.", WIDER),
        header=("", "least", "greatest"),
        rows=tuple(
            (what, *(_to_tenths(end, "speed", units) for end in ends)) for what, *ends in ranges
        ),
    )


def _one_at_a_time(
    outcome: Outcome, name: str, found: tuple[Effect, ...], blank: Answered, units: Units
) -> Answered:
    dimension = describe(name)[1]
    rows = []
    for each in found[:_MOST]:
        label, unit = label_and_unit(each.name, units)
        measured = _measured(each.measured, unit)
        sign = "+" if each.moved > 0 else ""
        moved = (
            sign + format_value(each.moved / u.worth, decimals_of(each.error / u.worth, digits=1))
            for u in _units(dimension, units)
        )
        rows.append((label, measured, _side_by_side(moved, dimension, units)))
    sentences = [
        "By how much the answer would move, were each measurement alone one standard deviation higher."
    ]
    if len(found) > _MOST:
        sentences.append(f"The {_MOST} largest of {len(found)}.")
    if outcome.scene.robust:
        sentences.append(
            "Evidence after the impact is left out, because its errors have heavy tails."
        )
    return replace(
        blank,
        sentences=tuple(sentences),
        header=("measurement", "as measured", "moves the answer by"),
        rows=tuple(rows),
    )


def _checks(found: tuple[NamedCheck, ...], blank: Answered, units: Units) -> Answered:
    rows = []
    for check in found:
        note = f" ({check.note})" if check.note else ""
        measured = "not measured"
        if check.measured is not None:
            measured = _with_sd(check.measured, check.measured_sd or 0.0, check.dimension, units)
        off = NOTHING if check.off is None else format_value(check.off, 1)
        predicted = _with_sd(check.predicted, check.predicted_sd, check.dimension, units)
        rows.append((f"{check.name}: {check.of}{note}", measured, predicted, off))
    sentences = ["Differences are measured less predicted, in standard deviations of both."]
    if far := [f"{each.name} {each.of}" for each in found if abs(each.off or 0.0) > _FAR]:
        sentences.append(
            f"Beyond {_FAR:g}: {', '.join(far)}. Either a measurement errs by more than it states, or "
            "the model leaves something out: see the answer without each item of evidence."
        )
    return replace(
        blank,
        sentences=tuple(sentences),
        header=("check", "measured", "predicted", "difference, sd"),
        rows=tuple(rows),
    )


def _in_words(proposition: Proposition, units: Units) -> str:
    """A proposition as a clause, limits in SI and US units."""
    return f"{describe(proposition.name)[0]} is {_range(proposition, units)}"


def _range(proposition: Proposition, units: Units) -> str:
    dimension, low, high = describe(proposition.name)[1], proposition.low, proposition.high
    if math.isinf(high):
        return f"above {_exact(low, dimension, units)}"
    if math.isinf(low):
        return f"below {_exact(high, dimension, units)}"
    return f"between {_exact(low, dimension, units)} and {_exact(high, dimension, units)}"


def _units(dimension: str, first: Units) -> list[Unit]:
    """All units that a dimension is given in; of speeds km/h, which a court outside the US reads."""
    si, us = unit_of(dimension, "si"), unit_of(dimension, "us")
    if si == us:
        return [si]
    metric = [si, Unit("km/h", 1 / 3.6)] if dimension == "speed" else [si]
    return [us, *metric] if first == "us" else [*metric, us]


def _text(
    value: float, dimension: str, units: Units, decimals: Callable[[float], int | None]
) -> str:
    """A value in each unit; `decimals` takes what the unit is worth."""
    values = (
        format_value(value / unit.worth, decimals(unit.worth)) for unit in _units(dimension, units)
    )
    return _side_by_side(values, dimension, units)


def _side_by_side(values: Iterable[str], dimension: str, units: Units) -> str:
    """A value as printed in each of `_units`, with their symbols."""
    pairs = zip(values, _units(dimension, units), strict=True)
    first, *others = (f"{value} {unit.symbol}".rstrip() for value, unit in pairs)
    return f"{first} ({'; '.join(others)})" if others else first


def _exact(value: float, dimension: str, units: Units) -> str:
    """A limit that somebody wrote in one of the units, to four digits in each."""
    return _text(value, dimension, units, lambda worth: _trimmed(value / worth))


def _to_tenths(value: float, dimension: str, units: Units) -> str:
    return _text(value, dimension, units, lambda _: 1)


def _trimmed(value: float) -> int | None:
    """Decimals of at most four significant digits, without zeros at the end."""
    most = decimals_of(abs(value), digits=4)
    if most is None:
        return 0
    return next(d for d in range(min(most, 0), most + 1) if round(value, d) == round(value, most))


def _with_sd(value: float, sd: float, dimension: str, units: Units) -> str:
    """A value ± sd in each unit, to two digits of the sd."""
    values = (
        format_with_sd(value / unit.worth, sd / unit.worth) if sd else f"{value:g}"
        for unit in _units(dimension, units)
    )
    return _side_by_side(values, dimension, units)


def _measured(m: Measured, unit: Unit) -> str:
    return (
        f"{format_with_sd(m.value / unit.worth, m.measured_sd / unit.worth)} {unit.symbol}".rstrip()
    )


def _quantile_row(
    what: str, quantiles: tuple[float, ...], dimension: str, units: Units
) -> tuple[str, str, str]:
    """What, its median, and between what 95 % of the draws lie."""
    low, middle, high = quantiles
    ends = (
        f"{format_value(low / unit.worth, 1)} to {format_value(high / unit.worth, 1)}"
        for unit in _units(dimension, units)
    )
    return what, _to_tenths(middle, dimension, units), _side_by_side(ends, dimension, units)


def _per_cent(value: float, error: float) -> str:
    decimals = decimals_of(100 * error, digits=1)
    return f"{format_value(100 * value, decimals)} % ± {format_value(100 * error, decimals)} %"


def _of_draws(share: Share | Probability) -> str:
    if share.value == 0:
        return "none of the draws"
    if share.value == 1 or share.error is None:
        return "all draws"
    return f"{_per_cent(share.value, share.error)} of the draws"
