"""Severity of an impact: delta-v, principal direction of force (PDOF), closing speed and energy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from retrodict.mechanics.contact import (
    Bodies,
    Scalar,
    SixNumbers,
    State,
    axes,
    contact_velocity,
)
from retrodict.mechanics.impact import Coefficients, critical_mu, impulse, separation

REVERSAL = 1e-9  # by which |mu| may exceed |mu_c|, relative: the rounding of mu_c
GAIN = 1e-12  # by which energy may rise, relative: the rounding of the audit


class Audit(NamedTuple):
    """Energy balance (J): after - before = normal + tangential + moment."""

    before: Scalar
    after: Scalar
    normal: Scalar
    tangential: Scalar
    moment: Scalar


class Severity(NamedTuple):
    """Severity of an impact.

    Args:
        after: velocities after, as from `separation`, m/s and rad/s.
        delta_v: change of velocity of A and of B, road frame, (2, 2), m/s.
        delta_v_size: magnitude of delta-v of A and of B, (2,), m/s.
        pdof: principal direction of force on A and on B, clockwise from straight ahead, 0 to 2 pi;
            0 is a force from the front, pi/2 from the right. NaN without a change of velocity.
        closing_normal: speed at which the contact points close along the normal, m/s.
        closing: magnitude of the contact points' relative velocity, m/s.
        energy: energy audit.
        gains_energy: whether the outcome has more kinetic energy than the approach.
        reverses_sliding: whether mu exceeds its critical value or has the other sign.
        pulls: whether the normal impulse holds the vehicles together, as no contact can.
    """

    after: State
    delta_v: Float[Array, "2 2"]
    delta_v_size: Float[Array, "2"]
    pdof: Float[Array, "2"]
    closing_normal: Scalar
    closing: Scalar
    energy: Audit
    gains_energy: Bool[Array, ""]
    reverses_sliding: Bool[Array, ""]
    pulls: Bool[Array, ""]


def audit(approach: SixNumbers, bodies: Bodies, coefficients: Coefficients) -> Audit:
    """The energy audit of an impact.

    Args:
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        coefficients: e, mu and e_m.

    Returns:
        Kinetic energies and the work of each impulse: the impulse times the mean of the relative
        velocities before and after, which is exact. Work is negative where energy is lost. A body
        of infinite mass counts no kinetic energy: let it stand still for the balance to close.
    """
    approach = jnp.asarray(approach)
    after = separation(approach, bodies, coefficients)
    P, M = impulse(approach, bodies, coefficients)
    normal, tangent = axes(bodies)
    mean = (contact_velocity(approach, bodies) + contact_velocity(after, bodies)) / 2
    spin = (approach[5] - approach[2] + after[5] - after[2]) / 2
    return Audit(
        before=_kinetic_energy(approach, bodies),
        after=_kinetic_energy(after, bodies),
        normal=(P @ normal) * (mean @ normal),
        tangential=(P @ tangent) * (mean @ tangent),
        moment=-M * spin,
    )


def gains_energy(energy: Audit) -> Bool[Array, ""]:
    """Whether an outcome has more kinetic energy than its approach, beyond rounding.

    Args:
        energy: the audit.

    Returns:
        True where the three works add up to a gain.
    """
    work = jnp.stack([energy.normal, energy.tangential, energy.moment])
    rounding = max(GAIN, 32 * float(jnp.finfo(work.dtype).eps))
    return work.sum() > rounding * (energy.before + energy.after + jnp.abs(work).sum())


def feeding_term(energy: Audit) -> str | None:
    """The name of the work that feeds an outcome which gains energy.

    Args:
        energy: the audit of one impact, not of a batch.

    Returns:
        "normal", "tangential" or "moment", whichever adds most; None where no energy is gained.
    """
    if not gains_energy(energy):
        return None
    return max(("normal", "tangential", "moment"), key=lambda term: float(getattr(energy, term)))


def severity(
    approach: SixNumbers,
    bodies: Bodies,
    coefficients: Coefficients,
    headings: Float[Array, "2"] | Sequence[float],
) -> Severity:
    """Delta-V, principal direction of force, closing speed and energy of an impact.

    Args:
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        coefficients: e, mu and e_m.
        headings: headings of A and B, counter-clockwise from the x axis, rad, shape (2,).

    Returns:
        The record. `clock` turns its directions into hours, `feeding_term` names the work that
        feeds an outcome which gains energy.
    """
    approach, headings = jnp.asarray(approach), jnp.asarray(headings)
    after = separation(approach, bodies, coefficients)
    change = (after - approach).reshape(2, 3)[:, :2]
    size = jnp.hypot(change[:, 0], change[:, 1])
    # the force acts along delta-v, so it comes from the opposite direction
    source = jnp.arctan2(-change[:, 1], -change[:, 0])
    relative = contact_velocity(approach, bodies)
    energy = audit(approach, bodies, coefficients)
    return Severity(
        after=after,
        delta_v=change,
        delta_v_size=size,
        pdof=jnp.where(size > 0, jnp.mod(headings - source, 2 * jnp.pi), jnp.nan),
        closing_normal=jnp.abs(relative @ axes(bodies)[0]),
        closing=jnp.hypot(relative[0], relative[1]),
        energy=energy,
        gains_energy=gains_energy(energy),
        reverses_sliding=reverses_sliding(approach, bodies, coefficients),
        pulls=pulls(approach, bodies, coefficients),
    )


def reverses_sliding(
    approach: SixNumbers, bodies: Bodies, coefficients: Coefficients
) -> Bool[Array, ""]:
    """Whether friction reverses the sliding, or accelerates it.

    Args:
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        coefficients: e, mu and e_m.

    Returns:
        True where mu exceeds its critical value, beyond rounding, or has the other sign.
    """
    e, mu, e_m = coefficients
    critical = critical_mu(approach, bodies, e, e_m)
    # not a quotient: the critical value may be infinite, with a sign
    exceeds = jnp.abs(mu) > (1 + REVERSAL) * jnp.abs(critical)
    return jnp.logical_or(exceeds, mu * critical < 0)


def pulls(approach: SixNumbers, bodies: Bodies, coefficients: Coefficients) -> Bool[Array, ""]:
    """Whether the normal impulse is tensile, which no contact can transmit.

    Eq 22 asks for it where the moment alone would part the contact points faster than e allows: at
    a closing speed that is small beside what the spins make of it.

    Args:
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        coefficients: e, mu and e_m.

    Returns:
        True where the impulse has the direction of the closing.
    """
    P, _ = impulse(approach, bodies, coefficients)
    normal, _ = axes(bodies)
    return (P @ normal) * (contact_velocity(approach, bodies) @ normal) > 0


def clock(pdof: Float[Array, "*any"] | Sequence[float] | float) -> Int[Array, "*any"]:
    """A direction of force as the hour of a clock laid on the vehicle, 12 straight ahead.

    Args:
        pdof: principal direction of force, clockwise from straight ahead, rad.

    Returns:
        The nearest hour, 1 to 12; 0 for NaN, where there is no force.
    """
    hour = jnp.mod(jnp.round(jnp.asarray(pdof) * 6 / jnp.pi) - 1, 12) + 1
    return jnp.nan_to_num(hour).astype(int)


def _kinetic_energy(state: State, bodies: Bodies) -> Scalar:
    m_a, m_b, I_a, I_b = bodies[:4]
    masses = jnp.stack([m_a, m_a, I_a, m_b, m_b, I_b])
    return 0.5 * (jnp.where(jnp.isinf(masses), 0, masses) @ state**2)
