"""What a run-out model is: its view of a scene, rest poses and paths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description

from retrodict.scene.records import Measured, Scene


def rolls(scene: Scene) -> str:
    """Refusal of a scene with rolling wheels by a run-out that assumes locked wheels; else empty."""
    return "takes every wheel as locked, and some roll" if scene.rolling else ""


def level(scene: Scene) -> Scene:
    """The scene on level ground with static loads, for run-outs that model no slope or load transfer."""
    vehicles = {v: replace(own, cg_height=None) for v, own in scene.vehicles.items()}
    return replace(scene, vehicles=vehicles, slope=None)


ONE_FRICTION = "the road is plane, level and of one friction, at all speeds and for all vehicles"
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
        rests: components of the rest pose that it predicts.
        seen: the scene without the effects that this model neglects.
        rest_poses: structure, data, inputs and velocities after the impact -> rests of A and B.
        paths: likewise, stacked, each from impact to rest.
        nesting: what it models beyond a sliding point; as of `Impact`.
        integrated: vehicles of a scene whose motion it integrates.
        ways: x, y and heading at each point of the measured ways that it follows, by vehicle.
        approximations: its errors relative to a more detailed model, as inputs.
        inverse: structure, data, inputs and a vehicle that is not integrated -> the function from its
            rest pose to its velocity after the impact; None where all are integrated.
        refusal: why it does not apply to a scene; empty where it does.
    """

    description: Description
    rests: tuple[str, ...]
    seen: Callable[[Scene], Scene]
    rest_poses: parts.RestPoses
    paths: parts.Paths
    nesting: frozenset[str]
    integrated: Callable[[Scene], tuple[str, ...]] = lambda scene: tuple(scene.vehicles)
    ways: Callable[[Scene], dict[str, Float[Array | np.ndarray, "points 3"]]] = lambda scene: {}
    approximations: Callable[[Scene], dict[str, Measured]] = lambda scene: {}
    inverse: Inverse | None = None
    refusal: Callable[[Scene], str] = lambda scene: ""
