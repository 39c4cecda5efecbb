"""The questions a court puts, answered: numbers from the studies, in sentences and tables.

Speeds, distances and energies stand in SI and US units side by side.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Literal

from retrodict.findings.rounding import NOTHING, format_value, format_with_sd
from retrodict.inference.digits import decimals_of
from retrodict.scene.quantities import SPEEDS, Unit, describe, label_and_unit, unit_of
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
    """

    kind: Kind
    title: str
    sentences: tuple[str, ...] = ()
    header: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    figure: str | None = None
    quantity: str | None = None
    numbers: Numbers | None = None

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
    answer = partial(_answer, outcome, quantities)
    found = [probability_of(outcome, quantities, each) for each in questions.probabilities]
    for written in questions.comparisons:
        comparison = written.meant(outcome.scene.skidded)
        name = comparison.first.name
        title = f"Likelihood ratio of two propositions about the {describe(name)[0]}"
        blank = Answered("likelihood_ratio", title, quantity=name)
        found.append(answer(blank, partial(_likelihood_ratio, outcome, comparison)))
    for asked in questions.avoidance:
        v = asked.vehicle
        limit = _exact(asked.limit, "speed")
        title = f"Would the impact have been avoided, had {v.upper()} kept to {limit}?"
        blank = Answered("avoidability", title)
        found.append(answer(blank, partial(_avoidability, outcome, asked)))
    if questions.time_distance is not None:
        of_both = "" if outcome.scene.barrier else " of both vehicles"
        title = f"Times and distances{of_both} before the impact"
        blank = Answered("time_distance", title, figure="timeline")
        found.append(answer(blank, partial(_time_distance, outcome, questions.time_distance)))
    if questions.corners and "speed_b" in quantities:
        title = f"Corner range of the {describe('speed_b')[0]}"
        blank = Answered("corners", title, quantity="speed_b")
        found.append(answer(blank, partial(_corners, outcome, quantities["speed_b"])))
    if questions.one_at_a_time:
        for name in [name for name in SPEEDS if name in quantities and not _follows(outcome, name)]:
            title = f"Effect of each measurement on the {describe(name)[0]}"
            blank = Answered("one_at_a_time", title, figure="tornado", quantity=name)
            found.append(answer(blank, partial(_one_at_a_time, outcome, name)))
    if questions.checks:
        blank = Answered("checks", "Named checks: measured against predicted")
        found.append(answer(blank, partial(_checks, outcome, left_out)))
    return tuple(found)


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
    blank = _of_probability(meant)
    found = _answer(outcome, quantities, blank, partial(_probability, outcome, meant))
    if found.numbers is None or meant.name != f"travelling_{proposition.name}":
        return found
    # whoever writes speed_a may mean either: say which was answered, and the other beside it
    at_impact = probability(outcome, proposition)
    v = proposition.name[-1]
    beside = (
        f"This is the speed at which {v.upper()} travelled before it skidded, which a speed limit is "
        f"about. Of its impact speed (impact_speed_{v}) {_share_in_words(at_impact)}."
    )
    return replace(found, sentences=(*found.sentences, beside))


def _of_probability(meant: Proposition) -> Answered:
    """A question about a proposition, without its answer."""
    return Answered("probability", f"Probability that the {_in_words(meant)}", quantity=meant.name)


def probability_by_points(estimate: Estimate, proposition: Proposition) -> Answered:
    """How probable a proposition is by the weighted points of a session, in words.

    Args:
        estimate: the points.
        proposition: about a quantity that they have.

    Returns:
        As of `probability_of`.
    """
    meant = proposition.meant(estimate.scene.skidded)
    blank = _of_probability(meant)
    if not estimate.checks.passed:
        return replace(blank, sentences=(WITHHELD,))
    if meant.name not in estimate.quantities:
        return replace(blank, sentences=(f"Not answered: the model has no {meant.name}.",))
    holds = meant.holds(estimate.quantities[meant.name]).astype(float)
    value, error = estimate.weighted.mean(holds)
    effective = value * (1 - value) / error**2 if error > 0 else estimate.checks.min_ess_bulk
    found = bounded(meant, value, error if error > 0 else None, effective, estimate.checks.pareto_k)
    said = f"Given the model and the inputs, {_share_in_words(found)}."
    return replace(blank, sentences=(said,), numbers=found)


