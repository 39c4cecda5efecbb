"""An answer as the page prints it: rounded, and marked or withheld as the checks demand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from retrodict.explore.templates import template
from retrodict.findings.rounding import format_range, format_value
from retrodict.findings.sentences import MARK, NOT_TO_BE_RELIED_ON, WITHHELD
from retrodict.inference.digits import decimals_of
from retrodict.report.figures.drawing import density
from retrodict.scene.quantities import SHORT, Units, describe, label_and_unit

if TYPE_CHECKING:
    import pandas as pd

    from retrodict.findings.answers import Answered
    from retrodict.inference.outcome import Checks
    from retrodict.scene.records import Scene

_CURVE = 96  # points of a marginal density
# standard error of a 95 % limit of a normal law, over its sd and times the root of the number of draws
_OF_LIMITS = 2.67
_DOTS = 400  # of a joint posterior


class Answer(Protocol):
    """An answer of a session, as far as the page reads it."""

    @property
    def scene(self) -> Scene:
        """The scene that was asked about."""

    @property
    def checks(self) -> Checks:
        """The verdict on the draws."""

    @property
    def draws(self) -> Mapping[str, np.ndarray]:
        """Posterior draws of equal weight, by name, SI units and radians."""

    @property
    def seconds(self) -> float:
        """Computing time of the answer, s."""

    @property
    def model(self) -> str:
        """Name of the model that answered."""

    def summary(self, units: Units = "si") -> pd.DataFrame:
        """The reported quantities, a row each."""

    def probability(self, proposition: str) -> Answered:
        """How probable a proposition about a reported quantity is."""


@dataclass(frozen=True, slots=True)
class Row:
    """A quantity's printed answer.

    Args:
        name: flat name of the quantity.
        label: label of the quantity, in words.
        unit: symbol of the unit.
        median: median as text, marked or withheld.
        interval: limits of the 95 % interval as text, marked or withheld.
        verdict: verdict of the checks, in a few words.
        passed: whether the quantity's answer may be relied on.
        asked: whether the scene's question asks it.
    """

    name: str
    label: str
    unit: str
    median: str
    interval: str
    verdict: str
    passed: bool
    asked: bool


def rows(answer: Answer, units: Units) -> list[Row]:
    """An answer as it is printed.

    Args:
        answer: answer of a session.
        units: "si" or "us".

    Returns:
        One row for each reported quantity, those that are asked first.
    """
    asked = answer.scene.question
    found = [
        _row(answer, str(name), numbers, str(name) in asked)
        for name, numbers in answer.summary(units).iterrows()
    ]
    return sorted(found, key=lambda row: not row.asked)


def _row(answer: Answer, name: str, numbers: Mapping[str, Any], asked: bool) -> Row:
    passed = answer.checks.passed
    mark = "" if passed else MARK
    withheld = name in answer.checks.failed or numbers["checks"] == "failed"
    sd, error = float(numbers["sd"]), float(numbers["mcse_mean"])
    limits = (float(numbers["low_95"]), float(numbers["high_95"]))
    of_limits = _OF_LIMITS * sd / math.sqrt(answer.checks.min_ess_tail)
    median = format_value(float(numbers["median"]), decimals_of(sd, error=error))
    interval = format_range(limits, decimals_of(sd, error=of_limits))
    return Row(
        name=name,
        label=describe(name)[0],
        unit=str(numbers["unit"]),
        median=WITHHELD if withheld else median + mark,
        interval=WITHHELD if withheld else interval + mark,
        verdict=WITHHELD if withheld else "passed" if passed else NOT_TO_BE_RELIED_ON,
        passed=passed and not withheld,
        asked=asked,
    )


def drawn(answer: Answer) -> tuple[str, ...]:
    """The quantities whose marginals are shown: reported unknowns that did not fail the checks."""
    names = answer.scene.reported()
    return tuple(
        name
        for name in SHORT
        if name in names and name in answer.draws and name not in answer.checks.failed
    )


def curve(answer: Answer, name: str, units: Units) -> list[list[float]]:
    """The marginal density of a quantity: pairs of its value and the density, in the printed unit.

    Args:
        answer: answer of a session.
        name: flat name of the quantity.
        units: "si" or "us".

    Returns:
        Some hundred pairs; none where the draws do not vary.
    """
    _, unit = label_and_unit(name, units)
    found = density(_finite(answer.draws[name]) / unit.worth)
    if found is None:
        return []
    grid, height = found
    pick = np.linspace(0, grid.size - 1, min(_CURVE, grid.size)).astype(int)
    return np.stack([grid[pick], height[pick]], axis=-1).tolist()


def dots(answer: Answer, one: str, other: str, units: Units) -> list[list[float]]:
    """Draws of two quantities, thinned: pairs in the printed units.

    Args:
        answer: answer of a session.
        one: flat name of the first quantity.
        other: flat name of the second quantity.
        units: "si" or "us".

    Returns:
        A few hundred pairs.
    """
    worth = [label_and_unit(name, units)[1].worth for name in (one, other)]
    pairs = np.stack([np.ravel(answer.draws[name]) for name in (one, other)], axis=-1) / worth
    pairs = pairs[np.isfinite(pairs).all(axis=1)]
    pick = np.linspace(0, len(pairs) - 1, min(_DOTS, len(pairs))).astype(int)
    return pairs[pick].tolist()


def _finite(draws: np.ndarray) -> np.ndarray:
    values = np.ravel(draws)
    return values[np.isfinite(values)]


def html(answer: Answer, units: Units, count: int) -> str:
    """The table of an answer, with the verdict of its checks.

    Args:
        answer: answer of a session.
        units: "si" or "us".
        count: number of the answer on its page, from 1.

    Returns:
        A fragment; every text of the scene is escaped.
    """
    checks = answer.checks
    return template("answer.html.j2").render(
        rows=rows(answer, units),
        passed=checks.passed,
        reasons=checks.reasons,
        flags=checks.flags,
        seconds=answer.seconds,
        model=answer.model,
        count=count,
    )
