"""What would have been at the speed limit: against closed form where nothing is uncertain."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from retrodict.scene.asked import Avoidance
from retrodict.scene.measured import Measured
from retrodict.studies.avoidability import avoidability, time_distance
from retrodict.studies.draws import NotAnswered
from tests.studies.gaussian import exact, outcome

LIMIT, REACTION, BRAKING, SPEED = 15.0, 1.2, 7.5, 20.0


def constant(value: float) -> np.ndarray:
    return np.full((4, 50), value)


def crossing(skid: float | None = None, **draws: np.ndarray):
    """B drives along x into the side of A, which drives along y at 10 m/s; all is exact."""
    made = outcome(
        **{
            "speed_a": constant(10.0),
            "speed_b": constant(SPEED),
            "direction_a": constant(np.pi / 2),
            "direction_b": constant(0.0),
        }
        | ({"skid_b": constant(skid)} if skid else {})
        | draws
    )
    scene = made.scene
    touching = {
        "a": (0.9, np.pi / 2, np.pi / 2),
        "b": (2.25, 0.0, 0.0),
    }  # lever, its angle, heading
    vehicles = {
        v: replace(
            scene.vehicles[v],
            impact_distance=exact(lever),
            impact_angle=exact(angle),
            heading=exact(heading),
            front_axle=exact(1.3),
            rear_axle=exact(1.3),
            length=4.5,
            width=1.8,
        )
        for v, (lever, angle, heading) in touching.items()
    }
    approach = scene.approach
    if skid:
        approach = approach | {"b": replace(approach["b"], skid=exact(skid))}
    return replace(made, scene=replace(scene, vehicles=vehicles, approach=approach))


def asked(**changes) -> Avoidance:
    return Avoidance("b", LIMIT, exact(REACTION), exact(BRAKING), **changes)


def delay(distance: float) -> float:
    """By how much later B is there at the limit than at its speed; infinite where it stops."""
    left = distance - LIMIT * REACTION
    square = LIMIT**2 - 2 * BRAKING * left
    if square <= 0:
        return np.inf
    return REACTION + (LIMIT - np.sqrt(square)) / BRAKING - distance / SPEED


# v t + v² / (2 a) = 18 + 15 m; A must go on 2.25 + 0.9 m at 10 m/s to leave B's strip: 0.315 s
STOPPING, CLEARING = 33.0, 0.315


@pytest.mark.parametrize("distance", [18.0, 25.0, 28.0, 32.9, 33.1, 50.0])
def test_without_uncertainty_it_is_the_closed_form(distance):
    found = avoidability(crossing(), asked(seen_distance=exact(distance)))
    stops = distance >= STOPPING
    assert found.stopping == pytest.approx((STOPPING,) * 3)
    assert found.clear == pytest.approx((3.15,) * 3)
    assert (found.too_fast.value, found.stopped.value) == (1, stops)
    assert found.passed.value == (not stops and delay(distance) >= CLEARING)
    assert found.avoided.value == max(found.stopped.value, found.passed.value)
    if found.avoided.value == 0:
        speed = np.sqrt(LIMIT**2 - 2 * BRAKING * (distance - LIMIT * REACTION))
        assert found.speed == pytest.approx((speed,) * 3)
    else:
        assert found.speed is None


def test_the_cases_above_are_of_all_three_kinds():
    delays = [delay(d) for d in (18.0, 25.0, 28.0, 32.9, 33.1)]
    assert min(delays) < CLEARING
    assert any(CLEARING <= d < np.inf for d in delays)
    assert max(delays) == np.inf


def test_a_time_stands_for_the_distance_at_the_actual_speed():
    by_time = avoidability(crossing(), asked(seen_time=exact(1.4)))
    assert by_time.distance == pytest.approx((1.4 * SPEED,) * 3)


def test_without_either_the_driver_saw_the_hazard_a_reaction_time_before_the_skid():
    before = np.sqrt(SPEED**2 + 2 * 7.0 * 10.0)
    made = crossing(10.0, travelling_speed_b=constant(before))
    found = avoidability(made, asked())
    assert found.distance == pytest.approx((before * REACTION + 10.0,) * 3)


def test_at_its_own_speed_where_that_was_below_the_limit():
    slow = crossing(speed_b=constant(12.0))
    found = avoidability(slow, asked(seen_distance=exact(26.0)))
    assert found.too_fast.value == 0
    assert found.stopped.value == (12.0 * REACTION + 144 / 15 <= 26.0)


def test_where_nothing_says_what_could_be_seen_it_is_not_answered():
    with pytest.raises(NotAnswered, match="seen_time"):
        avoidability(crossing(), asked())


def test_a_share_is_the_probability_that_the_stopping_distance_is_short_enough():
    """With a deceleration alone uncertain: P(a >= v² / (2 (d - v t))), lognormal."""
    many = crossing(
        **{
            "speed_a": np.full((4, 5000), 10.0),
            "speed_b": np.full((4, 5000), SPEED),
            "direction_a": np.full((4, 5000), np.pi / 2),
            "direction_b": np.full((4, 5000), 0.0),
        }
    )
    braking = Measured(BRAKING, 0.8, "lognormal")
    found = avoidability(many, replace(asked(seen_distance=exact(34.0)), deceleration=braking))
    scale = np.sqrt(np.log1p((0.8 / BRAKING) ** 2))
    law = stats.lognorm(scale, scale=BRAKING * np.exp(-(scale**2) / 2))
    wanted = law.sf(LIMIT**2 / (2 * (34.0 - LIMIT * REACTION)))
    assert found.stopped.value == pytest.approx(wanted, abs=4 * found.stopped.error)
    assert found.stopped.error < 0.005


def test_distances_before_the_impact_are_those_of_the_motion():
    before = np.sqrt(SPEED**2 + 2 * 7.0 * 10.0)
    found = time_distance(crossing(10.0, travelling_speed_b=constant(before)), 3.0)
    assert found.times == pytest.approx(np.linspace(3, 0, 7))
    skidding = (before - SPEED) / 7.0
    for time, a, b, speed in zip(
        found.times, found.distances["a"], found.distances["b"], found.speeds["b"], strict=True
    ):
        assert a == pytest.approx((10.0 * time,) * 3)
        within = min(time, skidding)
        assert b == pytest.approx(
            (SPEED * within + 3.5 * within**2 + before * (time - within),) * 3
        )
        assert speed == pytest.approx((SPEED + 7.0 * within,) * 3)
