"""The simplest run-out: a point that slides straight to rest, v² = 2 mu g d."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description
from retrodict.models.run_out import NORMAL_ERRORS, ONE_FRICTION, RunOut, rolls
from retrodict.models.runouts import spin

from retrodict.constants import GRAVITY
from retrodict.mechanics import Path
from retrodict.mechanics.runout import ROWS


def rest_poses(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, " separation"]
) -> Float[Array, "vehicles 2"]:
    """Rest positions of the vehicles for velocities after the impact."""
    return slid(x, after, friction(structure, data, x))


def paths(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, " separation"]
) -> Path:
    """Straight paths of the vehicles to rest, v² = v0² (1 − s / d), stacked."""
    return slid_along(x, after, friction(structure, data, x))


def friction(structure: Structure, data: Data, x: parts.Values) -> Float[Array, " vehicles"]:
    """Friction of the vehicles on the road."""
    return jnp.asarray(parts.ground(structure, data, x).coefficients)[:, 0]


def slid(
    x: parts.Values, after: Float[Array, " separation"], friction: Float[Array, " vehicles"]
) -> Float[Array, "vehicles 2"]:
    """Rest positions of the vehicles that slide on this friction, v² = 2 mu g d."""
    V = after.reshape(-1, 2)
    size = jnp.hypot(*V.T)
    way = V * (size / (2 * GRAVITY * friction))[:, None]
    return parts.impact_poses(x)[:, :2] + way


def slid_along(
    x: parts.Values, after: Float[Array, " separation"], friction: Float[Array, " vehicles"]
) -> Path:
    """Straight paths of the vehicles that slide to rest on this friction, stacked."""
    start, V = parts.impact_poses(x), after.reshape(-1, 2)
    end = slid(x, after, friction)
    share = jnp.linspace(0.0, 1.0, ROWS)  # of the way
    left = jnp.sqrt(1 - share)  # of the speed
    between = jax.vmap(lambda a, b: a + share[:, None] * (b - a))(start[:, :2], end)
    heading = jnp.broadcast_to(start[:, None, 2:], (len(start), ROWS, 1))
    braking = GRAVITY * friction
    velocity = left[:, None] * V[:, None]
    return Path(
        pose=jnp.concatenate([between, heading], axis=-1),
        velocity=jnp.pad(velocity, ((0, 0), (0, 0), (0, 1))),
        time=(1 - left) * (jnp.hypot(*V.T) / braking)[:, None],
    )


RUN_OUT = RunOut(
    description=Description(
        name="slide",
        title="a straight slide to rest",
        equations=("run-out: v² = 2 μ g d along the straight line from impact to rest",),
        assumptions=(
            "each vehicle slides straight, as if it did not yaw: right for one that does not, and "
            "the slower the more it spins, as a spinning vehicle's wheels slide aside",
            ONE_FRICTION,
            NORMAL_ERRORS,
        ),
        left_out=(
            "yaw, and the rest headings as evidence; other surfaces; rolling wheels; load transfer; "
            "slopes",
        ),
    ),
    rests=("x", "y"),
    seen=spin.seen,
    rest_poses=rest_poses,
    paths=paths,
    nesting=frozenset(),
    integrated=lambda scene: (),
    refusal=rolls,
)
