"""The sentences: the answer, the verdict of the checks, and what is taken for granted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from retrodict.findings.rounding import format_value
from retrodict.findings.second_contact import second_contact
from retrodict.findings.statistics import Quantity, scaled
from retrodict.findings.suspected_contact import suspected_contact
from retrodict.inference.digits import decimals_of, rhat_text
from retrodict.inference.misfit import UNEXPLAINED, UNSUPPORTED
from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.names import parsed
from retrodict.scene.plausibility import assumed_approach
from retrodict.scene.quantities import Unit, Units, unit_of
from retrodict.scene.records import VEHICLES

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Scene

MARK = "†"
WITHHELD = "withheld"
NOT_TO_BE_RELIED_ON = "NOT TO BE RELIED ON"


_ASKED = {
    "e": "the restitution e",
    "mu": "the equivalent friction μ",
    "e_m": "the impact moment coefficient e_m",
}


def question(outcome: Outcome) -> str:
    """What a scene asks, in words.

    Args:
        outcome: the reconstruction.

    Returns:
        A question on the speeds, if one is asked, and one on the impact.
    """
    asked = outcome.scene.question
    speeds = [v.upper() for v in VEHICLES if f"speed_{v}" in asked]
    impact = [words for name, words in _ASKED.items() if name in asked]
    parts = []
    if speeds:
        before = "" if outcome.scene.alone else " before the impact"
        parts.append(f"How fast did {_and(f'vehicle {v}' for v in speeds)} travel{before}?")
    if impact:
        parts.append(f"What {'was' if len(impact) == 1 else 'were'} {_and(impact)}?")
    return " ".join((*parts, "The answer rests on what was measured, as listed below."))


def _and(words: Iterable[str]) -> str:
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def answer(outcome: Outcome, quantities: Mapping[str, Quantity], units: Units) -> str:
    """The answer, a sentence a speed: each that was sought with its 95 % interval, or why not.

    Args:
        outcome: the reconstruction.
        quantities: statistics of the quantities, by name; a speed that is missing counts as withheld.
        units: system of units that comes first; both are given.

    Returns:
        The sentences, those on A first.
    """
    sought = outcome.scene.reported()
    said = [
        _answer(outcome, quantities, units, v)
        for v in VEHICLES
        if f"speed_{v}" in sought or f"travelling_speed_{v}" in sought
    ]
    if any(UNEXPLAINED in flag for flag in outcome.checks.flags):
        said.append(
            f"But {UNEXPLAINED}: one of them, or the model, is wrong, and the speeds may be off by more "
            "than these intervals say."
        )
    said += [f"But {flag}." for flag in outcome.checks.flags if UNSUPPORTED in flag]
    return " ".join(said)


def _answer(outcome: Outcome, quantities: Mapping[str, Quantity], units: Units, v: str) -> str:
    """What a vehicle's speed was: before its skid, if it skidded, and at the impact."""
    who = f"Vehicle {v.upper()} ({outcome.scene.vehicles[v].name})"
    given = "given the model and the inputs below, with 95 % probability between"
    impact = _in_units(outcome, quantities.get(f"speed_{v}"), units)
    if v not in outcome.scene.travelled:
        if impact is None:
            return (
                f"{who}: its speed before impact is {WITHHELD}, because checks of the draws failed."
            )
        about, between = impact
        return f"{who} was travelling at about {about} before impact; {given} {between}."
    travelling = _in_units(outcome, quantities.get(f"travelling_speed_{v}"), units)
    if travelling is None:
        return (
            f"{who}: its speed before its skid is {WITHHELD}, because checks of the draws failed."
        )
    about, between = travelling
    said = f"{who} was travelling at about {about} before it skidded; {given} {between}."
    if outcome.scene.alone:
        return said
    if impact is not None and f"speed_{v}" in outcome.scene.reported():
        about, between = impact
        said += f" It struck at about {about}, with 95 % probability between {between}."
    return said


def _in_units(outcome: Outcome, found: Quantity | None, units: Units) -> tuple[str, str] | None:
    """A speed's median and the limits of its interval in all units; None where it is withheld."""
    if found is None or not (outcome.checks.passed and found.passed):
        return None
    # a court outside the United States reads km/h, which is no unit of the tables
    metric = [Unit("m/s", 1.0), Unit("km/h", 1 / 3.6)]
    us = [unit_of("speed", "us")]
    middle, between = [], []
    for unit in us + metric if units == "us" else metric + us:
        # one digit of the uncertainty: a sentence is quoted without its table
        sd, median = scaled(found.sd, unit.worth), scaled(found.median, unit.worth)
        decimals = _whole(decimals_of(sd, digits=1, error=scaled(found.error, unit.worth)))
        of_limits = _whole(decimals_of(sd, digits=1, error=scaled(found.errors[95], unit.worth)))
        low, high = (
            format_value(scaled(bound, unit.worth), of_limits) for bound in found.intervals[95]
        )
        middle.append(f"{format_value(median, decimals)} {unit.symbol}")
        between.append(f"{low} and {high} {unit.symbol}")
    return _first_and_rest(middle), _first_and_rest(between)


