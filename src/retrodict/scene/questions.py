"""Questions asked of a reconstruction, read from the `[questions]` table of a scene or case file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict

from retrodict.scene.asked import Avoidance, Comparison, Questions
from retrodict.scene.entries.questions import QuestionsEntry
from retrodict.scene.explain import entries_of

__all__ = ["Questions", "questions_from", "questions_of"]


class _Asked(BaseModel):
    model_config = ConfigDict(frozen=True)

    questions: QuestionsEntry


def questions_from(mapping: Mapping[str, Any], where: str) -> Questions:
    """The questions that a `[questions]` table asks.

    Args:
        mapping: the table; its keys are described in docs/questions.md.
        where: name of the file that has the table, for messages.

    Returns:
        The questions, SI units and radians.

    Raises:
        SceneError: something in it is wrong.
    """
    return questions_of(entries_of(_Asked, {"questions": dict(mapping)}, where).questions)


def questions_of(entry: QuestionsEntry) -> Questions:
    """The questions of a table's entries."""
    return Questions(
        probabilities=entry.exceeds + entry.between,
        comparisons=tuple(Comparison(each.first, each.second) for each in entry.likelihood_ratio),
        avoidance=tuple(
            Avoidance(
                vehicle="a" if each.vehicle == "A" else "b",
                limit=each.limit.value,
                reaction=each.reaction,
                deceleration=each.deceleration,
                seen_time=each.seen_time,
                seen_distance=each.seen_distance,
                clear=each.clear,
            )
            for each in entry.avoidable
        ),
        time_distance=entry.time_distance.value if entry.time_distance else None,
        corners=entry.corners,
        one_at_a_time=entry.one_at_a_time,
        checks=entry.checks,
    )
