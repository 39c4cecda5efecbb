"""Two vehicles in contact: masses, lever arms, contact line and contact velocity.

The normal of the contact line is n = (cos Gamma, sin Gamma), its tangent t = (-sin Gamma, cos Gamma);
lever arms are those of SAE 770014, eqs 15-18.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

Scalar = Float[Array, ""] | float
State = Float[Array, "6"]  # (x, y, spin) of A, then of B: m/s, rad/s
SixNumbers = State | Float[np.ndarray, "6"] | Sequence[float]  # the same, as it may be given


class Bodies(NamedTuple):
    """Two vehicles in contact.

    Args:
        m_a, m_b: masses, kg.
        I_a, I_b: yaw inertias, kg m².
        d1, d2: impact centre seen from B's centre of gravity: (d2, d1), m (eqs 15, 16).
        d3, d4: impact centre seen from A's centre of gravity: (-d4, -d3), m (eqs 17, 18).
        Gamma: angle of the contact line from the y axis, rad.
    """

    m_a: Scalar
    m_b: Scalar
    I_a: Scalar
    I_b: Scalar
    d1: Scalar
    d2: Scalar
    d3: Scalar
    d4: Scalar
    Gamma: Scalar


def lever_arms(
    lever_a: Float[Array, "2"], lever_b: Float[Array, "2"]
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """The paper's d1..d4 from the two levers (eqs 15-18).

    Args:
        lever_a: vector from A's centre of gravity to the impact centre, road frame, m.
        lever_b: vector from B's centre of gravity to the impact centre, road frame, m.

    Returns:
        (d1, d2, d3, d4) in m; eqs 11, 14 and 22 fix the signs: lever_b = (d2, d1), lever_a = (-d4, -d3).
    """
    return lever_b[1], lever_b[0], -lever_a[1], -lever_a[0]


def against_barrier(m_a: Scalar, I_a: Scalar, d3: Scalar, d4: Scalar, Gamma: Scalar) -> Bodies:
    """Vehicle A against an immovable barrier or structure.

    Args:
        m_a: A's mass, kg.
        I_a: A's yaw inertia, kg m².
        d3, d4: impact centre seen from A's centre of gravity: (-d4, -d3), m (eqs 17, 18).
        Gamma: angle of the barrier's face from the y axis, rad.

    Returns:
        Bodies with the barrier as B: m_b and I_b infinite. B's velocities must be given, usually
        zeros; A must be the vehicle, since the inverse takes the impulse from A's change of motion.
        The inverse gives e, mu and e_m, but of B only that it kept its velocity: the
        velocities of an immovable body do not determine those of A.
    """
    return Bodies(m_a, jnp.inf, I_a, jnp.inf, 0.0, 0.0, d3, d4, Gamma)


def axes(bodies: Bodies) -> tuple[Float[Array, "2"], Float[Array, "2"]]:
    """Normal and tangent of the contact line.

    Args:
        bodies: vehicles in contact, of which only Gamma is used.

    Returns:
        Two unit vectors in the road frame; the sign of the normal is arbitrary.
    """
    c, s = jnp.cos(bodies.Gamma), jnp.sin(bodies.Gamma)
    return jnp.stack([c, s]), jnp.stack([-s, c])


def contact_velocity(state: SixNumbers, bodies: Bodies) -> Float[Array, "2"]:
    """Velocity of A relative to B at the impact centre (the brackets of eq 22), m/s.

    Args:
        state: six velocities, before or after.
        bodies: lever arms.

    Returns:
        (x, y) components, m/s.
    """
    _, _, _, _, d1, d2, d3, d4, _ = bodies
    v_ax, v_ay, w_a, v_bx, v_by, w_b = state
    return jnp.stack([v_ax + d3 * w_a - v_bx + d1 * w_b, v_ay - d4 * w_a - v_by - d2 * w_b])


def closing_speed(approach: SixNumbers, bodies: Bodies) -> Float[Array, ""]:
    """Closing speed along the normal, each vehicle on its own side of the contact.

    Args:
        approach: six velocities before impact.
        bodies: lever arms and Gamma.

    Returns:
        m/s; negative where the vehicles separate, so that the impulse would have to pull.
    """
    return towards_b(bodies) * (contact_velocity(approach, bodies) @ axes(bodies)[0])


def towards_b(bodies: Bodies) -> Float[Array, ""]:
    """Sign of the normal that points from A to B, from the lever arms.

    Args:
        bodies: lever arms and Gamma.

    Returns:
        1, or -1 where the reversed normal points from A to B. A barrier has no lever arms: it lies
        beyond the contact, as A sees it.
    """
    of_a, of_b = _sides(bodies)
    return jnp.where(of_a - of_b < 0, -1.0, 1.0)


def either_side(bodies: Bodies) -> Bool[Array, ""]:
    """Whether the vehicles lie on opposite sides of the contact line, so that `towards_b` is reliable.

    Args:
        bodies: lever arms and Gamma.
    """
    of_a, of_b = _sides(bodies)
    return of_a * of_b < 0


def _sides(bodies: Bodies) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Cosines between the normal and the levers of A and B."""
    _, _, _, _, d1, d2, d3, d4, _ = bodies
    normal = axes(bodies)[0]
    to_a, to_b = jnp.stack([-d4, -d3]), jnp.stack([d2, d1])
    of_a, size = to_a @ normal / jnp.hypot(*to_a), jnp.hypot(*to_b)
    return of_a, jnp.where(size > 0, to_b @ normal / jnp.where(size > 0, size, 1.0), -of_a)