def _whole(decimals: int | None) -> int | None:
    """No speed is rounded to tens: 27 mph would read 30 beside 43 km/h."""
    return None if decimals is None else max(decimals, 0)


def _first_and_rest(texts: list[str]) -> str:
    return f"{texts[0]} ({'; '.join(texts[1:])})"


def verdict(outcome: Outcome) -> str:
    """The checks in one line.

    Args:
        outcome: the reconstruction.

    Returns:
        The verdict with the figures it rests on.
    """
    checks = outcome.checks
    words = "Checks passed" if checks.passed else f"Checks FAILED ({MARK} {NOT_TO_BE_RELIED_ON})"
    own = "" if checks.divergences is None else f"{checks.divergences} divergences, "
    if checks.pareto_k is not None:
        own = f"Pareto k {format_value(checks.pareto_k, 2)}, "
    text = (
        f"{words}: {own}R-hat at most {rhat_text(checks.max_rhat)}, "
        f"effective sample size at least {format_value(checks.min_ess_bulk, 0)} (bulk), "
        f"{format_value(checks.min_ess_tail, 0)} (tail)."
    )
    return text if outcome.complete else f"{text} The run was interrupted before its end."


_OF_CLASS = {
    "mass": "mass",
    "yaw_inertia": "yaw inertia",
    "front_axle": "centre of gravity to front axle",
    "rear_axle": "centre of gravity to rear axle",
    "track": "track",
}


def of_class(scene: Scene) -> tuple[str, ...]:
    """Quantities that are known by the vehicle's class alone, one line per vehicle.

    Args:
        scene: the measured scene.
    """
    found = []
    for v, vehicle in scene.vehicles.items():
        names = [
            words for key, words in _OF_CLASS.items() if getattr(vehicle, key).assumed == "value"
        ]
        if vehicle.kind and names:
            found.append(
                f"of vehicle {v.upper()} these were not measured, but are those of the library's "
                f"{vehicle.kind}, with the spread among such vehicles: {_and(names)}"
            )
    return tuple(found)


def simplifications(outcome: Outcome) -> tuple[str, ...]:
    """What of the scene the answer leaves out, or takes for granted though nobody wrote it.

    Args:
        outcome: the reconstruction.
    """
    scene = outcome.scene
    found = list(outcome.description.ignores)
    if along := assumed_approach(scene):
        found.append(along)
    slid = {*scene.rest, *scene.from_impact}
    locked = [v.upper() for v in scene.vehicles if v not in scene.rolling and v in slid]
    if locked:
        found.append(
            f"All wheels of {_and(locked)} are taken as locked on the way to rest, as none was written "
            "to roll."
        )
    if again := second_contact(outcome):
        found.append(again.sentence)
    if hidden := suspected_contact(outcome, again):
        found.append(hidden.sentence)
    return tuple(found)


def assumptions(outcome: Outcome) -> tuple[str, ...]:
    """What is taken for granted: by the model, of a class, and how far a run-out misses a car."""
    vehicles, found = outcome.scene.vehicles, list(outcome.description.assumptions)
    found += of_class(outcome.scene)
    missing = {name for name, m in outcome.scene.evidence().items() if m.model_sd}
    for v in sorted({parsed(name).vehicle for name in missing}):
        missed = vehicles[v].run_out_error
        long = f"{DEFAULTS['run_out_settled'].amount(0.0):g} m"
        of_each = (
            (
                missed.position,
                False,
                f"each coordinate of {v.upper()}'s place",
                0.01,
                "% of its way",
            ),
            (
                missed.heading,
                True,
                f"{v.upper()}'s heading",
                math.radians(1),
                f"deg after {long} of it",
            ),
        )
        found += [
            f"beyond what its inputs explain, the run-out misses {what} by "
            f"{format_value(m.value / worth, decimals_of(m.value / worth))} {unit} from the impact "
            f"(one standard deviation; {m.source or 'source not given'})"
            for m, turns, what, worth, unit in of_each
            if any(n[-1] == v and ("heading" in n) == turns for n in missing)
        ]
    return tuple(found)
