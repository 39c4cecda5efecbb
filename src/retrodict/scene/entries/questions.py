"""The entries of the questions that are asked of the reconstruction."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, PlainValidator, model_validator

from retrodict.scene import units
from retrodict.scene.asked import (
    Proposition,
    read_comparison,
    read_proposition,
)
from retrodict.scene.entries.table import Table
from retrodict.scene.errors import shown
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.measured import Measured
from retrodict.scene.units import QuantityError

_EXACT = "a limit is exact"
SpeedLimit = Annotated[
    Measured, Kind(units.SPEED, 1, 150, "45 mph", uncertainty="refused", advice=_EXACT)
]
ReactionTime = Annotated[Measured, Kind(units.TIME, 0.05, 20, "1.5 ± 0.3 s", "lognormal")]
Deceleration = Annotated[Measured, Kind(units.DECELERATION, 0.1, 20, "7 ± 0.7 m/s^2", "lognormal")]
TimeBefore = Annotated[Measured, Kind(units.TIME, 0.05, 60, "2.5 ± 0.3 s", "lognormal")]
DistanceBefore = Annotated[Measured, Kind(units.LENGTH, 0.1, 1000, "40 ± 3 m", "lognormal")]
Span = Annotated[Measured, Kind(units.TIME, 0.1, 60, "3 s", uncertainty="refused")]


def _propositions(raw: object) -> tuple[Proposition, ...]:
    texts = raw if isinstance(raw, list) else [raw]
    if len(texts) > _ASKED:
        raise fault(f"{len(texts)} propositions; write at most {_ASKED}")
    return tuple(_proposition(text) for text in texts)


def _proposition(raw: object) -> Proposition:
    try:
        return read_proposition(raw)
    except QuantityError as found:
        raise fault(found.fix) from None


def _single(raw: object) -> Proposition:
    found = _proposition(raw)
    if found.joined:
        raise fault(f"{shown(found.text)} is several propositions; write one")
    return found


def _one_limit(asked: tuple[Proposition, ...]) -> tuple[Proposition, ...]:
    for each in asked:
        if not each.joined and math.isfinite(each.low) and math.isfinite(each.high):
            raise fault(f"{shown(each.text)} has two limits; write it under between")
    return asked


def _two_limits(asked: tuple[Proposition, ...]) -> tuple[Proposition, ...]:
    for each in asked:
        if each.joined:
            raise fault(f"{shown(each.text)} is several propositions; write it under exceeds")
        if not (math.isfinite(each.low) and math.isfinite(each.high)):
            raise fault(f"{shown(each.text)} has one limit; write it under exceeds")
    return asked


_ASKED = 20  # of each kind of question
Propositions = Annotated[tuple[Proposition, ...], PlainValidator(_propositions)]
_FIRST, _SECOND = '"speed_b at most 45 mph"', '"speed_b at least 55 mph"'
_AVOIDABLE = (
    '[{ vehicle = "B", limit = "45 mph", reaction = "1.5 ± 0.3 s", deceleration = "0.7 ± 0.07 g", '
    'seen_time = "2.5 ± 0.3 s" }]'
)


class LikelihoodRatioEntry(Table):
    """An entry of `likelihood_ratio`: two propositions about one speed before the impact."""

    first: Annotated[Proposition, PlainValidator(_single)] = Field(examples=[_FIRST])
    second: Annotated[Proposition, PlainValidator(_single)] = Field(examples=[_SECOND])

    @model_validator(mode="after")
    def _exclude_each_other(self) -> LikelihoodRatioEntry:
        try:
            read_comparison(self.first, self.second)
        except QuantityError as found:
            raise fault(found.fix) from None
        return self


class AvoidableEntry(Table):
    """An entry of `avoidable`: a driver, the speed limit, and how the driver would have reacted."""

    vehicle: Literal["A", "B"] = Field(examples=['"B"'])
    limit: SpeedLimit
    reaction: ReactionTime
    deceleration: Deceleration
    seen_time: TimeBefore | None = None
    seen_distance: DistanceBefore | None = None
    clear: DistanceBefore | None = None

    @model_validator(mode="after")
    def _is_seen_once(self) -> AvoidableEntry:
        if self.seen_time and self.seen_distance:
            raise fault("the same twice; keep it, or seen_distance", "seen_time")
        return self


class QuestionsEntry(Table):
    """`[questions]`: the questions that are asked of the reconstruction."""

    exceeds: Annotated[Propositions, AfterValidator(_one_limit)] = Field(
        default=(), examples=['"speed_b > 45 mph"']
    )
    between: Annotated[Propositions, AfterValidator(_two_limits)] = Field(
        default=(), examples=['"40 mph < speed_b < 50 mph"']
    )
    likelihood_ratio: list[LikelihoodRatioEntry] = Field(
        default=[], max_length=_ASKED, examples=[f"[{{ first = {_FIRST}, second = {_SECOND} }}]"]
    )
    avoidable: list[AvoidableEntry] = Field(default=[], max_length=_ASKED, examples=[_AVOIDABLE])
    time_distance: Span | None = None
    corners: bool = Field(default=False, strict=True, examples=["true"])
    one_at_a_time: bool = Field(default=True, strict=True, examples=["false"])
    checks: bool = Field(default=True, strict=True, examples=["false"])
