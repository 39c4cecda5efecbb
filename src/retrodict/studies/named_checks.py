"""The named checks of the field, measured against predicted in standard deviations."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.scene.records import VEHICLES
from retrodict.studies.draws import NotAnswered, draws_of

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Items
    from retrodict.studies.conflict import LeftOut


@dataclass(frozen=True, slots=True)
class NamedCheck:
    """One check (SI units, radians).

    Args:
        name: name of the check.
        of: quantity that is compared, in words.
        dimension: dimension of that quantity, a key for `unit_of`.
        predicted, predicted_sd: posterior mean and sd; for a measured delta-v or a stated energy, those
            predicted from all else.
        measured, measured_sd: measured value and its sd; None where nothing was measured.
        off: measured less predicted, in standard deviations of both; None where that is not known.
        note: remark on the check; empty where there is none.
    """

    name: str
    of: str
    dimension: str
    predicted: float
    predicted_sd: float
    measured: float | None = None
    measured_sd: float | None = None
    off: float | None = None
    note: str = ""


def named_checks(outcome: Outcome, left_out: tuple[LeftOut, ...]) -> tuple[NamedCheck, ...]:
    """Common velocity, delta-v, PDOF, energy and Newton's third law.

    Args:
        outcome: the reconstruction.
        left_out: leave-one-out prediction of each item of evidence.

    Returns:
        The checks that the model's quantities allow.

    Raises:
        NotAnswered: the model has none of the quantities.
    """
    found: list[NamedCheck] = []
    for check in (_common_velocity, _delta_v, _pdof, _energy, _third_law):
        try:
            found += check(outcome, {item.name: item for item in left_out})
        except NotAnswered:  # a simpler model has no such quantity
            continue
    if not found:
        raise NotAnswered("the model has none of the quantities that they compare")
    return tuple(found)


def _common_velocity(outcome: Outcome, _: dict[str, LeftOut]) -> Iterator[NamedCheck]:
    """The contact points' relative velocity after the impact, which a common velocity makes zero."""
    vehicles = tuple(outcome.scene.vehicles)
    V_x, V_y = ([draws_of(outcome, f"V{v}{axis}") for v in vehicles] for axis in "xy")
    apart = []
    for i, v in enumerate(vehicles):
        angle = draws_of(outcome, f"heading_{v}") + draws_of(outcome, f"impact_angle_{v}")
        lever, Omega = draws_of(outcome, f"impact_distance_{v}"), draws_of(outcome, f"Omega_{v}")
        apart.append(
            np.array(
                [V_x[i] - Omega * lever * np.sin(angle), V_y[i] + Omega * lever * np.cos(angle)]
            )
        )
    x, y = apart[0] - apart[1] if len(apart) > 1 else apart[0]  # a barrier stands still
    Gamma = draws_of(outcome, "Gamma")
    for words, speed, cause in (
        (
            "speed at which the contact points part",
            np.abs(x * np.cos(Gamma) + y * np.sin(Gamma)),
            "restitution",
        ),
        (
            "speed at which they still slide",
            np.abs(y * np.cos(Gamma) - x * np.sin(Gamma)),
            "friction that does not end the sliding",
        ),
    ):
        note = f"a common velocity would make it 0; it is what {cause} leaves"
        yield NamedCheck("common velocity", words, "speed", *_moments(speed), note=note)


def _delta_v(outcome: Outcome, left_out: dict[str, LeftOut]) -> Iterator[NamedCheck]:
    """Each measured delta-v, against what all else says of it; else the predicted one."""
    labels = {"": "of {}", "_forward": "of {} forward", "_left": "of {} to the left"}
    for v in outcome.scene.vehicles:
        items = [
            (label, left_out[f"departure_delta_v{part}_{v}"])
            for part, label in labels.items()
            if f"departure_delta_v{part}_{v}" in left_out
        ]
        for label, item in items:
            yield _left_out("delta-v", label.format(v.upper()), "speed", item)
        if not items:
            mean, sd = _moments(draws_of(outcome, f"delta_v_{v}"))
            yield NamedCheck("delta-v", f"of {v.upper()}", "speed", mean, sd)


