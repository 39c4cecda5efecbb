"""The most detailed run-out: a rigid body on four wheels, locked or rolling, on the scene's surfaces."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import STEPS, Data, Structure
from retrodict.models.description import Description
from retrodict.models.run_out import NORMAL_ERRORS, OF_WHEELS, RunOut

from retrodict.mechanics import Car, Ground, Path, rest, run_out
from retrodict.mechanics.integration import Paced, Steps
from retrodict.mechanics.motion import Joined
from retrodict.mechanics.runout import ROWS


def rest_poses(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, " separation"]
) -> Float[Array, "vehicles 3"]:
    """Rest poses of the vehicles for velocities after the impact."""
    return _both(rest, structure, data, x, after)


def paths(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, " separation"]
) -> Path:
    """Paths of the vehicles to rest, stacked."""
    return _both(in_rows, structure, data, x, after)


def in_rows(pose: Array, velocity: Array, car: Car | Joined, on: Ground, steps: Any) -> Path:
    """`run_out` with a row a step, whose number a compiled program has to know."""
    return run_out(pose, velocity, car, on, ROWS if isinstance(steps, Steps) else steps)


def _both[T](
    follow: Callable[..., T],
    structure: Structure,
    data: Data,
    x: parts.Values,
    after: Float[Array, " separation"],
) -> T:
    """`follow(pose, velocity, car, ground, steps)` of each vehicle, stacked."""
    where = (parts.impact_poses(x), after.reshape(-1, 3))
    on = parts.ground(structure, data, x)
    steps = structure.steps or data.steps
    if structure.steps or not structure.rolling:
        car = parts.cars(structure, x)
        return parts.each_vehicle(partial(follow, steps=steps), *where, car=car, on=on)
    # one after the other: under vmap both would take as many steps as the slower
    paced = Paced(data.steps.number / STEPS)
    ends = []
    for i, v in enumerate(structure.vehicles):
        rolls = v in structure.rolling
        car = jax.tree.map(lambda own: own[i], parts.cars(structure, x))  # noqa: B023
        ground = on._replace(coefficients=jnp.asarray(on.coefficients)[i])
        car = car if rolls else car._replace(wheels=None)
        ends.append(follow(where[0][i], where[1][i], car, ground, steps=paced if rolls else steps))
    return jax.tree.map(lambda *own: jnp.stack(own), *ends)


RUN_OUT = RunOut(
    description=Description(
        name="wheels",
        title="a skid to rest on four wheels over the surfaces of the scene",
        equations=(
            "run-out: planar rigid body on four wheels, friction f exp(−c v) times load "
            "against the slip of each wheel, in the spirit of Ellis, which SAE 770014 cites",
        ),
        assumptions=(
            "wheels keep their state from impact to rest; those of which the scene says nothing are "
            "locked, or slide as if they were",
            "loads of the wheels are static, but for a vehicle whose centre of gravity has a height "
            "(cg_height): there the forces of the tyres move them, as if the body could not tilt; a "
            "motion in which a wheel lifts is ruled out",
            "the road is plane, and level unless the scene gives it a slope, which is then the same "
            "everywhere: places are counted in its plane",
            "a surface's friction is shared by all vehicles but for a factor of each one's tyres",
            NORMAL_ERRORS,
        ),
        left_out=(
            "steering or braking in between; load transfer of a vehicle without cg_height; pitch and "
            "roll; slopes that change along the way",
        ),
    ),
    rests=("x", "y", "heading"),
    seen=lambda scene: scene,
    rest_poses=rest_poses,
    paths=paths,
    needs=OF_WHEELS,
    nesting=frozenset({"yaw", "rolling", "wheels"}),
)
