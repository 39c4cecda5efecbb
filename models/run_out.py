"""What a run-out model is: how it sees a scene, and where it brings the vehicles to rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from retrodict.models import parts
from retrodict.models.card import Card

from retrodict.scene.records import Scene

ONE_FRICTION = "the road is plane, level and of one friction, at all speeds and for both vehicles"
NORMAL_ERRORS = (
    "A's approach, the friction and the vehicles' data are normal (or lognormal where they "
    "cannot be negative) about what was measured, and independent of one another"
)


@dataclass(frozen=True)
class RunOut:
    """A run-out model.

    Args:
        card: what it is, in words.
        rests: what of a rest pose it explains.
        seen: the scene with what this model leaves out taken out.
        rest_poses: structure, data, inputs and velocities after the impact -> rests of A and B.
        paths: likewise, stacked, each from impact to rest.
        fullness: what it holds beyond a sliding point.
    """

    card: Card
    rests: tuple[str, ...]
    seen: Callable[[Scene], Scene]
    rest_poses: parts.RestPoses
    paths: parts.Paths
    fullness: frozenset[str]