def _pdof(outcome: Outcome, _: dict[str, LeftOut]) -> Iterator[NamedCheck]:
    """The principal direction of force on each vehicle, clockwise from straight ahead."""
    change = _change_of_a(outcome)
    for v, sign in zip(outcome.scene.vehicles, (1.0, -1.0), strict=False):
        # the force acts along delta-v, so it comes from the opposite direction
        source = np.arctan2(-sign * change[1], -sign * change[0])
        angle = np.exp(1j * (draws_of(outcome, f"heading_{v}") - source))
        middle = float(np.angle(angle.mean()))
        sd = float(np.angle(angle * np.exp(-1j * middle)).std(ddof=1))
        measured = measured_sd = off = None
        recorded = outcome.scene.departure.get(v, {})
        forward, left = recorded.get("delta_v_forward"), recorded.get("delta_v_left")
        note = ""
        if forward and left:
            measured = math.atan2(left.value, -forward.value)
            size = math.hypot(forward.value, left.value)
            measured_sd = math.hypot(left.value * forward.sd, forward.value * left.sd) / size**2
            off = math.remainder(measured - middle, math.tau) / math.hypot(sd, measured_sd)
            note = "the recorded delta-v is part of the evidence"
        yield NamedCheck(
            "PDOF", f"force on {v.upper()}", "angle", middle, sd, measured, measured_sd, off, note
        )


def _left_out(name: str, subject: str, dimension: str, item: LeftOut) -> NamedCheck:
    """An item of evidence against what all else says of it."""
    sd = math.sqrt(max(item.expected_sd**2 - item.sd**2, 0.0))
    off = (item.value - item.expected) / item.expected_sd if item.reliable else None
    note = "predicted from all else" if item.reliable else "its weights cannot be relied on"
    return NamedCheck(name, subject, dimension, item.expected, sd, item.value, item.sd, off, note)


def _energy(outcome: Outcome, left_out: dict[str, LeftOut]) -> Iterator[NamedCheck]:
    """The kinetic energy lost, which deforms the vehicles: as stated, against what all else says."""
    if stated := left_out.get("impact_energy_lost"):
        yield _left_out("energy", "kinetic energy lost", "energy", stated)
        return
    lost = draws_of(outcome, "energy_lost")
    mean, sd = _moments(lost)
    gains = float((lost < 0).mean())
    note = "gained in none of the draws" if gains == 0 else f"gained in {gains:.1%} of the draws"
    yield NamedCheck("energy", "kinetic energy lost", "energy", mean, sd, note=note)


def _third_law(outcome: Outcome, _: dict[str, LeftOut]) -> Iterator[NamedCheck]:
    """Momentum that A took up against what B gave off: the model makes them equal."""
    if outcome.scene.barrier:  # what it took up shows nowhere
        return
    impulses = []
    for v in VEHICLES:
        size, mass = (
            _measured_change(outcome.scene.departure.get(v, {})),
            outcome.scene.vehicles[v].mass,
        )
        if size is not None:
            value, sd = size
            impulses.append((mass.value * value, math.hypot(mass.value * sd, mass.sd * value)))
    if len(impulses) == 2:
        (of_a, sd_a), (of_b, sd_b) = impulses
        sd = math.hypot(sd_a, sd_b)
        yield NamedCheck(
            "Newton's third law",
            "impulse on A less that on B",
            "impulse",
            0.0,
            0.0,
            of_a - of_b,
            sd,
            (of_a - of_b) / sd,
            "by each vehicle's measured delta-v",
        )
        return
    mean, sd = _moments(draws_of(outcome, "mass_a") * draws_of(outcome, "delta_v_a"))
    yield NamedCheck(
        "Newton's third law", "impulse on either", "impulse", mean, sd, note="equal by the model"
    )


def _change_of_a(outcome: Outcome) -> np.ndarray:
    """Change of A's velocity, x and y, m/s; B's has the opposite direction."""
    speed, direction = draws_of(outcome, "speed_a"), draws_of(outcome, "direction_a")
    return np.array(
        [
            draws_of(outcome, "Vax") - speed * np.cos(direction),
            draws_of(outcome, "Vay") - speed * np.sin(direction),
        ]
    )


def _measured_change(recorded: Items) -> tuple[float, float] | None:
    """A measured delta-v and its sd, m/s; None where its size was not measured."""
    if size := recorded.get("delta_v"):
        return size.value, size.sd
    forward, left = recorded.get("delta_v_forward"), recorded.get("delta_v_left")
    if not (forward and left):
        return None
    value = math.hypot(forward.value, left.value)
    return value, math.hypot(forward.value * forward.sd, left.value * left.sd) / value


def _moments(draws: np.ndarray) -> tuple[float, float]:
    return float(draws.mean()), float(draws.std(ddof=1))
