"""Answers to the questions a court puts, in sentences and tables.

Speeds, distances and energies stand in SI and US units side by side; `Answered.us` has the latter first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from retrodict.constants import GRAVITY
from retrodict.findings.in_units import (
    as_measured,
    of_draws,
    proposition_in_words,
    quantile_row,
    range_in_words,
    side_by_side,
    to_tenths,
    units_of,
    with_sd,
)
from retrodict.findings.rounding import NOTHING, format_value
from retrodict.inference.digits import decimals_of
from retrodict.scene.quantities import Unit, Units, describe, label_and_unit
from retrodict.studies.avoidability import Avoidability, TimeDistance
from retrodict.studies.corners import Corner
from retrodict.studies.named_checks import NamedCheck
from retrodict.studies.one_at_a_time import Effect
from retrodict.studies.probability import CONFIDENCE, LikelihoodRatio, Probability

if TYPE_CHECKING:
    from retrodict.findings.statistics import Quantity
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.asked import Avoidance, Comparison

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
WIDER = (
    "It is wider than the interval because it lets every measurement err in the worst direction at "
    "once, which independent errors hardly ever do, and because it uses no priors and no bounds."
)
_SURE = f"{100 * CONFIDENCE:.0f} %"
_SECOND = Unit("s", 1.0)
_DECELERATION: dict[Units, Unit] = {"si": Unit("m/s²", 1.0), "us": Unit("g", GRAVITY)}
_FAR = 2.0  # standard deviations
_MOST = 12  # rows of the table of effects


@dataclass(frozen=True)
class Answered:
    """A question with its answer, ready to be printed.

    Args:
        kind: kind of question.
        title: the question in one line.
        sentences: the answer, or why there is none.
        header: headings of the table's columns; empty without a table.
        rows: cells of the table, row by row.
        figure: name of the figure that shows the answer; None without one.
        quantity: flat name of the quantity asked about; None where there is no single one.
        numbers: numbers of the answer (SI units, radians); None where there is no answer.
        us: the same answer, worded with US units first; None in that answer itself.
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
        """The answer, worded with these units first."""
        return self.us if units == "us" and self.us else self

    def __repr__(self) -> str:
        return f"<Answered: {' '.join([f'{self.title}:', *self.sentences[:1]])}>"


def with_sentences(asked: Answered, *sentences: str) -> Answered:
    """A question with further sentences of its answer."""
    return replace(asked, sentences=(*asked.sentences, *sentences))


def in_both_units(
    blanks: Mapping[Units, Answered], words: Callable[[Answered, Units], Answered]
) -> Answered:
    """A question answered in words with SI units first, and with US units first in `us`."""
    return replace(words(blanks["si"], "si"), us=words(blanks["us"], "us"))


def answer_probability(found: Probability, blank: Answered, _: Units) -> Answered:
    """The question answered by a probability."""
    sentences = [f"Given the model and the inputs, {share_in_words(found)}."]
    if found.pareto_k is not None:
        sentences.append(
            f"Pareto k of the importance weights is {format_value(found.pareto_k, 2)}."
        )
    return with_sentences(blank, *sentences)


def share_in_words(found: Probability) -> str:
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


