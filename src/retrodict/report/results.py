"""The results as they are printed: rounded, and marked or withheld as the checks demand."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from retrodict.findings.rounding import format_range, format_value, format_with_sd
from retrodict.findings.sentences import MARK, WITHHELD
from retrodict.findings.statistics import LEVELS, scaled, scaled_interval
from retrodict.inference.digits import decimals_of, rhat_text
from retrodict.scene.quantities import Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.findings.statistics import Quantity


@dataclass(frozen=True, slots=True)
class ResultRow:
    """A quantity's printed result; every text is already marked or withheld.

    Args:
        name: flat name of the quantity.
        label: name of the quantity in words.
        unit: symbol of the printed unit; empty where there is none.
        median, mean: texts, the latter with ± sd.
        intervals: texts by level in per cent.
        rhat, ess_bulk, ess_tail: texts.
        monte_carlo_error: Monte Carlo error of the 95 % limits, text in the printed unit.
        last_digit: worth of the last digit printed of the 95 % limits, text in the printed unit.
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
    findings: Findings, units: Units, quantities: Iterable[Quantity] | None = None
) -> list[ResultRow]:
    """The results as they are printed, to two digits of their uncertainty or as draws allow.

    When the run failed every number has a mark; the numbers of a quantity that failed checks of its
    own, and of the quantities that follow from it, are withheld.

    Args:
        findings: findings of the reconstruction.
        units: "si" or "us".
        quantities: quantities of the findings to print, in order; None for all that are reported.

    Returns:
        One row for each quantity.
    """
    chosen = findings.quantities.values() if quantities is None else quantities
    return [_row(findings, units, found) for found in chosen]


def _row(findings: Findings, units: Units, found: Quantity) -> ResultRow:
    precision = found.precision[units]
    worth, decimals = precision.unit.worth, precision.decimals
    # the largest error: an interval may have a decimal less than the mean
    error, last = scaled(found.errors[95], worth), precision.of_level[95]

    def text(plain: str) -> str:
        return marked(findings, plain, found.withheld)

    return ResultRow(
        name=found.name,
        label=found.label,
        unit=precision.unit.symbol,
        median=text(format_value(scaled(found.median, worth), decimals)),
        mean=text(format_with_sd(scaled(found.mean, worth), scaled(found.sd, worth), decimals)),
        intervals={
            level: text(
                format_range(
                    scaled_interval(found.intervals[level], worth), precision.of_level[level]
                )
            )
            for level in LEVELS
        },
        rhat=rhat_text(found.rhat),
        ess_bulk=format_value(found.ess_bulk, 0),
        ess_tail=format_value(found.ess_tail, 0),
        monte_carlo_error=format_value(error, decimals_of(error)),
        last_digit=format_value(None if last is None else 10.0**-last, last),
        withheld=found.withheld,
    )


def marked(findings: Findings, text: str, withheld: bool = False) -> str:
    """A printed number as the checks allow it: bare, marked, or withheld."""
    if withheld:
        return WITHHELD
    return text if findings.checks.passed else text + MARK


def named(label: str, unit: str) -> str:
    """A quantity's label with its unit, where it has one."""
    return f"{label}, {unit}" if unit else label
