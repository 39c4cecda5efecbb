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


OF_WHEELS = ("wheelbase", "track")
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
        rests: components of the rest pose that the model predicts.
        seen: function that removes from a scene the effects that the model neglects.
        rest_poses: function of structure, data, inputs and velocities after the impact that returns the
            rest poses of the vehicles, one row each.
        paths: function of the same arguments that returns the vehicles' paths to rest, stacked.
        nesting: effects that the model adds to a sliding point, compared as in `Impact`.
        integrated: function that names the vehicles of a scene whose motion is integrated.
        ways: function of a scene that gives x, y (m) and heading (rad) at each point of the measured
            paths that the model follows, by vehicle.
        approximations: function of a scene that gives the errors of the model relative to a more
            detailed one, as inputs.
        inverse: function of structure, data, inputs and a vehicle that is not integrated, which returns
            the function from its rest pose to its velocity after the impact; None for no such function.
        refusal: function of a scene that gives the reason why the model does not apply; empty where it
            does.
        needs: keys of a scene file that the model needs and other run-outs do without.
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
    needs: tuple[str, ...] = ()