def answer_likelihood_ratio(
    comparison: Comparison, found: LikelihoodRatio, blank: Answered, units: Units
) -> Answered:
    """The question answered by a likelihood ratio, the smaller side named second."""
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
            f"the {proposition_in_words(each.proposition, units)}",
            f"{100 * prior:.3g} %",
            of_draws(each).removesuffix(" of the draws"),
        )
        for each, prior in ((found.first, found.prior_first), (found.second, found.prior_second))
    )
    return replace(
        blank,
        sentences=(
            f"The evidence is {times} as probable if the {proposition_in_words(one, units)} as if it is "
            f"{range_in_words(other, units)}.",
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
        ratio: likelihood ratio, at least 1.

    Returns:
        The step of the scale; below 2, which the scale leaves out, "none".

    Source:
        ENFSI Guideline for Evaluative Reporting in Forensic Science, 2015.
    """
    words = [word for least, word in ENFSI if ratio >= least]
    return words[-1] if words else "none"


def answer_avoidability(
    outcome: Outcome, asked: Avoidance, found: Avoidability, blank: Answered, units: Units
) -> Answered:
    """The question answered by what would have been at the speed limit."""
    v = asked.vehicle.upper()
    single = outcome.scene.single
    other = "B" if v == "A" else "A"
    if asked.seen_time or asked.seen_distance:
        where = "when or where the question says"
    else:
        where = "one reaction time before the skid"
    avoided = (
        "At the limit, or at its own speed where that was lower, it would have stopped before the point "
        f"of impact in {of_draws(found.stopped)}"
    )
    meanwhile = ""
    if not single:
        avoided += (
            f"; it would not, but {other} would have been out of the way in {of_draws(found.passed)}; "
            f"the impact would have been avoided in {of_draws(found.avoided)}"
        )
        meanwhile = f"; {other} moves as it did and goes on at its speed at the impact"
    sentences = [
        f"{avoided}.",
        f"{v} went faster than the limit in {of_draws(found.too_fast)}.",
        f"Assumed: the hazard is perceived {where}; reaction {as_measured(asked.reaction, _SECOND)}, "
        f"then braking at {as_measured(asked.deceleration, _DECELERATION[units])}{meanwhile}.",
    ]
    rows = [
        quantile_row(
            "distance to the impact when the hazard is perceived", found.distance, "length", units
        ),
        quantile_row("distance to stop at the limit", found.stopping, "length", units),
    ]
    if not single:
        way = f"distance that {other} still had to travel to be clear"
        rows.append(quantile_row(way, found.clear, "length", units))
    if found.speed:
        rows.append(quantile_row("speed at an impact not avoided", found.speed, "speed", units))
    return replace(
        blank,
        sentences=tuple(sentences),
        header=("", "median", "95 % of the draws"),
        rows=tuple(rows),
    )


def answer_time_distance(found: TimeDistance, blank: Answered, units: Units) -> Answered:
    """The question answered by a table of distances before the impact."""
    rows = []
    for i, time in enumerate(found.times[:-1]):  # the last is the impact
        cells = [
            quantile_row("", found.distances[v][i], "length", units)[1:] for v in found.distances
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


def answer_corners(
    speed: Quantity, found: tuple[Corner, ...], blank: Answered, units: Units
) -> Answered:
    """The question answered by the range of B's speed over all corners."""
    said = [
        f"with every measurement within ± {c.limit:g} sd it lies between "
        f"{to_tenths(c.least, 'speed', units)} and {to_tenths(c.greatest, 'speed', units)}"
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
            (what, *(to_tenths(end, "speed", units) for end in ends)) for what, *ends in ranges
        ),
    )


def answer_one_at_a_time(
    outcome: Outcome, name: str, found: tuple[Effect, ...], blank: Answered, units: Units
) -> Answered:
    """The question answered by a table of effects, the largest first."""
    dimension = describe(name)[1]
    rows = []
    for each in found[:_MOST]:
        label, unit = label_and_unit(each.name, units)
        measured = as_measured(each.measured, unit)
        sign = "+" if each.moved > 0 else ""
        moved = (
            sign + format_value(each.moved / u.worth, decimals_of(each.error / u.worth, digits=1))
            for u in units_of(dimension, units)
        )
        rows.append((label, measured, side_by_side(moved, dimension, units)))
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


def answer_checks(found: tuple[NamedCheck, ...], blank: Answered, units: Units) -> Answered:
    """The question answered by a table of named checks."""
    rows = []
    for check in found:
        note = f" ({check.note})" if check.note else ""
        measured = "not measured"
        if check.measured is not None:
            measured = with_sd(check.measured, check.measured_sd or 0.0, check.dimension, units)
        off = NOTHING if check.off is None else format_value(check.off, 1)
        predicted = with_sd(check.predicted, check.predicted_sd, check.dimension, units)
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
