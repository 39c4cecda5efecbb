"""The posterior's recorded motions, from before the impact to rest."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from retrodict.scene.names import vehicle_of
from retrodict.studies.draws import draws_of

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome


class NoMotion(ValueError):
    """There is no such motion; the message says which there are."""


@dataclass(frozen=True, slots=True)
class Motion:
    """The motion of the vehicles in one draw, keyed by vehicle (SI units, radians).

    Args:
        number: number of the draw among those whose motion is recorded, from 1.
        before: velocity just before the impact, shape (2,).
        speed: speed just before the impact, m/s.
        time: times after the impact, shape (steps,), ascending from 0.
        pose: x, y and heading at these times, shape (steps, 3); the last is the rest pose.
        skid: speed before the skid, m/s, and length of the skid, m, of vehicles that skidded up to the
            impact.
    """

    number: int
    before: dict[str, np.ndarray]
    speed: dict[str, float]
    time: dict[str, np.ndarray]
    pose: dict[str, np.ndarray]
    skid: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def lasts(self) -> float:
        """Time until all are at rest, s."""
        return max(float(time[-1]) for time in self.time.values())

    def pose_at(self, v: str, time: float) -> tuple[float, float, float]:
        """Pose of a vehicle at a time (s) after the impact; at rest after its last."""
        ((x, y, heading),) = self.poses(v, np.array([time])).tolist()
        return x, y, heading

    def poses(self, v: str, time: np.ndarray) -> np.ndarray:
        """Poses of a vehicle, shape (n, 3), at times (n,) after the impact, negative ones before it.

        Before the impact it moves straight, with its heading at impact: at constant speed, and along
        its skid slowing down evenly.
        """
        poses = np.stack(
            [np.interp(time, self.time[v], column) for column in self.pose[v].T], axis=1
        )
        poses[:, :2] -= self._back(v, -np.minimum(time, 0.0))[:, None] * self.before[v]
        return poses

    def _back(self, v: str, time: np.ndarray) -> np.ndarray:
        """How far back a vehicle was at times before the impact, over its speed at the impact; s."""
        speed = self.speed[v]
        if v not in self.skid or speed <= 0:
            return time
        from retrodict.mechanics.avoidance import Approach, distance_before  # imports jax

        return np.asarray(distance_before(Approach(speed, *self.skid[v]), time)) / speed


def motions(outcome: Outcome, count: int | None = None) -> tuple[Motion, ...]:
    """Motions of draws, spread evenly over the ranks of the sought speed (`Scene.sought`).

    Args:
        outcome: the reconstruction.
        count: number of motions; an odd number has the median in its middle. None for all that are
            recorded.

    Returns:
        The slowest first; fewer where fewer run-outs are recorded, none where none is.
    """
    tree = outcome.idata
    if "trajectories" not in tree.children:
        return ()
    data = tree["trajectories"].to_dataset()
    if not {"path", "time", "before"} <= set(data.variables):
        return ()  # of a version before these were recorded
    pose = data["path"].transpose("run", "vehicle", "step", "pose").values
    time = data["time"].transpose("run", "vehicle", "step").values
    before = data["before"].transpose("run", "vehicle", "axis").values
    finite = [np.isfinite(each).reshape(len(each), -1).all(axis=1) for each in (pose, time, before)]
    speed = np.hypot(*before.transpose(2, 0, 1))
    whole = np.flatnonzero(np.all(finite, axis=0))
    vehicles = tuple(outcome.scene.vehicles)
    sought = vehicles.index(str(vehicle_of(outcome.scene.sought)))
    ranked = whole[np.argsort(speed[whole, sought], kind="stable")]
    count = len(ranked) if count is None else min(count, len(ranked))
    shares = (np.arange(count) + 0.5) / max(count, 1)
    skids = _skids(outcome, speed)
    return tuple(
        Motion(
            number=int(run) + 1,
            before={v: before[run, i] for i, v in enumerate(vehicles)},
            speed={v: float(speed[run, i]) for i, v in enumerate(vehicles)},
            time={v: time[run, i] for i, v in enumerate(vehicles)},
            pose={v: pose[run, i] for i, v in enumerate(vehicles)},
            skid={v: (float(own[run, 0]), float(own[run, 1])) for v, own in skids.items()},
        )
        for run in ranked[(shares * len(ranked)).astype(int)]
    )


def _skids(
    outcome: Outcome, speed: Float[np.ndarray, "runs vehicles"]
) -> dict[str, Float[np.ndarray, "runs 2"]]:
    """Speed before the skid and its length in the draw of each run, of vehicles that skidded."""
    if not outcome.scene.skidded or "posterior" not in outcome.idata.children:
        return {}
    draws = outcome.idata["posterior"]
    off = np.zeros((len(speed), draws.sizes["chain"] * draws.sizes["draw"]))
    for own, v in zip(speed.T, outcome.scene.vehicles, strict=True):
        if f"speed_{v}" in draws.data_vars:
            off += np.abs(own[:, None] - draws_of(outcome, f"speed_{v}").ravel())
    place = np.argmin(off, axis=1)
    found = {}
    for v in outcome.scene.skidded:
        if f"travelling_speed_{v}" in draws.data_vars:
            length = draws_of(outcome, f"skid_{v}").ravel()
            travelling = draws_of(outcome, f"travelling_speed_{v}").ravel()
            found[v] = np.stack([travelling[place], length[place]], axis=1)
    return found


def motion_of(found: tuple[Motion, ...], which: str | int) -> Motion:
    """One of the recorded motions.

    Args:
        found: all recorded motions, the slowest first.
        which: "median" or a percentage such as "5%" of the sought speed, or a draw's number.

    Returns:
        The motion.

    Raises:
        NoMotion: there is none.
    """
    if not found:
        raise NoMotion("no motion of a draw is recorded in the result; leave motion out")
    text = "50%" if which == "median" else str(which).replace(" ", "")
    if percent := re.fullmatch(r"(\d{1,3}(?:\.\d+)?)%", text):
        share = float(percent[1]) / 100
        if share <= 1:
            return found[min(int(share * len(found)), len(found) - 1)]
    for motion in found:
        if text == str(motion.number):
            return motion
    numbers = [motion.number for motion in found]
    raise NoMotion(
        f"no draw {str(which)[:40]!r}: write median, a percentage of the sought speed such as 5%, or "
        f"the number of a draw whose motion is recorded, of {min(numbers)} to {max(numbers)}"
    )


def place_of(outcome: Outcome, motion: Motion) -> tuple[int, int] | None:
    """Chain and draw of the posterior, from 0, whose motion this is; None where they do not show.

    Args:
        outcome: the reconstruction that the motion is recorded in.
        motion: recorded motion whose draw is looked up.
    """
    if "posterior" not in outcome.idata.children:
        return None
    draws = outcome.idata["posterior"]
    if not {"vbx", "vby"} <= set(draws.data_vars):
        return None
    x, y = (draws[name].transpose("chain", "draw").values for name in ("vbx", "vby"))
    off = np.hypot(x - motion.before["b"][0], y - motion.before["b"][1])
    chain, draw = np.unravel_index(np.argmin(off), off.shape)
    return (int(chain), int(draw)) if off[chain, draw] < 1e-6 else None
