"""What stands beside an answer: the questions that the scene asks, and what would narrow the speeds.

Both come from the studies that the report has too, by the draws of the session. Predictions of the
evidence are not among these: what rest poses and marks would do is in the report.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from retrodict.explore.templates import template
from retrodict.findings.rounding import format_value, format_with_sd
from retrodict.inference.digits import decimals_of
from retrodict.scene.quantities import SPEEDS, Units, label_and_unit, unit_of

if TYPE_CHECKING:
    from retrodict.explore.answers import Answer
    from retrodict.findings.answers import Answered
    from retrodict.inference.outcome import Outcome

_ROWS = 5  # quantities that narrow a speed the most
_LEAST = 0.03  # share of the standard deviation that a row takes away


@dataclass(frozen=True, slots=True)
class Narrowing:
    """What would narrow a speed, as it is printed.

    Args:
        label: label of the speed.
        unit: symbol of its unit.
        now: standard deviation of the speed.
        rows: name of a quantity with its unit, its measured value, and the standard deviation that is
            left of the speed if the quantity were known exactly.
    """

    label: str
    unit: str
    now: str
    rows: tuple[tuple[str, str, str], ...]


def html(answer: Answer, units: Units) -> str:
    """The questions and what would narrow the answer; empty where there is neither.

    Args:
        answer: answer of a session.
        units: "si" or "us".

    Returns:
        A fragment; every text of the scene is escaped.
    """
    outcome = outcome_of(answer)
    return template("beside.html.j2").render(
        questions=[each.in_units(units) for each in asked(answer, outcome)],
        narrowing=narrowed(outcome, units),
    )


def asked(answer: Answer, outcome: Outcome) -> list[Answered]:
    """The scene's questions about limits and whether a driver could have stopped, with answers.

    Args:
        answer: answer of a session.
        outcome: the same as an outcome.
    """
    from retrodict.findings.questions import answers_to

    questions = answer.scene.questions
    found = [answer.probability(each.text) for each in questions.probabilities]
    others = replace(
        questions,
        probabilities=(),
        comparisons=(),
        time_distance=None,
        corners=False,
        one_at_a_time=False,
        checks=False,
    )
    return [*found, *answers_to(outcome, others, {}, ())]


def narrowed(outcome: Outcome, units: Units) -> list[Narrowing]:
    """What would narrow each reported speed the most.

    Args:
        outcome: outcome of a session's answer.
        units: "si" or "us".

    Returns:
        Nothing where the checks failed.
    """
    from retrodict.studies.narrowing import narrowing

    if not outcome.checks.passed:
        return []
    draws = outcome.idata["posterior"].data_vars
    speed = unit_of("speed", units)
    found = []
    for name in SPEEDS:
        if name not in draws or name not in outcome.scene.reported():
            continue
        sd = float(np.std(draws[name].values))
        rows: list[tuple[str, str, str]] = []
        for each in narrowing(outcome, name):
            if len(rows) == _ROWS or each.sd > (1 - _LEAST) * sd:
                break
            label, unit = label_and_unit(each.name, units)
            m = each.measured
            measured = format_with_sd(m.value / unit.worth, m.sd / unit.worth) if m else ""
            left = each.sd / speed.worth
            rows.append(
                (
                    f"{label}, {unit.symbol}" if unit.symbol else label,
                    measured or "not measured",
                    format_value(left, decimals_of(left)),
                )
            )
        if rows:
            now = format_value(sd / speed.worth, decimals_of(sd / speed.worth))
            label = label_and_unit(name, units)[0]
            found.append(Narrowing(label, speed.symbol, now, tuple(rows)))
    return found


def outcome_of(answer: Answer) -> Outcome:
    """A session's answer in the form that studies read: its draws, without predictions.

    Args:
        answer: answer of a session.
    """
    import xarray as xr

    from retrodict.inference.outcome import Outcome
    from retrodict.models.model import RUNGS

    posterior = {
        name: (("chain", "draw"), np.ravel(values)[None])
        for name, values in answer.draws.items()
        if np.ndim(values) == 1 and "/" not in name  # of a tree, a name with one is a path
    }
    # a study of predictions passes over a name that no item of evidence has
    none = {"no_evidence": (("chain", "draw"), np.zeros((1, 1)))}
    tree = xr.DataTree.from_dict(
        {"/posterior": xr.Dataset(posterior), "/posterior_predictive": xr.Dataset(none)}
    )
    description = RUNGS[answer.model].description(answer.scene)
    return Outcome(answer.scene, description, tree, answer.checks, {}, {}, 0, {})
