"""The answers under both assumptions on the sliding, beside each other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from retrodict.findings.rounding import format_range, format_value
from retrodict.findings.statistics import scaled, scaled_interval
from retrodict.inference.digits import decimals_of
from retrodict.report.blocks import Table
from retrodict.scene.quantities import Units, label_and_unit
from retrodict.studies.sliding import LEFT

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.studies.fit import Summary

CAUTION = (
    "What was measured allows both, and the answer depends on which it was. The answer above averages "
    "over both by the prior of μ, and no source says how often sliding ends in a contact of this kind. "
    "The damage may show it: parts that were pressed into one another, or that scraped past."
)


def sliding_table(findings: Findings, units: Units) -> Table | None:
    """Each sought speed if sliding along the contact line ended, and if it went on.

    Args:
        findings: findings of the reconstruction.
        units: "si" or "us".

    Returns:
        A table of two rows a speed; None where the assumption makes no difference.
    """
    rows: list[tuple[str, ...]] = []
    for found in findings.sliding:
        label, unit = label_and_unit(found.name, units)
        for words, each in (
            ("sliding along the contact line ended within the contact", found.ended),
            (f"more than {LEFT:.0%} of it was left, as in a sideswipe", found.went_on),
        ):
            cells = _cells(each, unit.worth, found.effective)
            rows.append((f"{label}, if {words}", *cells, unit.symbol))
    if not rows:
        return None
    header = ("Assumption", "median", "95 % interval", "unit")
    return Table(tuple(rows), header, "If sliding ended, and if it went on", texts=(3,))


def _cells(found: Summary, worth: float, effective: float) -> tuple[str, str]:
    """Median and interval, to the digits that the fewest effective draws support."""
    sd = scaled(found.sd, worth)
    error = None if sd is None else 2 * sd / math.sqrt(effective)
    decimals = decimals_of(sd, error=error)
    return (
        format_value(scaled(found.median, worth), decimals),
        format_range(scaled_interval(found.intervals[95], worth), decimals),
    )
