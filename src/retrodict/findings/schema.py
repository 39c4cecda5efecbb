"""What `summary.json` holds, as types; run as a command it prints the JSON schema made of them.

python -m retrodict.findings.schema > docs/summary.schema.json
"""

from __future__ import annotations

import json
from typing import Any, Literal, NotRequired, TypedDict

Number = float | None  # None where there is none that is finite
_Limits = list[Number]


class SceneEntry(TypedDict):
    """The scene, by its names."""

    title: str
    name: str


class PrecisionEntry(TypedDict):
    """How numbers are printed: unit, and decimals of them and of the limits of each interval.

    Decimals are negative for tens and up, and null where there is no uncertainty to round to.
    """

    unit: str
    decimals: int | None
    decimals_50: int | None
    decimals_90: int | None
    decimals_95: int | None


class QuantityEntry(TypedDict):
    """Statistics of the posterior draws of a quantity, in `unit`.

    interval: central intervals; mcse_mean, error (of mean and median, the larger) and error_50, _90, _95
    (of the limits, the larger): Monte Carlo standard errors; passed: it has numbers and no check of its
    own failed; withheld: its numbers are not printed; printed: how they are, in SI and US units.
    """

    unit: str
    label: str
    mean: Number
    sd: Number
    median: Number
    interval_50: _Limits
    interval_90: _Limits
    interval_95: _Limits
    ess_bulk: Number
    ess_tail: Number
    rhat: Number
    mcse_mean: Number
    error: Number
    error_50: Number
    error_90: Number
    error_95: Number
    passed: bool
    withheld: bool
    printed: dict[Literal["si", "us"], PrecisionEntry]


CorrelationEntry = TypedDict("CorrelationEntry", {"of": str, "and": str, "value": float})
CorrelationEntry.__doc__ = "Coefficient of correlation of two unknowns over all draws."


class MeasuredEntry(TypedDict):
    """A measured input or item of evidence, and what became of it (SI units, radians).

    value, sd, law, source: as measured; assumed: what of it is a default, "sd" or "value" or nothing;
    mean, sd_found: of the posterior of an input, of the prediction of an item of evidence; shift: mean
    less value in sd; quantiles: at 2.5, 25, 50, 75 and 97.5 % of the same draws, likewise.
    """

    kind: Literal["input", "evidence"]
    label: str
    value: float
    sd: float
    law: str
    source: str
    assumed: str
    mean: Number
    sd_found: Number
    shift: Number
    quantiles: list[float] | None


class ChecksEntry(TypedDict):
    """The verdict on the draws' numerical quality."""

    divergences: int | None
    pareto_k: Number
    max_rhat: Number
    min_ess_bulk: Number
    min_ess_tail: Number
    passed: bool
    reasons: list[str]
    flags: list[str]


class LeftOutEntry(TypedDict):
    """An item of evidence against its prediction from all others (SI units, radians).

    expected, expected_sd: of the measurement, from all else; probability: two-sided; speed_b,
    speed_b_sd: without the item, or speed_a, speed_a_sd where A struck a barrier, and null otherwise;
    reliable: whether pareto_k allows these to be relied on; told: former name of reliable; believed:
    share of an error in it that the posterior would follow; moved: by how much one sd of it would move
    that speed.
    """

    value: float
    sd: float
    expected: Number
    expected_sd: Number
    probability: Number
    speed_a: Number
    speed_a_sd: Number
    speed_b: Number
    speed_b_sd: Number
    pareto_k: Number
    believed: Number
    moved: Number
    believed_error: Number
    moved_error: Number
    reliable: bool
    told: bool
    disagrees: bool


class ProbabilityEntry(TypedDict):
    """How probable it is that a quantity lies between two values; null is no limit.

    proposition: as it was written; quantity: name, sum or difference of names, or the names of several
    propositions, whose limits are in `proposition` only; error: Monte Carlo standard error, null where
    no draw or every draw holds it; at_least, at_most: bounds, each of 95 % confidence; effective: number
    of independent draws.
    """

    proposition: str
    quantity: str
    low: Number
    high: Number
    probability: float
    error: Number
    at_least: float
    at_most: float
    effective: Number
    pareto_k: Number


class LikelihoodRatioEntry(TypedDict):
    """How many times as probable the evidence is under the first proposition as under the second.

    log_error: Monte Carlo standard error of the natural logarithm, null of a bound; bound: "" (none),
    "at least" or "at most".
    """

    first: ProbabilityEntry
    second: ProbabilityEntry
    prior_first: float
    prior_second: float
    prior: str
    likelihood_ratio: float
    log_error: Number
    bound: Literal["", "at least", "at most"]


class ShareEntry(TypedDict):
    """A share of the draws and its Monte Carlo standard error."""

    value: float
    error: float


