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
        speed: at the impact, m/s.
        initial: before the skid, m/s; the same without one.
        skid: its length up to the impact, m; 0 without one.
    """

    speed: Number
    initial: Number
    skid: Number


class Arrival(NamedTuple):
    """When and how fast a vehicle reaches a point.

    Args:
        time: s; infinite where it stops before the point.
        speed: there, m/s; 0 where it stops.
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
        approach: its motion.
        time: before the impact, s.

    Returns:
        m.
    """
    skidding = skid_time(approach)
    slowing = (approach.initial - approach.speed) / jnp.where(skidding > 0, skidding, 1.0)
    within = approach.speed * time + slowing * time**2 / 2
    return jnp.where(time < skidding, within, approach.skid + approach.initial * (time - skidding))


def time_before(approach: Approach, distance: Number) -> Float[Array, "*any"]:
    """How long before the impact a vehicle was that far from it: the inverse of `distance_before`, s."""
    share = distance / jnp.where(jnp.asarray(approach.skid) > 0, approach.skid, 1.0)
    square = approach.speed**2 + share * (approach.initial**2 - approach.speed**2)
    within = 2 * distance / (approach.speed + jnp.sqrt(square))
    beyond = skid_time(approach) + (distance - approach.skid) / approach.initial
    return jnp.where(distance < approach.skid, within, beyond)


def arrival(distance: Number, speed: Number, reaction: Number, deceleration: Number) -> Arrival:
    """When and how fast a vehicle reaches a point, if its driver brakes after the reaction time.

    It stops before the point where v t + v² / (2 a) is at most the distance.

    Args:
        distance: to the point when the hazard is perceived, m.
        speed: then, m/s.
        reaction: t, s.
        deceleration: a, m/s².

    Returns:
        Time from the perception, and speed at the point.
    """
    braking = distance - speed * reaction
    square = speed**2 - 2 * deceleration * jnp.maximum(braking, 0.0)
    there = jnp.sqrt(jnp.maximum(square, 0.0))
    braked = reaction + (speed - there) / deceleration
    time = jnp.where(braking > 0, braked, distance / speed)
    return Arrival(jnp.where(square <= 0, jnp.inf, time), there)


def way_to_clear(offset: Number, half_widths: Number, rate: Number) -> Float[Array, "*any"]:
    """How far a vehicle has to go on until its outline has left the strip that another sweeps.

    Args:
        offset: of its centre from the middle of the strip, m.
        half_widths: of the strip and of the outline, across the strip, together, m.
        rate: by how much the offset changes per metre of its way, between -1 and 1.

    Returns:
        m; infinite where it travels along the strip.
    """
    across = jnp.abs(rate)
    left = half_widths - jnp.sign(rate) * offset
    way = jnp.maximum(left, 0.0) / jnp.where(across > 0, across, 1.0)
    return jnp.where(across > 0, way, jnp.inf)


def half_extent(
    length: Number, width: Number, heading: Number, direction: Number
) -> Float[Array, "*any"]:
    """Half of how wide an outline is across a direction.

    Args:
        length: of the outline, m.
        width: likewise.
        heading: of the outline, rad.
        direction: across which, rad.

    Returns:
        m.
    """
    turn = heading - direction
    return jnp.asarray(length * jnp.abs(jnp.sin(turn)) + width * jnp.abs(jnp.cos(turn))) / 2
