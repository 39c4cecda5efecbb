"""A few motions stand for the posterior's: whole, in the order of B's speed."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from retrodict.findings.run_outs import motions


def test_motions_are_spread_over_the_ranks_of_speed(outcome):
    data = outcome.idata["trajectories"]
    speed = np.sort(np.hypot(*data["before"].sel(vehicle="b").transpose("axis", "run").values))
    found = motions(outcome, 5)
    assert [m.speed["b"] for m in found] == pytest.approx(speed[[6, 18, 30, 42, 54]])
    assert [m.speed["b"] for m in motions(outcome, 1)] == pytest.approx(speed[[30]])
    assert len(motions(outcome, 100)) == 60


def test_poses_between_rows_are_interpolated_and_rest_stays(outcome):
    (motion,) = motions(outcome, 1)
    pose, time = motion.pose["b"], motion.time["b"]
    assert motion.pose_at("b", time[7]) == pytest.approx(pose[7])
    assert motion.pose_at("b", (time[7] + time[8]) / 2) == pytest.approx(pose[7:9].mean(axis=0))
    assert motion.pose_at("b", motion.lasts + 1) == pytest.approx(pose[-1])


def test_a_run_out_that_is_not_finite_is_left_out(outcome):
    tree = outcome.idata.copy()
    data = tree["trajectories"].to_dataset().copy(deep=True)
    data["path"][:40] = np.nan
    tree["trajectories"] = xr.DataTree(data)
    holed = replace(outcome, idata=tree)
    assert len(motions(holed, 100)) == 20


def test_results_of_an_earlier_version_have_no_motions(outcome):
    tree = outcome.idata.copy()
    tree["trajectories"] = xr.DataTree(tree["trajectories"].to_dataset().drop_vars("time"))
    assert motions(replace(outcome, idata=tree), 5) == ()
    assert motions(replace(outcome, idata=xr.DataTree()), 5) == ()
