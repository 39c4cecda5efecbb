"""Vehicles that touch again: outlines against linear programmes, motions of known times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import linprog

from retrodict.findings.run_outs import Motion, motions
from retrodict.findings.second_contact import gap, second_contact, touched_again
from retrodict.findings.sentences import simplifications
from retrodict.report.figures.plan_geometry import outline
from tests.shared.scenes import collision

SCENE = collision()
CARS = SCENE.vehicles


def share_a_point(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two convex polygons meet: whether a point is a mean of the corners of both."""
    n, m = len(one), len(other)
    equal = np.block([[one.T, -other.T], [np.ones(n), np.zeros(m)], [np.zeros(n), np.ones(m)]])
    found = linprog(np.zeros(n + m), A_eq=equal, b_eq=[0, 0, 1, 1], method="highs")
    return bool(found.status == 0)


def test_outlines_overlap_where_they_share_a_point() -> None:
    rng = np.random.default_rng(0)
    poses = [rng.uniform([-3, -3, -4], [3, 3, 4], (300, 3)) for _ in CARS]
    apart = gap((CARS["a"], poses[0]), (CARS["b"], poses[1]))
    assert 50 < (apart < 0).sum() < 280
    for distance, a, b in zip(apart, *poses, strict=True):
        bodies = [outline(CARS[v], tuple(at))[:4] for v, at in (("a", a), ("b", b))]
        assert share_a_point(*bodies) == (distance < 0)


def test_the_gap_of_parallel_bodies_is_the_distance_between_them() -> None:
    side = (CARS["a"].width + CARS["b"].width) / 2
    pose = np.array([[0.0, 0.0, 0.3]])
    across = np.array([[-np.sin(0.3), np.cos(0.3), 0.0]])
    for distance in (-0.4, 0.0, 1.5):
        found = gap((CARS["a"], pose), (CARS["b"], pose + (side + distance) * across))
        assert found == pytest.approx(distance)


def moved(time: list[float], distance: list[float]) -> Motion:
    """A stands; B, beside it and parallel, is so far off (m) at these times (s)."""
    side = (CARS["a"].width + CARS["b"].width) / 2
    clock, stands = np.array(time), np.zeros((len(time), 3))
    beside = stands.copy()
    beside[:, 1] = side + np.array(distance)
    still, slow = {v: np.zeros(2) for v in CARS}, dict.fromkeys(CARS, 0.0)
    return Motion(1, still, slow, dict.fromkeys(CARS, clock), {"a": stands, "b": beside})


def test_a_second_contact_is_seen_when_it_comes_and_as_fast_as_it_is() -> None:
    """Crush of 0.2 m, half a metre apart after 0.5 s, and back at 1 m/s: together at 1 s."""
    found = touched_again(SCENE, moved([0, 0.5, 1.2, 2.0], [-0.2, 0.5, -0.2, -0.2]))
    assert found is not None
    assert found[:2] == pytest.approx((1.01, 1.0), abs=0.011)
    side = (CARS["a"].width + CARS["b"].width) / 2
    assert found[2] == pytest.approx((0.0, side / 2), abs=0.011)


def test_a_side_that_swings_into_the_other_before_they_part_is_one_too() -> None:
    found = touched_again(SCENE, moved([0, 0.5, 1.0, 2.0], [-0.5, -0.1, -0.4, -0.4]))
    assert found is not None
    assert found[1] == pytest.approx(0.6)


@pytest.mark.parametrize(
    "distance",
    [
        [-0.3, 0.5, 3.0, 3.0],
        [-0.3, -0.2, -0.28, -0.28],
        [-0.3, 0.5, 0.05, 0.05],
        [0.0, 0.0, 0.0, 0.0],
        [-0.2, -0.6, -0.2, 1.0],
        [-0.2, -0.6, -0.6, -0.6],
    ],
    ids=["parted", "crushed together", "near", "touching", "deeper, then apart", "deeper"],
)
def test_without_one_none_is_seen(distance: list[float]) -> None:
    assert touched_again(SCENE, moved([0, 0.5, 1.0, 2.0], distance)) is None


def test_a_reconstruction_says_in_what_share_of_its_motions_and_when(outcome) -> None:
    """In a third of the motions B comes back to where A stands."""
    assert second_contact(outcome) is None
    tree = outcome.idata.copy()
    data = tree["trajectories"].to_dataset().copy(deep=True)
    path = data["path"].transpose("run", "vehicle", "step", "pose").values.copy()
    a, b = (list(data["vehicle"].values).index(v) for v in "ab")
    path[:20, b, -1] = path[:20, a, -1]
    data["path"] = (("run", "vehicle", "step", "pose"), path)
    tree["trajectories"] = xr.DataTree(data)
    back = replace(outcome, idata=tree)
    found = second_contact(back)
    assert found is not None
    assert (found.share, found.motions) == (20 / 60, 60)
    assert len(found.places) == 20
    lasts = max(each.lasts for each in motions(back))
    assert 0 < found.first <= found.last < lasts
    (sentence,) = set(simplifications(back)) - set(simplifications(outcome))
    assert sentence.startswith("In 33% of 60 motions drawn from the posterior the outlines of A")
    assert sentence.endswith("a second contact is not modelled.")


def test_where_a_barrier_was_struck_there_is_no_other(outcome) -> None:
    alone = replace(outcome.scene, vehicles={"a": outcome.scene.vehicles["a"]})
    assert second_contact(replace(outcome, scene=alone)) is None
