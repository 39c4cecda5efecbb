"""Rungs and ladders that nothing was run for."""

from __future__ import annotations

from retrodict.studies.comparison import Ladder, Reweighted, Step
from retrodict.studies.fit import Fit, Item, Summary
from retrodict.studies.ladder import chosen
from tests.report.conftest import make_scene

NAMES = ("low", "middle", "full")


def summary(median: float, sd: float) -> Summary:
    return Summary(
        median,
        sd,
        {level: (median - z * sd, median + z * sd) for level, z in ((50, 0.67), (90, 1.64), (95, 1.96))},
    )  # fmt: skip


def step(name: str, median: float, sd: float = 1.0, probability: float = 0.5, **changes) -> Step:
    items = (Item("rest_x_a", True, 0.4, 0.7), Item("rest_heading_b", False))
    return Step(
        name=name,
        **{
            "below": NAMES[: NAMES.index(name)],
            "answers": {"speed_b": summary(median, sd)},
            "fit": Fit(items, 1.2, 1.0, probability),
            "log_evidence": -12.3,
            "log_evidence_sd": 0.04,
            "parameters": 25,
            "seconds": 1.5 + NAMES.index(name),
            "priors": (Reweighted("flat", median, sd, 0.1),),
        }
        | changes,
    )


def ladder_of(*steps: Step) -> Ladder:
    judged, choice, reason = chosen(steps, ("speed_b",))
    return Ladder(make_scene(), ("speed_b",), judged, choice, reason, seed=0)
