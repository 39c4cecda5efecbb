"""Whether the impact was avoidable at the speed limit, and where both vehicles were before it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.scene.records import VEHICLES
from retrodict.studies.draws import NotAnswered, draws_of, error_of_mean

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.mechanics.avoidance import Approach
    from retrodict.scene.asked import Avoidance
    from retrodict.scene.measured import Measured

QUANTILES = (0.025, 0.5, 0.975)
_MOMENTS = 7  # of the table of times and distances


@dataclass(frozen=True, slots=True)
class Share:
    """A share of the draws and its Monte Carlo standard error, which is 0 where it is all or none."""

    value: float
    error: float


@dataclass(frozen=True, slots=True)
class Avoidability:
    """What would have been, had a driver kept to the speed limit (SI units).

    Args:
        asked: the question: driver, speed limit, reaction time and deceleration.
        too_fast: share of the draws in which the vehicle went faster than the limit.
        stopped: share in which it would have stopped before the point of impact.
        passed: share in which it would not, but the other vehicle would have been out of the way.
        avoided: share in which it would have stopped or the other vehicle been out of the way.
        distance: distance to the impact when the hazard could be perceived, m, at `QUANTILES`.
        stopping: distance to stop from the limit, reaction included, m, at `QUANTILES`.
        clear: distance that the other vehicle had still to travel at the impact to be out of the way,
            m, at `QUANTILES`.
        speed: speed at an impact that is not avoided, m/s, at `QUANTILES`; None where all are avoided.
    """

    asked: Avoidance
    too_fast: Share
    stopped: Share
    passed: Share
    avoided: Share
    distance: tuple[float, ...]
    stopping: tuple[float, ...]
    clear: tuple[float, ...]
    speed: tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class TimeDistance:
    """Where the vehicles were before the impact (SI units).

    Args:
        times: times before the impact, s, from the longest down to 0.
        distances: distance along the path to the position at the impact, m, by vehicle: `QUANTILES` at
            each time.
        speeds: speed, m/s, by vehicle: `QUANTILES` at each time.
    """

    times: tuple[float, ...]
    distances: dict[str, tuple[tuple[float, ...], ...]]
    speeds: dict[str, tuple[tuple[float, ...], ...]]


def avoidability(outcome: Outcome, asked: Avoidance) -> Avoidability:
    """Whether a driver who kept to the limit would have avoided the impact, draw by draw.

    Each posterior draw is joined by one of the reaction time and one of the deceleration. The hazard
    is perceived where it was in that draw; from there the vehicle goes on at the limit, or at its own
    speed where that was lower, and brakes after the reaction time. The other vehicle moves as it did,
    and goes on at its speed at the impact; a barrier never clears the way.

    Args:
        outcome: the reconstruction.
        asked: the question: driver, speed limit, reaction time and deceleration.

    Returns:
        Shares of the draws.

    Raises:
        NotAnswered: nothing says where the hazard could be perceived, or a speed has no draws.
    """
    from retrodict.mechanics.avoidance import arrival, distance_before, skid_time, time_before

    v = asked.vehicle
    motion = _approach(outcome, v)
    rng = np.random.default_rng([outcome.seed, 34, VEHICLES.index(v)])
    shape = np.shape(motion.speed)
    reaction, deceleration = (_random(m, shape, rng) for m in (asked.reaction, asked.deceleration))
    if asked.seen_distance:
        distance = _random(asked.seen_distance, shape, rng)
        time = np.asarray(time_before(motion, distance))
    else:
        if asked.seen_time:
            time = _random(asked.seen_time, shape, rng)
        elif outcome.scene.approach[v].skid_length:
            time = reaction + np.asarray(skid_time(motion))
        else:
            raise NotAnswered(
                f"nothing says where the driver of {v.upper()} could perceive the hazard: write "
                'seen_time = "2.5 ± 0.3 s" or seen_distance in questions.avoidable, or the skid in '
                f"vehicles.{v.upper()}.approach"
            )
        distance = np.asarray(distance_before(motion, time))
    speed = np.minimum(motion.initial, asked.limit)
    late, impact = map(np.asarray, arrival(distance, speed, reaction, deceleration))
    stopped = np.isinf(late)
    if outcome.scene.single:
        clear, passed = np.full(shape, np.inf), np.zeros(shape, bool)
    else:
        other = "b" if v == "a" else "a"
        clear = (
            _random(asked.clear, shape, rng)
            if asked.clear
            else _distance_to_clear(outcome, other, v)
        )
        # the product with an infinite delay of a vehicle that stands is no number, but then it stopped
        with np.errstate(invalid="ignore"):
            passed = ~stopped & (draws_of(outcome, f"speed_{other}") * (late - time) >= clear)
    struck = impact[~(stopped | passed)]
    return Avoidability(
        asked=asked,
        too_fast=_share(np.asarray(motion.initial) > asked.limit),
        stopped=_share(stopped),
        passed=_share(passed),
        avoided=_share(stopped | passed),
        distance=_quantiles(distance),
        stopping=_quantiles(asked.limit * reaction + asked.limit**2 / (2 * deceleration)),
        clear=_quantiles(clear),
        speed=_quantiles(struck) if struck.size else None,
    )


def time_distance(outcome: Outcome, span: float) -> TimeDistance:
    """Where the vehicles were before the impact, and how fast.

    Args:
        outcome: the reconstruction.
        span: time before the impact at which the table begins, s.

    Returns:
        Quantiles over the draws.

    Raises:
        NotAnswered: a speed has no draws.
    """
    from retrodict.mechanics.avoidance import distance_before, skid_time

    times = np.linspace(span, 0.0, _MOMENTS)
    distances, speeds = {}, {}
    for v in outcome.scene.vehicles:
        motion = _approach(outcome, v)
        skidding = np.asarray(skid_time(motion))
        share = [np.minimum(time / np.where(skidding > 0, skidding, 1e-9), 1) for time in times]
        distances[v] = tuple(
            _quantiles(np.asarray(distance_before(motion, time))) for time in times
        )
        speeds[v] = tuple(
            _quantiles(np.asarray(motion.speed + each * (motion.initial - motion.speed)))
            for each in share
        )
    return TimeDistance(tuple(map(float, times)), distances, speeds)


def _approach(outcome: Outcome, v: str) -> Approach:
    from retrodict.mechanics.avoidance import Approach  # imports jax

    speed = draws_of(outcome, f"speed_{v}")
    if not outcome.scene.approach[v].skid_length:
        return Approach(speed, speed, np.zeros_like(speed))
    return Approach(
        speed, draws_of(outcome, f"travelling_speed_{v}"), draws_of(outcome, f"skid_{v}")
    )


def _distance_to_clear(outcome: Outcome, other: str, v: str) -> np.ndarray:
    """How far a vehicle had to go on at the impact to leave the strip that `v` sweeps, m."""
    from retrodict.mechanics.avoidance import distance_to_clear, half_extent

    x, y, half = {}, {}, []
    across = draws_of(outcome, f"direction_{v}")
    for each in (other, v):
        vehicle = outcome.scene.vehicles[each]
        heading = draws_of(outcome, f"heading_{each}")
        angle = heading + draws_of(outcome, f"impact_angle_{each}")
        lever = draws_of(outcome, f"impact_distance_{each}")
        ahead = (vehicle.front_axle.value - vehicle.rear_axle.value) / 2  # middle of the outline
        x[each] = ahead * np.cos(heading) - lever * np.cos(angle)
        y[each] = ahead * np.sin(heading) - lever * np.sin(angle)
        half.append(half_extent(vehicle.length, vehicle.width, heading, across))
    offset = (y[other] - y[v]) * np.cos(across) - (x[other] - x[v]) * np.sin(across)
    rate = np.sin(draws_of(outcome, f"direction_{other}") - across)
    return np.asarray(distance_to_clear(offset, half[0] + half[1], rate))


def _random(m: Measured, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Draws of a lognormal quantity of this mean and sd."""
    scale = np.sqrt(np.log1p((m.sd / m.value) ** 2))
    return m.value * np.exp(scale * rng.standard_normal(shape) - scale**2 / 2)


def _share(holds: np.ndarray) -> Share:
    value = float(holds.mean())
    return Share(value, error_of_mean(holds.astype(float)) if 0 < value < 1 else 0.0)


def _quantiles(values: np.ndarray) -> tuple[float, ...]:
    return tuple(map(float, np.quantile(values, QUANTILES, method="inverted_cdf")))