class AvoidabilityEntry(TypedDict):
    """What would have been at the speed limit; quantiles at 2.5, 50 and 97.5 %.

    Shares of the draws in which the vehicle exceeded the limit (too_fast), would have stopped, would not
    but the other would have been out of the way (passed), and either (avoided).
    """

    vehicle: Literal["a", "b"]
    limit: float
    too_fast: ShareEntry
    stopped: ShareEntry
    passed: ShareEntry
    avoided: ShareEntry
    distance: list[Number]
    stopping: list[Number]
    clear: list[Number]
    speed: list[Number] | None


class TimeDistanceEntry(TypedDict):
    """Distances and speeds of each vehicle before the impact; quantiles at 2.5, 50 and 97.5 %."""

    times: list[float]
    distances: dict[Literal["a", "b"], list[list[float]]]
    speeds: dict[Literal["a", "b"], list[list[float]]]


class CornerEntry(TypedDict):
    """Range of B's speed with every measurement within so many standard deviations."""

    limit: float
    least: float
    greatest: float


class EffectEntry(TypedDict):
    """By how much the answer moves with one standard deviation of a measurement."""

    name: str
    moved: float
    error: Number


class NamedCheckEntry(TypedDict):
    """A check of the field; measured and off, in standard deviations, are null without a measurement."""

    name: str
    of: str
    predicted: float
    predicted_sd: float
    measured: Number
    measured_sd: Number
    off: Number
    note: str


class QuestionEntry(TypedDict):
    """A question and its answer in words, and its numbers (SI units, radians)."""

    kind: Literal[
        "probability",
        "likelihood_ratio",
        "avoidability",
        "time_distance",
        "corners",
        "one_at_a_time",
        "checks",
    ]
    title: str
    quantity: str | None
    sentences: list[str]
    header: list[str]
    rows: list[list[str]]
    figure: str | None
    numbers: (
        ProbabilityEntry
        | LikelihoodRatioEntry
        | AvoidabilityEntry
        | TimeDistanceEntry
        | list[CornerEntry]
        | list[EffectEntry]
        | list[NamedCheckEntry]
        | None
    )


class LadderEntry(TypedDict):
    """What every model says, simplest first, and which of them was chosen."""

    scene: SceneEntry
    question: list[str]
    choice: str | None
    reason: str
    share: float
    factor: float
    seed: int
    complete: bool
    steps: list[dict[str, Any]]


class SlidingEntry(TypedDict):
    """A speed under an assumption, m/s: median, standard deviation and central intervals."""

    median: float
    sd: float
    interval_50: list[float]
    interval_90: list[float]
    interval_95: list[float]


class BySlidingEntry(TypedDict):
    """A speed if sliding along the contact line ended within the contact, and if it went on.

    effective: effective number of draws behind each assumption, the smaller.
    """

    ended: SlidingEntry
    went_on: SlidingEntry
    effective: float


class Summary(TypedDict):
    """The findings of a reconstruction: SI units and radians, null for what is not finite.

    parameters: the reported quantities; derived: what follows from the same draws; hours: share of
    the draws at each hour that the force on a vehicle came from, 12 straight ahead; narrowing: the sd
    of each speed that was sought, were a quantity known exactly; causes: the measured quantities of
    which that would take away the largest shares of its variance, and the shares; question: what was
    asked, in words; answers: by the system of units that comes first; questions: what else was asked,
    with its answers; sliding: the speeds that were sought if sliding along the contact line ended, and
    if it went on, where that makes a difference; files: SHA-256 of the other files of the same result.
    """

    schema: Literal[1]
    scene: SceneEntry
    model: str
    assumptions: list[str]
    parameters: dict[str, QuantityEntry]
    derived: dict[str, QuantityEntry]
    hours: dict[str, dict[str, float]]
    correlations: list[CorrelationEntry]
    measured: dict[str, MeasuredEntry]
    checks: ChecksEntry
    verdict: str
    question: str
    answers: dict[Literal["si", "us"], str]
    seconds: dict[str, Number]
    versions: dict[str, str]
    seed: int
    settings: dict[str, int | str]
    complete: bool
    notes: list[str]
    ladder: LadderEntry | None
    left_out: dict[str, LeftOutEntry]
    causes: dict[str, dict[str, float]]
    narrowing: dict[str, dict[str, float]]
    questions: list[QuestionEntry]
    sliding: dict[str, BySlidingEntry]
    files: NotRequired[dict[str, str]]


def json_schema() -> str:
    """The JSON schema (2020-12) of `summary.json`, as its file holds it."""
    from pydantic import TypeAdapter

    made = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    made |= TypeAdapter(Summary).json_schema()
    return json.dumps(made, indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    print(json_schema(), end="")
