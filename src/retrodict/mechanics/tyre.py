"""Force of a sliding tyre: locked, rolling, or braked in between, within the friction ellipse."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

# A rolling tyre's lateral force rises with its slip angle and saturates at its friction; at this
# tangent of the angle it has reached 1/sqrt(2) of it (normalised cornering stiffness of 10 per rad).
SLIP = 0.1
# Below this speed (m/s) the rise softens, as it does when a tyre has no length left to roll and build
# up its force; without it the law is stiffer the slower the wheel.
SLOW = 2.0


class Wheels(NamedTuple):
    """How the wheels of a vehicle turn, front left, front right, rear left, rear right.

    Args:
        drag: braking force over the available friction: 1 locked, 0 free, rolling drag or a brake
            in between.
        steer: angle of each wheel from the vehicle's heading, counter-clockwise, rad.
    """

    drag: Float[Array | np.ndarray, " wheels"]
    steer: Float[Array | np.ndarray, " wheels"]


def force(
    slip: Float[Array, "2 wheels"], patch2: Float[Array, ""], wheels: Wheels
) -> Float[Array, "2 wheels"]:
    """Force of each wheel over friction times load.

    Along the wheel it is -drag cos(alpha). Across, it rises with the slip angle alpha to the rest of the
    friction ellipse, sqrt(1 - drag² cos² alpha). A locked wheel's points against its slip.

    Args:
        slip: velocity of each wheel over the ground, along and across the vehicle, m/s.
        patch2: squared slip inside the contact patch, m²/s².
        wheels: drag and steer.

    Returns:
        Components along and across the vehicle, shape (2, wheels); each wheel's resultant is at most 1.
    """
    drag, steer = jnp.asarray(wheels.drag), jnp.asarray(wheels.steer)
    c, s = jnp.cos(steer), jnp.sin(steer)
    along, across = c * slip[0] + s * slip[1], c * slip[1] - s * slip[0]
    speed2 = along**2 + across**2 + patch2
    rolling = 1 - drag**2
    side = across**2 + patch2
    rise = jnp.sqrt((side + rolling * along**2) / (side + rolling * SLIP**2 * (along**2 + SLOW**2)))
    # never beyond the ellipse: softening only lowers it
    per_speed = 1 / jnp.sqrt(speed2)
    forward, sideways = -drag * along * per_speed, -across * per_speed * rise
    return jnp.stack([c * forward - s * sideways, s * forward + c * sideways])
