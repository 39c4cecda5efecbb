"""The action that asks whether a driver could have stopped."""

from __future__ import annotations

from typing import Any

from retrodict.explore.board.arguments import Given, refused
from retrodict.explore.board.changes import written
from retrodict.explore.board.plan import Plan
from retrodict.explore.board.state import State
from retrodict.scene.load import value_at
from retrodict.scene.text_edit import emptied

AVOIDABLE = "questions.avoidable"
# label and example of each key of the question; the last may be left out
ROWS = {
    "limit": ("speed limit", "50 km/h, or 35 mph"),
    "reaction": ("reaction time", "1.5 ± 0.3 s"),
    "deceleration": ("deceleration when braking", "7 ± 0.7 m/s^2, or 0.7 g"),
    "seen_time": ("hazard seen before the impact", "2.5 s; else from the skid"),
}


def ask_avoidable(state: State, plan: Plan, given: Given) -> State:
    """Ask whether a driver could have stopped at a limit, in place of the first such question.

    Without a vehicle the question is taken away.
    """
    before = value_at(plan.document, AVOIDABLE)
    others = list(before[1:]) if isinstance(before, list) else []
    if "vehicle" not in given.values:
        key = AVOIDABLE if others else emptied(plan.document, AVOIDABLE)
        changes: dict[str, Any] = {key: others or None}
        return written(state, plan, changes, "the question of avoidability taken away")
    entry = {"vehicle": given.word("vehicle", ("A", "B"))}
    for name, (label, example) in ROWS.items():
        text = given.text(name)
        if text:
            entry[name] = text
        elif name != "seen_time":
            raise refused(f'{label}: write it like "{example}"')
    return written(state, plan, {AVOIDABLE: [entry, *others]}, "a question of avoidability")
