"""What a run-out model is: how it sees a scene, and where it brings the vehicles to rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description

from retrodict.scene.records import VEHICLES, Measured, Scene


def rolls(scene: Scene) -> str:
    """Refuse a scene for a run-out that takes every wheel as locked, if some roll."""
    return "takes every wheel as locked, and some roll" if scene.rolling else ""


ONE_FRICTION = "the road is plane, level and of one friction, at all speeds and for both vehicles"
NORMAL_ERRORS = (
    "A's approach, the friction and the vehicles' data are normal (or lognormal where they "
    "cannot be negative) about what was measured, and independent of one another"
)


Inverse = Callable[[Structure, Data, parts.Values, str], Callable[[Array], Array]]


@dataclass(frozen=True)
class RunOut:
    """A run-out model.

    Args:
        description: the model in words.
        rests: what of a rest pose it explains.
        seen: the scene with what this model leaves out taken out.
        rest_poses: structure, data, inputs and velocities after the impact -> rests of A and B.
        paths: likewise, stacked, each from impact to rest.
        nesting: what it models beyond a sliding point; as of `Impact`.
        integrated: vehicles of a scene whose motion it integrates.
        ways: vehicles of a scene that it follows along where they were seen: x, y, heading at each
            point.
        approximations: what it misses of a fuller model, as inputs.
        inverse: structure, data, inputs and a vehicle that is not integrated -> what leads from its rest
            pose to its velocity after the impact; None where all are.
        refusal: why it is not for a scene; empty where it is.
    """

    description: Description
    rests: tuple[str, ...]
    seen: Callable[[Scene], Scene]
    rest_poses: parts.RestPoses
    paths: parts.Paths
    nesting: frozenset[str]
    integrated: Callable[[Scene], tuple[str, ...]] = lambda scene: VEHICLES
    ways: Callable[[Scene], dict[str, Float[Array | np.ndarray, "points 3"]]] = lambda scene: {}
    approximations: Callable[[Scene], dict[str, Measured]] = lambda scene: {}
    inverse: Inverse | None = None
    refusal: Callable[[Scene], str] = lambda scene: ""
