"""The fullest run-out: a rigid body on four wheels, locked or rolling, over surfaces with edges."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.card import Card
from retrodict.models.run_out import NORMAL_ERRORS, RunOut

from retrodict.mechanics import rest, run_out
from retrodict.mechanics.runout import ROWS

_FINER = 8


def rest_poses(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, "6"]
) -> Float[Array, "2 3"]:
    """Where both vehicles come to rest after separating with these velocities."""
    steps = structure.steps or data.steps
    return _both(partial(rest, steps=steps), structure, data, x, after)


def paths(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, "6"]
) -> Float[Array, "2 steps 3"]:
    """How they get there: x, y and heading at each step."""
    # where wheels roll the clock runs stiff: finer steps, of which as many are told
    every = _FINER if structure.rolling and not structure.steps else 1
    follow = partial(run_out, steps=structure.steps or every * ROWS)
    return _both(lambda *at: follow(*at).pose[::every], structure, data, x, after)


def _both(
    follow: Callable[..., Array],
    structure: Structure,
    data: Data,
    x: parts.Values,
    after: Float[Array, "6"],
) -> Array:
    """What `follow` makes of pose, velocity, car and ground of each vehicle."""
    return parts.each_vehicle(
        follow,
        *(parts.impact_poses(x), after.reshape(2, 3)),
        car=parts.cars(structure, x),
        on=parts.ground(structure, data, x),
    )


RUN_OUT = RunOut(
    card=Card(
        name="wheels",
        title="a skid to rest on four wheels over the surfaces of the scene",
        equations=(
            "run-out: planar rigid body on four wheels with static loads, friction f exp(−c v) "
            "against the slip of each wheel, in the spirit of Ellis, which SAE 770014 cites",
        ),
        assumptions=(
            "wheels keep their state from impact to rest; those of which the scene says nothing are "
            "locked, or slide as if they were",
            "the road is plane and level; a surface's friction is shared by both vehicles but for a "
            "factor of each one's tyres",
            NORMAL_ERRORS,
        ),
        left_out=("steering or braking in between; load transfer, pitch and roll; slopes",),
    ),
    rests=("x", "y", "heading"),
    seen=lambda scene: scene,
    rest_poses=rest_poses,
    paths=paths,
    fullness=frozenset({"yaw", "rolling", "wheels"}),
)
