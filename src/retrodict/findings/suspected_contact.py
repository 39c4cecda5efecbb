"""Whether measurements may come of two contacts, which one impact explains by a moment impulse."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from retrodict.findings.run_outs import Motion, motions, place_of
from retrodict.findings.second_contact import SecondContact, touched_again
from retrodict.scene.records import VEHICLES
from retrodict.studies.draws import draws_of

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome

# By simulated crashes (tests/shared/side_slaps.py): of 50 with a side slap 43 are suspected, and none of
# 22 without; the others close at 1.6 to 6 m/s, and leave e_m near 0.85 or touch again as they are.
_SLAPS_WITHIN = 0.8  # s after the impact
_SMALL = 0.75  # e_m
# Of the share of motions that only the moment impulse keeps apart, times that of e_m.
_WORTH_SAYING = 0.15


@dataclass(frozen=True, slots=True)
class SuspectedContact:
    """Motions in which the vehicles would touch again, had the impact passed no moment impulse.

    Args:
        share: share of the recorded motions.
        small: share of the posterior draws in which e_m is below `limit`.
        limit: value of e_m.
        after: median time after the impact at which they would touch again, s.
    """

    share: float
    small: float
    limit: float
    after: float

    @property
    def sentence(self) -> str:
        """What the reader of a report has to know of it."""
        return (
            f"In {self.small:.0%} of the draws one impact explains what was measured by a moment "
            f"impulse (e_m below {self.limit:g}). Without it the vehicles would turn so that their "
            f"outlines overlap again in {self.share:.0%} of the motions, about {self.after:.1f} s "
            "after the impact: there may have been a second contact (a side slap), which is not "
            "modelled, and the speeds may be wrong by its impulse."
        )


def suspected_contact(outcome: Outcome, again: SecondContact | None) -> SuspectedContact | None:
    """A second contact that the model would explain by a moment impulse; None where it is not likely.

    The impulse of a side slap brakes the vehicles' rotation, as a moment impulse of the first contact
    would. So each recorded motion is turned on at the yaw rates that the force impulse alone leaves.

    Args:
        outcome: the reconstruction.
        again: second contacts in the motions as they are, from `second_contact`; None without any.
    """
    if set(outcome.scene.vehicles) != set(VEHICLES):
        return None
    if "posterior" not in outcome.idata.children:
        return None
    if not {"e_m", "vbx", "Vbx", "Omega_b"} <= set(outcome.idata["posterior"].data_vars):
        return None
    small = float((draws_of(outcome, "e_m") < _SMALL).mean())
    every = motions(outcome)
    if not every or small < _WORTH_SAYING:
        return None
    gained = _gained(outcome)
    times = []
    for motion in every:
        place = place_of(outcome, motion)
        if place is None:
            continue
        turned = _turned(motion, {v: gained[v][place] for v in VEHICLES})
        if (touched := touched_again(outcome.scene, turned)) is not None:
            times.append(touched[0])
    share = len(times) / len(every)
    if (share - (again.share if again else 0.0)) * small < _WORTH_SAYING:
        return None
    return SuspectedContact(share, small, _SMALL, float(np.median(times)))


def _gained(outcome: Outcome) -> dict[str, Float[np.ndarray, "chains draws"]]:
    """Yaw rates after the force impulse alone, less those of the draws, rad/s."""
    P = [
        draws_of(outcome, "mass_b") * (draws_of(outcome, f"vb{x}") - draws_of(outcome, f"Vb{x}"))
        for x in "xy"
    ]  # on A
    found = {}
    for v, sign in zip(VEHICLES, (1, -1), strict=True):
        angle = draws_of(outcome, f"heading_{v}") + draws_of(outcome, f"impact_angle_{v}")
        lever = draws_of(outcome, f"impact_distance_{v}")
        moment = sign * lever * (np.cos(angle) * P[1] - np.sin(angle) * P[0])
        alone = draws_of(outcome, f"omega_{v}") + moment / draws_of(outcome, f"yaw_inertia_{v}")
        found[v] = alone - draws_of(outcome, f"Omega_{v}")
    return found


def _turned(motion: Motion, gained: dict[str, float]) -> Motion:
    """The beginning of a motion, with more yaw rate: rad/s, by vehicle."""
    time = np.arange(0.0, _SLAPS_WITHIN, 0.01)
    pose = {}
    for v, rate in gained.items():
        pose[v] = motion.poses(v, time)
        pose[v][:, 2] += rate * time
    return replace(motion, time=dict.fromkeys(gained, time), pose=pose)
