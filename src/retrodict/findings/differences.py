"""Two results beside each other: what differs in the answer, by how much, and what was changed."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from retrodict.findings.changes import changed_keys
from retrodict.findings.rounding import NOTHING, format_value, format_with_sd
from retrodict.findings.sentences import NOT_TO_BE_RELIED_ON
from retrodict.findings.statistics import scaled
from retrodict.scene.quantities import SYSTEMS, describe
from retrodict.studies.comparison import FACTOR, SHARE

if TYPE_CHECKING:
    import pandas as pd

    from retrodict.findings.record import Findings
    from retrodict.findings.statistics import Quantity
    from retrodict.scene.quantities import Units

_ERRORS = 4  # Monte Carlo errors that two runs of the same may differ by
_FOUR = "{:.4g}".format  # digits
_MOST = 3  # keys of the scene that the verdict lists


class NothingInCommon(ValueError):
    """Two results have no quantity in common of which both have numbers."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A quantity in two results (SI units, radians); None where a number is withheld or not finite.

    Args:
        one, other: statistics of the quantity in each result.
        difference: mean in `other` less mean in `one`; for angles wrapped to within half a turn.
        in_sd: `difference` over the root mean square of the two standard deviations.
        in_errors: `difference` over its Monte Carlo standard error.
        reported: whether the quantity is one of those reported, not a derived one.
    """

    one: Quantity
    other: Quantity
    difference: float | None
    in_sd: float | None
    in_errors: float | None
    reported: bool

    @property
    def agrees(self) -> bool:
        """Whether means and standard deviations are the same within Monte Carlo error."""
        if self.difference == 0 and self.one.sd == self.other.sd:
            return True
        if self.in_errors is None or abs(self.in_errors) > _ERRORS:
            return False
        sizes = self.one.ess_bulk, self.other.ess_bulk
        error = math.sqrt(sum(1 / (2 * size) for size in sizes if size))  # of the logarithm of a sd
        return abs(math.log(_ratio(self))) <= _ERRORS * error

    @property
    def hardly(self) -> bool:
        """Whether the answer is the same for practical purposes, by the limits of the ladder."""
        moved = self.in_sd is not None and abs(self.in_sd) <= SHARE
        return moved and 1 / FACTOR <= _ratio(self) <= FACTOR


@dataclass(frozen=True)
class Differences:
    """Two results beside each other.

    Args:
        quantities: quantities that both results have, the reported ones first.
        scene: keys of the scene file that differ, with both values as they are written.
        run: settings of the run that differ (model, method, seed, draws, …), with both values.
        verdicts: verdict in sentences, by system of units; the quantity asked for comes first.
        reliable: whether the checks of each result passed.
    """

    quantities: tuple[Difference, ...]
    scene: dict[str, tuple[str, str]]
    run: dict[str, tuple[str, str]]
    verdicts: dict[Units, str]
    reliable: tuple[bool, bool]

    @property
    def verdict(self) -> str:
        """The verdict in sentences, in SI units."""
        return self.verdicts["si"]

    def table(self, units: Units = "si") -> pd.DataFrame:
        """The quantities in a table.

        Args:
            units: "si" or "us".

        Returns:
            One row a quantity; what is withheld is NaN. The columns `difference_in_sd` and
            `difference_in_errors` are the difference of the means in standard deviations and in
            Monte Carlo errors; `checks` says what to make of the row.
        """
        import pandas as pd

        rows: dict[str, dict[str, Any]] = {}
        for each in self.quantities:
            unit = each.one.precision[units].unit
            row: dict[str, Any] = {"unit": unit.symbol}
            for key, found in (("one", each.one), ("other", each.other)):
                mean, sd = (None, None) if _withheld(found) else (found.mean, found.sd)
                row |= {
                    f"mean_{key}": scaled(mean, unit.worth),
                    f"sd_{key}": scaled(sd, unit.worth),
                }
            row["difference"] = scaled(each.difference, unit.worth)
            row |= {
                "difference_in_sd": each.in_sd,
                "difference_in_errors": each.in_errors,
                "checks": self._checks(each),
            }
            rows[each.one.name] = row
        frame = pd.DataFrame.from_dict(rows, orient="index")
        numbers = frame.columns.drop(["unit", "checks"])
        return frame.astype(dict.fromkeys(numbers, float))

    def changes(self) -> pd.DataFrame:
        """Keys of the scene file and settings of the run that differ, with both values."""
        import pandas as pd

        return pd.DataFrame.from_dict(
            self.scene | self.run, orient="index", columns=["one", "other"]
        )

    def _checks(self, each: Difference) -> str:
        if _withheld(each.one) or _withheld(each.other):
            return "failed"
        return "passed" if all(self.reliable) else NOT_TO_BE_RELIED_ON

    def __repr__(self) -> str:
        return f"<Differences of {len(self.quantities)} quantities: {self.verdict}>"

    def __str__(self) -> str:
        return f"{self.verdict}\n\n{self.table().to_string(float_format=_FOUR, na_rep=NOTHING)}"

    def _repr_html_(self) -> str:
        table = self.table().to_html(float_format=_FOUR, na_rep=NOTHING)
        changes = self.changes().to_html() if self.scene or self.run else ""
        return f"<p>{html.escape(self.verdict)}</p>{table}{changes}"


def differences(one: Findings, other: Findings) -> Differences:
    """Compare two results.

    Args:
        one: findings of a reconstruction.
        other: findings of another reconstruction, of the same or a changed scene, by any model.

    Returns:
        The record.

    Raises:
        NothingInCommon: there is no quantity of which both have numbers.
    """
    all_of_one, all_of_other = (each.quantities | each.derived for each in (one, other))
    found = tuple(
        _difference(each, all_of_other[name], name in one.quantities)
        for name, each in all_of_one.items()
        if name in all_of_other
    )
    if all(each.one.mean is None or each.other.mean is None for each in found):
        raise NothingInCommon(
            f"{one.scene.name} by {one.description.name} and {other.scene.name} by "
            f"{other.description.name}: no quantity of which both have draws; compare results of "
            "the same question"
        )
    scene, run = changed_keys(one.scene, other.scene), _of_the_run(one, other)
    reliable = one.checks.passed, other.checks.passed
    sought = one.scene.sought
    asked = [name for name in (f"travelling_{sought}", sought) if name in one.quantities][:1]
    verdicts = {units: _verdict(found, scene, run, reliable, asked, units) for units in SYSTEMS}
    return Differences(found, scene, run, verdicts, reliable)


def _difference(one: Quantity, other: Quantity, reported: bool) -> Difference:
    blank = Difference(one, other, None, None, None, reported)
    if _withheld(one) or _withheld(other) or one.mean is None or other.mean is None:
        return blank
    difference = other.mean - one.mean
    if describe(one.name)[1] == "angle":
        difference = math.remainder(difference, math.tau)
    spread = _joined(one.sd, other.sd)
    error = _joined(one.mcse_mean, other.mcse_mean)
    return Difference(
        one,
        other,
        difference,
        difference / (spread / math.sqrt(2)) if spread else None,
        difference / error if error else None,
        reported,
    )


def _withheld(found: Quantity) -> bool:
    return found.withheld or not found.passed


def _joined(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else math.hypot(one, other)


def _ratio(each: Difference) -> float:
    """Ratio of the standard deviations; infinite where one of them is zero or missing."""
    one, other = each.one.sd, each.other.sd
    return other / one if one and other else math.inf


def _of_the_run(one: Findings, other: Findings) -> dict[str, tuple[str, str]]:
    """What differs in how the results were made."""
    made = [
        {
            "model": each.description.name,
            "seed": str(each.seed),
            **{name: str(value) for name, value in each.settings.items()},
            "complete": "yes" if each.complete else "no",
        }
        for each in (one, other)
    ]
    names = {**made[0], **made[1]}
    pairs = {name: (made[0].get(name, NOTHING), made[1].get(name, NOTHING)) for name in names}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def _verdict(
    found: tuple[Difference, ...],
    scene: dict[str, tuple[str, str]],
    run: dict[str, tuple[str, str]],
    reliable: tuple[bool, bool],
    asked: Sequence[str],
    units: Units,
) -> str:
    sentences = []
    failed = [
        name for name, passed in zip(("first", "second"), reliable, strict=True) if not passed
    ]
    if failed:
        whose = f"the {failed[0]} result" if len(failed) == 1 else "both results"
        sentences.append(f"{NOT_TO_BE_RELIED_ON}: checks of {whose} failed.")
    known = [each for each in found if each.reported and each.in_sd is not None]
    moved = [each for each in known if not each.hardly]
    for each in known:
        if each.one.name in asked:
            text = _moved(each, units)
            sentences.append(f"{text[0].upper()}{text[1:]}.")
    if known:
        largest = max(moved or known, key=lambda each: abs(each.in_sd or 0.0))
        if all(each.agrees for each in known):
            sentences.append("The answers agree within Monte Carlo error.")
        elif not moved:
            sentences.append(
                f"The answers are the same for practical purposes: no mean moves by more than {SHARE} "
                f"of its standard deviation, no standard deviation by more than the factor {FACTOR}. "
                f"The largest move: {_moved(largest, units)}."
            )
        else:
            others = len(moved) - 1
            also = (
                f" So do {others} others."
                if others > 1
                else " So does one other."
                if others
                else ""
            )
            most = "" if largest.one.name in asked else f", most in the {_moved(largest, units)}"
            sentences.append(f"The answers differ{most}.{also}")
    withheld = sum(each.reported and each.difference is None for each in found)
    if withheld:
        sentences.append(f"Of {withheld} reported quantities a number is withheld or missing.")
    return " ".join([*sentences, *_causes(scene, run)])


def _causes(scene: dict[str, tuple[str, str]], run: dict[str, tuple[str, str]]) -> Iterator[str]:
    """In what scene and run differ, in sentences."""
    listed = [f"{key} {old} → {new}" for key, (old, new) in scene.items()]
    more = f" and {len(listed) - _MOST} more" if len(listed) > _MOST else ""
    if listed:
        yield f"In the scene differ: {'; '.join(listed[:_MOST])}{more}."
    else:
        yield "Both are of the same scene."
    made = [f"{name} {old} → {new}" for name, (old, new) in run.items() if name != "complete"]
    if made:
        yield f"In the run differ: {'; '.join(made)}."


def _moved(each: Difference, units: Units) -> str:
    """Move of a quantity between the results, in words."""
    one, other = each.one, each.other
    unit = one.precision[units].unit
    texts = [
        format_with_sd(
            scaled(found.mean, unit.worth),
            scaled(found.sd, unit.worth),
            found.precision[units].decimals,
        )
        for found in (one, other)
    ]
    errors = ""
    if each.in_errors is not None:
        errors = f" ({format_value(abs(each.in_errors), 0)} Monte Carlo errors)"
    change = f"{format_value(each.in_sd, 2)} of its standard deviation{errors}"
    return f"{one.label}, {texts[0]} → {' '.join([texts[1], unit.symbol]).rstrip()}, by {change}"
