"""A few motions stand for the posterior's: whole, in the order of B's speed."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from retrodict.findings.run_outs import NoMotion, motion_of, motions, place_of


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


def test_a_vehicle_slows_down_along_its_skid(outcome):
    """From 14 to 10 m/s in 5 m, which take 2 · 5 / 24 s; 14 m/s before."""
    (motion,) = motions(outcome, 1)
    east = {v: np.array([10.0, 0.0]) for v in motion.before}
    motion = replace(motion, before=east, speed=dict.fromkeys(east, 10.0), skid={"a": (14.0, 5.0)})
    skidding = 2 * 5 / 24
    time = np.array([0.0, -skidding / 2, -skidding, -1.0])
    x, y, heading = (motion.poses("a", time) - motion.pose["a"][0]).T
    slowing = 4 / skidding
    half = 10 * skidding / 2 + slowing * (skidding / 2) ** 2 / 2
    assert x == pytest.approx([0, -half, -5, -5 - 14 * (1 - skidding)])
    assert y == pytest.approx(0)
    assert heading == pytest.approx(0)
    assert motion.poses("b", time)[:, 0] - motion.pose["b"][0, 0] == pytest.approx(10 * time)


def test_the_skid_of_a_motion_is_that_of_its_draw(sparse):
    draws = sparse.idata["posterior"]
    for motion in motions(sparse, 3):
        off = np.abs(np.ravel(draws["speed_b"]) - motion.speed["b"])
        travelling, length = motion.skid["b"]
        assert set(motion.skid) == {"b"}
        assert travelling in np.ravel(draws["travelling_speed_b"])
        assert length in np.ravel(draws["skid_b"])
        assert off.min() < 1.0


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


def test_a_motion_is_named_by_its_rank_in_speed_or_its_number(outcome):
    found = motions(outcome)
    assert motion_of(found, "median").number == motions(outcome, 1)[0].number  # the figures' one
    assert motion_of(found, "50%") is motion_of(found, "median")
    ranks = {m.number: rank for rank, m in enumerate(found)}
    assert [ranks[motion_of(found, each).number] for each in ("0%", "5%", "95 %", "100%")] == [
        0, 3, 57, 59,
    ]  # fmt: skip
    data = outcome.idata["trajectories"]["path"]
    for number in (1, 17, "60"):
        at_rest = data.isel(run=int(number) - 1, step=-1).sel(vehicle="b").values
        assert motion_of(found, number).pose["b"][-1] == pytest.approx(at_rest)


@pytest.mark.parametrize("which", ["0", 61, "101%", "-5%", "", "mean", "1.5", "5%%", "x" * 500])
def test_a_motion_that_there_is_not_is_refused_with_those_there_are(outcome, which):
    with pytest.raises(NoMotion, match="of 1 to 60") as refused:
        motion_of(motions(outcome), which)
    assert len(str(refused.value)) < 200


def test_without_motions_the_reason_is_given():
    with pytest.raises(NoMotion, match="no motion of a draw is recorded"):
        motion_of((), "median")


def test_before_the_impact_a_vehicle_comes_in_straight_at_its_speed(outcome):
    (motion,) = motions(outcome, 1)
    poses = motion.poses("b", np.array([-2.0, -1.0, 0.0, motion.time["b"][7], motion.lasts + 9]))
    assert poses[1, :2] - poses[0, :2] == pytest.approx(motion.before["b"])
    assert poses[2, :2] - poses[1, :2] == pytest.approx(motion.before["b"])
    assert poses[:3, 2] == pytest.approx(motion.pose["b"][0, 2])
    assert poses[2:] == pytest.approx(motion.pose["b"][[0, 7, -1]])


def test_a_motion_knows_its_draw_of_the_posterior(outcome):
    motion = motions(outcome, 1)[0]
    assert place_of(outcome, motion) is None  # of draws that are not its own
    tree = outcome.idata.copy()
    draws = tree["posterior"].to_dataset().copy(deep=True)
    draws["vbx"][2, 45], draws["vby"][2, 45] = motion.before["b"]
    tree["posterior"] = xr.DataTree(draws)
    assert place_of(replace(outcome, idata=tree), motion) == (2, 45)
