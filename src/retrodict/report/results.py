"""The results as they are printed: rounded, and marked or withheld as the checks demand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from retrodict.inference.digits import decimals_of, rhat_text
from retrodict.report.findings import DERIVED, LEVELS, reported, scaled, statistics, told_as
from retrodict.report.rounding import told, told_range, told_with_sd
from retrodict.scene.quantities import Unit, Units, unit_of
from retrodict.scene.records import VEHICLES

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome

MARK = "†"
WITHHELD = "withheld"


@dataclass(frozen=True, slots=True)
class ResultRow:
    """A quantity's printed result; every text is already marked or withheld.

    Args:
        name: its flat name.
        label: in words.
        unit: symbol.
        median, mean: texts, the latter with ± sd.
        intervals: texts by level in per cent.
        rhat, ess_bulk, ess_tail: texts.
        monte_carlo_error: of the 95 % limits, text in the printed unit.
        last_digit: worth of the last digit printed of them, text.
        withheld: whether the numbers were held back.
    """

    name: str
    label: str
    unit: str
    median: str
    mean: str
    intervals: dict[int, str]
    rhat: str
    ess_bulk: str
    ess_tail: str
    monte_carlo_error: str
    last_digit: str
    withheld: bool


def result_rows(
    outcome: Outcome,
    units: Units,
    names: tuple[str, ...] | None = None,
    found: dict[str, dict[str, Any]] | None = None,
) -> list[ResultRow]:
    """The results as they are printed, to two digits of their uncertainty or what the draws bear out.

    When the run failed every number bears a mark; those of a quantity that failed checks of its
    own, and of what follows from it, are withheld.

    Args:
        outcome: the reconstruction.
        units: "si" or "us".
        names: of the quantities, in order; None for all that are reported.
        found: their `statistics`, where they have been computed already.

    Returns:
        One row for each quantity.
    """
    rows = []
    for name, numbers in (found or statistics(outcome, names or reported(outcome))).items():
        label, unit = told_as(name, units)
        shown = {key: scaled(value, unit.worth) for key, value in numbers.items()}
        decimals = decimals_of(shown["sd"], error=shown["error"])
        error = shown["error_95"]  # the largest: an interval may have a decimal less than the mean
        of_level = {n: decimals_of(shown["sd"], error=shown[f"error_{n}"]) for n in LEVELS}
        last = of_level[95]
        digit = None if last is None else 10.0**-last
        withheld = is_withheld(outcome, name)
        texts = {
            "median": told(shown["median"], decimals),
            "mean": told_with_sd(shown["mean"], shown["sd"], decimals),
            **{str(level): told_range(shown[f"hdi_{level}"], of_level[level]) for level in LEVELS},
        }
        texts = {key: marked(outcome, text, withheld) for key, text in texts.items()}
        rows.append(
            ResultRow(
                name=name,
                label=label,
                unit=unit.symbol,
                median=texts["median"],
                mean=texts["mean"],
                intervals={level: texts[str(level)] for level in LEVELS},
                rhat=rhat_text(numbers["rhat"]),
                ess_bulk=told(numbers["ess_bulk"], 0),
                ess_tail=told(numbers["ess_tail"], 0),
                monte_carlo_error=told(error, decimals_of(error)),
                last_digit=told(digit, last),
                withheld=withheld,
            )
        )
    return rows


def is_withheld(outcome: Outcome, name: str) -> bool:
    """Whether numbers are held back: the quantity, or what it follows from, failed its checks."""
    failed = outcome.checks.failed
    return name in failed or (name in DERIVED and bool(failed))


def marked(outcome: Outcome, text: str, withheld: bool = False) -> str:
    """A printed number as the checks allow it: bare, marked, or withheld."""
    if withheld:
        return WITHHELD
    return text if outcome.checks.passed else text + MARK


def answer(outcome: Outcome, units: Units = "si") -> str:
    """The answer, a sentence a speed: each that was sought with its 95 % interval, or why not.

    Args:
        outcome: the reconstruction.
        units: which come first; both are told.

    Returns:
        One sentence or two, that of A first.
    """
    speeds = {f"speed_{v}": v for v in VEHICLES if f"speed_{v}" in outcome.scene.reported()}
    found = statistics(outcome, tuple(speeds))
    return " ".join(_answer(outcome, units, v, found[name]) for name, v in speeds.items())


def _answer(outcome: Outcome, units: Units, v: str, numbers: dict[str, Any]) -> str:
    who = f"Vehicle {v.upper()} ({outcome.scene.vehicles[v].name})"
    withheld = is_withheld(outcome, f"speed_{v}")
    if not outcome.checks.passed or withheld or numbers["mean"] is None:
        return f"{who}: its speed before impact is {WITHHELD}, because checks of the draws failed."
    # a court outside the United States reads km/h, which is no unit of the tables
    told_in = [Unit("m/s", 1.0), Unit("km/h", 1 / 3.6)]
    us = [unit_of("speed", "us")]
    all_units = us + told_in if units == "us" else told_in + us
    middle, between = [], []
    for unit in all_units:
        # one digit of the uncertainty: a sentence is quoted without its table
        shown = {key: scaled(value, unit.worth) for key, value in numbers.items()}
        decimals = decimals_of(shown["sd"], digits=1, error=shown["error"])
        of_limits = decimals_of(shown["sd"], digits=1, error=shown["error_95"])
        low, high = (told(bound, of_limits) for bound in shown["hdi_95"])
        middle.append(f"{told(shown['median'], decimals)} {unit.symbol}")
        between.append(f"{low} and {high} {unit.symbol}")
    return (
        f"{who} was travelling at about {_first_and_rest(middle)} before impact; given the model "
        f"and the inputs below, with 95 % probability between {_first_and_rest(between)}."
    )


def _first_and_rest(texts: list[str]) -> str:
    return f"{texts[0]} ({'; '.join(texts[1:])})"
