"""The pose at which a vehicle stops sliding sideways and begins to roll."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.mechanics.motion import Car, Pose
from retrodict.mechanics.rotation import cos_sin
from retrodict.mechanics.runout import Path

# Slip angles of the rear axle between which sliding sideways passes into rolling: judgement. The side
# force of a rolling tyre is 0.9 of its maximum at the first and 0.8 at the second (`tyre.SLIP`).
SIDEWAYS, ROLLING = np.radians(12.0), np.radians(8.0)
# Added to the speed along the vehicle, m/s: the slip angle is undefined at rest, and not meaningful
# at a few centimetres per second.
_CREEP = 0.5


def end_of_rotation(path: Path, car: Car) -> Pose:
    """The pose at which a vehicle stops sliding sideways and begins to roll, forwards or backwards.

    It is where the slip angle of the rear axle falls below a threshold for the last time, averaged over
    thresholds from 12 to 8 deg: the pose changes continuously where a vehicle swings out once more. For
    a vehicle that slides sideways until it rests this is the rest pose; for one that never slides
    sideways, the start of the path.

    Args:
        path: path of the vehicle to rest, from `run_out`.
        car: properties of the vehicle, of which only the rear axle is used.

    Returns:
        x, y and heading, m and rad; the heading is not wrapped.

    Source:
        The end of rotation that EDCRASH (Engineering Dynamics Corporation) takes as an input.
    """
    slip = _rear_slip(path, car)
    most = jax.lax.cummax(slip, reverse=True)  # from each row to rest
    # between two rows: the thresholds that are crossed for the last time, and where, on average
    high, low = (jnp.clip(a, ROLLING, SIDEWAYS) for a in (slip[:-1], most[1:]))
    share = jnp.maximum(high - low, 0.0) / (SIDEWAYS - ROLLING)
    fall = jnp.where(share > 0, slip[:-1] - slip[1:], 1.0)
    along = jnp.where(share > 0, (slip[:-1] - (high + low) / 2) / fall, 0.0)
    crossed = path.pose[:-1] + along[:, None] * jnp.diff(path.pose, axis=0)
    return path.pose[0] + share @ (crossed - path.pose[0])


def _rear_slip(path: Path, car: Car) -> Float[Array, " steps"]:
    """Angle of the rear axle's velocity from the vehicle's axis, 0 to 90 deg, rad; 0 at rest."""
    c, s = cos_sin(path.pose[:, 2])
    Vx, Vy, Omega = path.velocity.T
    along, across = c * Vx + s * Vy, c * Vy - s * Vx - car.rear_axle * Omega
    return jnp.arctan2(jnp.abs(across), jnp.abs(along) + _CREEP)
