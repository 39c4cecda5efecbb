"""Whether the vehicles touch again after the impact, in the posterior's recorded motions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from retrodict.findings.run_outs import Motion, motions
from retrodict.scene.outlines import body_middle
from retrodict.scene.quantities import unit_of
from retrodict.scene.records import VEHICLES, Scene, Vehicle

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome

_BETWEEN = 0.01  # s between looks at the outlines
_AGAIN = 0.1  # m: outlines are no better known, and crush overlaps them at the impact already
_WORTH_SAYING = 0.05  # share of the motions


@dataclass(frozen=True, slots=True)
class SecondContact:
    """Motions in which the outlines of the vehicles, having moved apart, overlap again.

    Args:
        share: share of the recorded motions.
        motions: number of recorded motions.
        first, last: times of the earliest and the latest second contact after the impact, s.
        closing: median speed at which the outlines then close, m/s.
        places: x and y of the middle between the vehicles there, in each of these motions, m.
    """

    share: float
    motions: int
    first: float
    last: float
    closing: float
    places: tuple[tuple[float, float], ...] = ()

    @property
    def sentence(self) -> str:
        """What the reader of a report has to know of it."""
        when = f"{self.first:.1f} to {self.last:.1f} s"
        if f"{self.first:.1f}" == f"{self.last:.1f}":
            when = f"{self.first:.1f} s"
        mph = self.closing / unit_of("speed", "us").worth
        return (
            f"In {self.share:.0%} of {self.motions} motions drawn from the posterior the outlines of A "
            f"and B overlap again {when} after the impact, closing at {self.closing:.1f} m/s "
            f"({mph:.0f} mph): a second contact is not modelled."
        )


def second_contact(outcome: Outcome) -> SecondContact | None:
    """The second contacts in a reconstruction's recorded motions; None where they are too few to say.

    Args:
        outcome: the reconstruction.
    """
    if set(outcome.scene.vehicles) != set(VEHICLES):
        return None
    every = motions(outcome)
    found = [again for each in every if (again := touched_again(outcome.scene, each)) is not None]
    if not found or len(found) < _WORTH_SAYING * len(every):
        return None
    times, closing, places = zip(*found, strict=True)
    share, typical = len(found) / len(every), float(np.median(closing))
    return SecondContact(share, len(every), min(times), max(times), typical, places)


def touched_again(scene: Scene, motion: Motion) -> tuple[float, float, tuple[float, float]] | None:
    """When and where the outlines of A and B, having moved apart, overlap again, and how fast they do.

    Args:
        scene: scene with the dimensions of both vehicles.
        motion: motion after the impact.

    Returns:
        The time after the impact, s, the closing speed, m/s, and the middle between the vehicles, m;
        None where they do not.
    """
    time = np.arange(0.0, motion.lasts, _BETWEEN)
    if time.size < 2:
        return None
    apart = gap(*((scene.vehicles[v], motion.poses(v, time)) for v in VEHICLES))
    i = _meet_again(apart)
    if i is None:
        return None
    x, y = np.mean([motion.pose_at(v, float(time[i]))[:2] for v in VEHICLES], axis=0).tolist()
    return float(time[i]), float((apart[i - 1] - apart[i]) / _BETWEEN), (x, y)


def _meet_again(apart: Float[np.ndarray, " times"]) -> int | None:
    """Index of the first time at which bodies that had moved apart overlap again; None without one.

    What is crushed may go deeper at first, and come back: that is no second contact.
    """
    deepest = float(apart[0])
    farthest: float | None = None
    for i, distance in enumerate(apart.tolist()):
        if farthest is None:
            deepest = min(deepest, distance)
            farthest = distance if distance > deepest + _AGAIN else None
        elif distance < min(0.0, farthest - _AGAIN):
            return i
        else:
            farthest = max(farthest, distance)
    return None


def gap(
    one: tuple[Vehicle, Float[np.ndarray, "times 3"]],
    other: tuple[Vehicle, Float[np.ndarray, "times 3"]],
) -> Float[np.ndarray, " times"]:
    """Distance between two bodies along the axis that parts them the most; below 0, their overlap.

    Args:
        one: vehicle, and its poses x, y and heading.
        other: the other vehicle, and its poses at the same times.

    Returns:
        The distance in m, by the separating axes of two rectangles (Gottschalk et al. 1996).
    """
    sides, middles = [], []
    for vehicle, pose in (one, other):
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        along, across = np.stack([c, s], axis=1), np.stack([-s, c], axis=1)
        middles.append(pose[:, :2] + body_middle(vehicle) * along)
        sides += [(along, vehicle.length / 2), (across, vehicle.width / 2)]
    between = middles[1] - middles[0]

    def apart(axis: Float[np.ndarray, "times 2"]) -> Float[np.ndarray, " times"]:
        reach = sum(half * np.abs((side * axis).sum(axis=1)) for side, half in sides)
        return np.abs((between * axis).sum(axis=1)) - reach

    return np.max([apart(side) for side, _ in sides], axis=0)
