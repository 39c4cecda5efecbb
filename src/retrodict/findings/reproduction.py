"""A repeated run compared with the recorded one: which numbers are the same, and which are not."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from retrodict.findings.statistics import LEVELS
from retrodict.findings.summary import summarise

if TYPE_CHECKING:
    import xarray as xr

    from retrodict.findings.record import Findings
    from retrodict.findings.statistics import Quantity

Sameness = Literal["bits", "digits", "error", "no"]
SAMENESS: dict[Sameness, str] = {
    "bits": "the same to the bit",
    "digits": "the same to the digits that are printed",
    "error": "within four Monte Carlo errors",
    "no": "not the same",
}
_NOT_OF_THE_NUMBERS = (
    "seconds",
    "versions",
    "files",
    "verdict",
    "answers",
    "notes",
)  # times; texts
_DIGITS = 3  # of numbers that are not printed to digits of their own


@dataclass(frozen=True, slots=True)
class Compared:
    """A number of a summary, as it was recorded and as it came out again (SI units, radians).

    Args:
        name: path of the number in the summary, such as "parameters.speed_b.mean".
        recorded, again: number in each run; None where it is missing or not finite.
        sameness: a key of `SAMENESS`.
    """

    name: str
    recorded: float | None
    again: float | None
    sameness: Sameness


@dataclass(frozen=True, slots=True)
class Reproduction:
    """A repeated run compared with the recorded one.

    Args:
        link: last link of the archive's chain.
        title: title of the scene.
        numbers: all numbers of the summary.
        draws: whether each variable of the draws is the same to the bit, by group and name.
        versions: versions of libraries and platform that differ: recorded and current, by name.
    """

    link: str
    title: str
    numbers: tuple[Compared, ...]
    draws: dict[str, bool]
    versions: dict[str, tuple[str, str]]

    def __repr__(self) -> str:
        verdict = "reproduced" if self.reproduced else "NOT REPRODUCED"
        return f"<Reproduction of {self.title!r}: {len(self.numbers)} numbers, {verdict}>"

    @property
    def reproduced(self) -> bool:
        """Whether every number came out the same, at least to the digits that are printed."""
        return all(each.sameness in ("bits", "digits") for each in self.numbers)


def compare(
    link: str,
    recorded: Mapping[str, Any],
    draws: xr.DataTree,
    again: Findings,
    draws_again: xr.DataTree,
) -> Reproduction:
    """Compare a recorded summary and its draws with a repeated run.

    Args:
        link: last link of the archive's chain.
        recorded: the summary, as read from JSON.
        draws: draws of the recorded run.
        again: findings of the repeated run.
        draws_again: draws of the repeated run.

    Returns:
        Every number of either, and every variable of the draws.
    """
    now = summarise(again)
    before, after = dict(_numbers(recorded)), dict(_numbers(now))
    quantities = {"parameters": again.quantities, "derived": again.derived}
    numbers = []
    for name in {**before, **after}:
        group, *rest = name
        found = quantities.get(group, {}).get(rest[0]) if rest else None
        pair = before.get(name), after.get(name)
        same = _sameness(*pair, rest[1] if found else "", found)
        numbers.append(Compared(".".join(name), *pair, same if name in before else "no"))
    then, current = recorded["versions"], now["versions"]
    differ = [key for key in {**then, **current} if then.get(key) != current.get(key)]
    return Reproduction(
        link=link,
        title=again.scene.title,
        numbers=tuple(numbers),
        draws=dict(_same_draws(draws, draws_again)),
        versions={key: (then.get(key, "–"), current.get(key, "–")) for key in differ},
    )


def _numbers(value: Any, name: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The numbers of a summary, by where they stand; None is one that is not finite."""
    if isinstance(value, Mapping):
        for key, each in value.items():
            if key not in _NOT_OF_THE_NUMBERS:
                yield from _numbers(each, (*name, str(key)))
    elif isinstance(value, list | tuple):
        for i, each in enumerate(value):
            yield from _numbers(each, (*name, str(i)))
    elif value is None or (isinstance(value, int | float) and not isinstance(value, bool)):
        yield name, value


def _sameness(
    recorded: float | None, again: float | None, statistic: str, found: Quantity | None
) -> Sameness:
    if recorded == again:
        return "bits"
    if recorded is None or again is None:
        return "no"
    if found is None or statistic not in ("mean", "sd", "median", *_OF_LEVEL):
        return "digits" if _rounded(recorded) == _rounded(again) else "no"
    level = _OF_LEVEL.get(statistic)
    printed = []
    for precision in found.precision.values():
        decimals = precision.of_level[level] if level else precision.decimals
        worth = precision.unit.worth
        if decimals is None:
            return "no"
        printed.append(round(recorded / worth, decimals) == round(again / worth, decimals))
    if all(printed):
        return "digits"
    error = found.errors[level] if level else found.error
    # both have an error of about this size
    within = error is not None and abs(again - recorded) <= 4 * math.sqrt(2) * error
    return "error" if within else "no"


_OF_LEVEL = {f"interval_{level}": level for level in LEVELS}


def _rounded(value: float) -> str:
    return f"{value:.{_DIGITS - 1}e}"


def _same_draws(draws: xr.DataTree, again: xr.DataTree) -> Iterator[tuple[str, bool]]:
    for group in {**draws.children, **again.children}:
        one, other = (tree.children.get(group) for tree in (draws, again))
        names = {name for tree in (one, other) if tree is not None for name in tree.data_vars}
        for name in sorted(map(str, names)):
            pair = [tree is not None and name in tree.data_vars for tree in (one, other)]
            same = all(pair) and np.array_equal(
                np.asarray(one[name].values, dtype=float),  # type: ignore[index]
                np.asarray(other[name].values, dtype=float),  # type: ignore[index]
                equal_nan=True,
            )
            yield f"{group}/{name}", bool(same)