def _answer(
    outcome: Outcome,
    quantities: dict[str, Quantity],
    blank: Answered,
    answer: Callable[[Answered], Answered],
) -> Answered:
    """A question with its answer; withheld where checks failed, or with the reason for none."""
    found = quantities.get(blank.quantity or "")
    if not outcome.checks.passed or (found is not None and found.withheld):
        return replace(blank, sentences=(WITHHELD,), figure=None)
    try:
        return answer(blank)
    except NotAnswered as reason:
        return replace(blank, sentences=(f"Not answered: {reason}.",), figure=None)


def _probability(outcome: Outcome, proposition: Proposition, blank: Answered) -> Answered:
    found = probability(outcome, proposition)
    sentences = [f"Given the model and the inputs, {_share_in_words(found)}."]
    if found.pareto_k is not None:
        sentences.append(
            f"Pareto k of the importance weights is {format_value(found.pareto_k, 2)}."
        )
    return replace(blank, sentences=tuple(sentences), numbers=found)


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


def _likelihood_ratio(outcome: Outcome, comparison: Comparison, blank: Answered) -> Answered:
    found = likelihood_ratio(outcome, comparison)
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
            f"the {_in_words(each.proposition)}",
            f"{100 * prior:.3g} %",
            _of_draws(each).removesuffix(" of the draws"),
        )
        for each, prior in ((found.first, found.prior_first), (found.second, found.prior_second))
    )
    return replace(
        blank,
        sentences=(
            f"The evidence is {times} as probable if the {_in_words(one)} as if it is {_range(other)}.",
            f"Support for the former rather than the latter, by the scale of the {ENFSI_SOURCE}: "
            f"{support}.",
            f"Under each proposition the speed has the model's prior ({found.prior}), cut to it. The "
            "ratio is the posterior odds of the two over their prior odds.",
        ),
        header=("proposition", "prior probability", "posterior probability"),
        rows=rows,
        numbers=found,
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


def _avoidability(outcome: Outcome, asked: Avoidance, blank: Answered) -> Answered:
    found = avoidability(outcome, asked)
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
        f"Assumed: the hazard is perceived {where}; reaction {_measured(asked.reaction, 's')}, then "
        f"braking at {_measured(asked.deceleration, 'm/s²')}{meanwhile}.",
    ]
    rows = [
        _quantile_row(
            "distance to the impact when the hazard is perceived", found.distance, "length"
        ),
        _quantile_row("distance to stop at the limit", found.stopping, "length"),
    ]
    if not barrier:
        way = f"distance that {other} still had to travel to be clear"
        rows.append(_quantile_row(way, found.clear, "length"))
    if found.speed:
        rows.append(_quantile_row("speed at an impact not avoided", found.speed, "speed"))
    return replace(
        blank,
        sentences=tuple(sentences),
        header=("", "median", "95 % of the draws"),
        rows=tuple(rows),
        numbers=found,
    )


def _time_distance(outcome: Outcome, span: float, blank: Answered) -> Answered:
    found = time_distance(outcome, span)
    rows = []
    for i, time in enumerate(found.times[:-1]):  # the last is the impact
        cells = [_quantile_row("", found.distances[v][i], "length")[1:] for v in found.distances]
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
        numbers=found,
    )


def _corners(outcome: Outcome, speed: Quantity, blank: Answered) -> Answered:
    found = corners(outcome)
    said = [
        f"with every measurement within ± {c.limit:g} sd it lies between "
        f"{_text(c.least, 'speed', lambda _: 1)} and {_text(c.greatest, 'speed', lambda _: 1)}"
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
            (what, *(_text(end, "speed", lambda _: 1) for end in ends)) for what, *ends in ranges
        ),
        numbers=found,
    )


def _one_at_a_time(outcome: Outcome, name: str, blank: Answered) -> Answered:
    found = one_at_a_time(outcome, name)
    dimension = describe(name)[1]
    rows = []
    for each in found[:_MOST]:
        label, unit = label_and_unit(each.name, "si")
        measured = _measured(each.measured, unit.symbol, unit.worth)
        sign = "+" if each.moved > 0 else ""
        moved = (
            sign + format_value(each.moved / u.worth, decimals_of(each.error / u.worth, digits=1))
            for u in _units(dimension)
        )
        rows.append((label, measured, _side_by_side(moved, dimension)))
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
        numbers=found,
    )


