"""Before the impact: distances, reaction and braking, and when another vehicle is out of the way.

A vehicle travels at a constant speed and, where it skidded, slows down evenly over its skid.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

Number = Float[Array | np.ndarray, "*any"] | float


class Approach(NamedTuple):
    """A vehicle's motion up to the impact.

    Args:
        speed: speed at the impact, m/s.
        initial: speed before the skid, m/s; equal to `speed` without a skid.
        skid: length of the skid up to the impact, m; 0 without one.
    """

    speed: Number
    initial: Number
    skid: Number


class Arrival(NamedTuple):
    """When and how fast a vehicle reaches a point.

    Args:
        time: time until the vehicle reaches the point, s; infinite where it stops before.
        speed: speed at the point, m/s; 0 where the vehicle stops before.
    """

    time: Float[Array, "*any"]
    speed: Float[Array, "*any"]


def skid_time(approach: Approach) -> Float[Array, "*any"]:
    """How long the skid up to the impact took, s."""
    both = approach.speed + approach.initial
    return jnp.asarray(2 * approach.skid / jnp.where(both > 0, both, 1.0))


def distance_before(approach: Approach, time: Number) -> Float[Array, "*any"]:
    """How far a vehicle was from where the impact came, measured along its path.

    Args:
        approach: motion of the vehicle up to the impact.
        time: time before the impact, s.

    Returns:
        The distance, m.
    """
    skidding = skid_time(approach)
    slowing = (approach.initial - approach.speed) / jnp.where(skidding > 0, skidding, 1.0)
    within = approach.speed * time + slowing * time**2 / 2
    return jnp.where(time < skidding, within, approach.skid + approach.initial * (time - skidding))


def time_before(approach: Approach, distance: Number) -> Float[Array, "*any"]:
    """How long before the impact a vehicle was at a distance from it, s; inverts `distance_before`."""
    share = distance / jnp.where(jnp.asarray(approach.skid) > 0, approach.skid, 1.0)
    square = approach.speed**2 + share * (approach.initial**2 - approach.speed**2)
    within = 2 * distance / (approach.speed + jnp.sqrt(square))
    beyond = skid_time(approach) + (distance - approach.skid) / approach.initial
    return jnp.where(distance < approach.skid, within, beyond)


def arrival(distance: Number, speed: Number, reaction: Number, deceleration: Number) -> Arrival:
    """When and how fast a vehicle reaches a point, if its driver brakes after the reaction time.

    The vehicle stops before the point where v t + v² / (2 a) is at most the distance.

    Args:
        distance: distance to the point when the hazard is perceived, m.
        speed: speed v when the hazard is perceived, m/s.
        reaction: reaction time t, s.
        deceleration: deceleration a while the driver brakes, m/s².

    Returns:
        Time from the perception, and speed at the point.
    """
    braking = distance - speed * reaction
    square = speed**2 - 2 * deceleration * jnp.maximum(braking, 0.0)
    there = jnp.sqrt(jnp.maximum(square, 0.0))
    braked = reaction + (speed - there) / deceleration
    time = jnp.where(braking > 0, braked, distance / speed)
    return Arrival(jnp.where(square <= 0, jnp.inf, time), there)


def distance_to_clear(offset: Number, half_widths: Number, rate: Number) -> Float[Array, "*any"]:
    """How far a vehicle has to go on until its outline has left the strip that another sweeps.

    Args:
        offset: offset of the vehicle's centre from the middle of the strip, m.
        half_widths: half the width of the strip plus that of the outline across the strip, m.
        rate: change of the offset per metre that the vehicle travels, between -1 and 1.

    Returns:
        The distance, m; infinite where the vehicle travels along the strip.
    """
    across = jnp.abs(rate)
    left = half_widths - jnp.sign(rate) * offset
    length = jnp.maximum(left, 0.0) / jnp.where(across > 0, across, 1.0)
    return jnp.where(across > 0, length, jnp.inf)


def half_extent(
    length: Number, width: Number, heading: Number, direction: Number
) -> Float[Array, "*any"]:
    """Half of how wide an outline is across a direction.

    Args:
        length: length of the outline, m.
        width: width of the outline, m.
        heading: heading of the outline, rad.
        direction: direction that the extent is measured across, rad.

    Returns:
        Half of the extent, m.
    """
    turn = heading - direction
    return jnp.asarray(length * jnp.abs(jnp.sin(turn)) + width * jnp.abs(jnp.cos(turn))) / 2
