"""A few of the posterior's motions, from before the impact to rest, for the pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.scene.records import VEHICLES

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome


@dataclass(frozen=True, slots=True)
class Motion:
    """The motion of both vehicles in one draw, keyed by vehicle (SI units, radians).

    Args:
        before: velocity just before the impact, shape (2,).
        speed: its size.
        time: after the impact, shape (steps,), ascending from 0.
        pose: x, y and heading at these times, shape (steps, 3); the last is the rest.
    """

    before: dict[str, np.ndarray]
    speed: dict[str, float]
    time: dict[str, np.ndarray]
    pose: dict[str, np.ndarray]

    @property
    def lasts(self) -> float:
        """Time until both are at rest, s."""
        return max(float(time[-1]) for time in self.time.values())

    def pose_at(self, v: str, time: float) -> tuple[float, float, float]:
        """Pose of a vehicle at a time (s) after the impact; at rest after its last."""
        x, y, heading = (np.interp(time, self.time[v], column) for column in self.pose[v].T)
        return float(x), float(y), float(heading)


def motions(outcome: Outcome, count: int) -> tuple[Motion, ...]:
    """Motions of draws, spread evenly over the ranks of B's speed before impact.

    Args:
        outcome: the reconstruction.
        count: how many; an odd number has the median in its middle.

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
    ranked = whole[np.argsort(speed[whole, 1], kind="stable")]
    shares = (np.arange(min(count, len(ranked))) + 0.5) / max(min(count, len(ranked)), 1)
    return tuple(
        Motion(
            before={v: before[run, i] for i, v in enumerate(VEHICLES)},
            speed={v: float(speed[run, i]) for i, v in enumerate(VEHICLES)},
            time={v: time[run, i] for i, v in enumerate(VEHICLES)},
            pose={v: pose[run, i] for i, v in enumerate(VEHICLES)},
        )
        for run in ranked[(shares * len(ranked)).astype(int)]
    )