def _checks(outcome: Outcome, left_out: tuple[LeftOut, ...], blank: Answered) -> Answered:
    found = named_checks(outcome, left_out)
    if not found:
        raise NotAnswered("the model has none of the quantities that they compare")
    rows = []
    for check in found:
        note = f" ({check.note})" if check.note else ""
        measured = "not measured"
        if check.measured is not None:
            measured = _with_sd(check.measured, check.measured_sd or 0.0, check.dimension)
        off = NOTHING if check.off is None else format_value(check.off, 1)
        predicted = _with_sd(check.predicted, check.predicted_sd, check.dimension)
        rows.append((f"{check.name}: {check.of}{note}", measured, predicted, off))
    return replace(
        blank,
        sentences=(
            "Differences are measured less predicted, in standard deviations of both; beyond 2 they "
            "deserve an explanation. A common velocity at the contact means 0 and 0: that is an "
            "assumption compared with the answer, not a measurement.",
        ),
        header=("check", "measured, or assumed", "predicted", "difference, sd"),
        rows=tuple(rows),
        numbers=found,
    )


def _in_words(proposition: Proposition) -> str:
    """A proposition as a clause, limits in SI and US units."""
    return f"{describe(proposition.name)[0]} is {_range(proposition)}"


def _range(proposition: Proposition) -> str:
    dimension, low, high = describe(proposition.name)[1], proposition.low, proposition.high
    if math.isinf(high):
        return f"above {_exact(low, dimension)}"
    if math.isinf(low):
        return f"below {_exact(high, dimension)}"
    return f"between {_exact(low, dimension)} and {_exact(high, dimension)}"


def _units(dimension: str) -> list[Unit]:
    """SI first; of speeds km/h too, which a court outside the United States reads."""
    found = [unit_of(dimension, "si")]
    if dimension == "speed":
        found.append(Unit("km/h", 1 / 3.6))
    us = unit_of(dimension, "us")
    return found if us in found else [*found, us]


def _text(value: float, dimension: str, decimals: Callable[[float], int | None]) -> str:
    """A value in each unit; `decimals` takes what the unit is worth."""
    values = (format_value(value / unit.worth, decimals(unit.worth)) for unit in _units(dimension))
    return _side_by_side(values, dimension)


def _side_by_side(values: Iterable[str], dimension: str) -> str:
    """A value as printed in each of `_units`, with their symbols."""
    pairs = zip(values, _units(dimension), strict=True)
    first, *others = (f"{value} {unit.symbol}".rstrip() for value, unit in pairs)
    return f"{first} ({'; '.join(others)})" if others else first


def _exact(value: float, dimension: str) -> str:
    """A limit that somebody wrote in one of the units, to four digits in each."""
    return _text(value, dimension, lambda worth: _trimmed(value / worth))


def _trimmed(value: float) -> int | None:
    """Decimals of at most four significant digits, without zeros at the end."""
    most = decimals_of(abs(value), digits=4)
    if most is None:
        return 0
    return next(d for d in range(min(most, 0), most + 1) if round(value, d) == round(value, most))


def _with_sd(value: float, sd: float, dimension: str) -> str:
    """A value ± sd in each unit, to two digits of the sd."""
    values = (
        format_with_sd(value / unit.worth, sd / unit.worth) if sd else f"{value:g}"
        for unit in _units(dimension)
    )
    return _side_by_side(values, dimension)


def _measured(m: Measured, symbol: str, worth: float = 1.0) -> str:
    return f"{format_with_sd(m.value / worth, m.measured_sd / worth)} {symbol}".rstrip()


def _quantile_row(what: str, quantiles: tuple[float, ...], dimension: str) -> tuple[str, str, str]:
    """What, its median, and between what 95 % of the draws lie."""
    low, middle, high = quantiles
    ends = (
        f"{format_value(low / unit.worth, 1)} to {format_value(high / unit.worth, 1)}"
        for unit in _units(dimension)
    )
    return what, _text(middle, dimension, lambda _: 1), _side_by_side(ends, dimension)


def _per_cent(value: float, error: float) -> str:
    decimals = decimals_of(100 * error, digits=1)
    return f"{format_value(100 * value, decimals)} % ± {format_value(100 * error, decimals)} %"


def _of_draws(share: Share | Probability) -> str:
    if share.value == 0:
        return "none of the draws"
    if share.value == 1 or share.error is None:
        return "all draws"
    return f"{_per_cent(share.value, share.error)} of the draws"
