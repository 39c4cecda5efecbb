"""Reaction, braking and clearing, against the constant-acceleration relations that they solve."""

import numpy as np
import pytest

from retrodict.mechanics.avoidance import (
    Approach,
    arrival,
    distance_before,
    distance_to_clear,
    half_extent,
    time_before,
)


def test_a_vehicle_stops_where_the_stopping_distance_is_at_most_the_distance():
    """v t + v² / (2 a): 20 m/s, 1.5 s and 8 m/s² take 30 + 25 m."""
    late, early = arrival(54.9, 20.0, 1.5, 8.0), arrival(55.1, 20.0, 1.5, 8.0)
    assert early.time == np.inf
    assert early.speed == 0
    assert np.isfinite(late.time)
    assert late.speed == pytest.approx(np.sqrt(2 * 8 * 0.1))


def test_a_vehicle_that_does_not_stop_obeys_v_t_minus_a_t_squared_over_two():
    speed, reaction, braking, distance = 20.0, 1.2, 7.0, np.array([10.0, 24.0, 30.0, 45.0])
    found = arrival(distance, speed, reaction, braking)
    after = np.maximum(np.asarray(found.time) - reaction, 0)
    assert speed * np.asarray(found.time) - braking * after**2 / 2 == pytest.approx(distance)
    assert np.asarray(found.speed) == pytest.approx(speed - braking * after)


@pytest.mark.parametrize("skid", [0.0, 12.0])
def test_time_and_distance_before_the_impact_are_inverse(skid):
    motion = Approach(15.0, np.sqrt(15.0**2 + 2 * 7 * skid), skid)
    times = np.linspace(0.05, 4, 20)
    distances = distance_before(motion, times)
    assert np.asarray(time_before(motion, distances)) == pytest.approx(times)


def test_the_skid_ends_at_the_speed_at_impact_and_begins_at_that_before():
    motion = Approach(15.0, np.sqrt(15.0**2 + 2 * 7 * 12.0), 12.0)
    step = 1e-6
    early = (distance_before(motion, 4.0) - distance_before(motion, 4.0 - step)) / step
    assert distance_before(motion, step) / step == pytest.approx(15.0, rel=1e-5)
    assert early == pytest.approx(motion.initial, rel=1e-5)


def test_a_vehicle_is_clear_when_its_outline_has_left_the_strip():
    # a 4.5 m by 1.8 m car crosses at a right angle the strip of a car 1.8 m wide
    half = half_extent(4.5, 1.8, np.pi / 2, 0.0) + half_extent(4.5, 1.8, 0.0, 0.0)
    assert half == pytest.approx(2.25 + 0.9)
    assert distance_to_clear(-1.0, half, 1.0) == pytest.approx(4.15)
    assert distance_to_clear(1.0, half, 1.0) == pytest.approx(2.15)
    assert distance_to_clear(-1.0, half, -1.0) == pytest.approx(2.15)
    assert distance_to_clear(4.0, half, 1.0) == 0
    assert distance_to_clear(1.0, half, 0.0) == np.inf
