"""Momentum alone (SAE 770014 eqs 19, 20): B's velocity from that of A and both after the impact."""

from __future__ import annotations

import jax.numpy as jnp
import numpyro
from jaxtyping import Array, Float
from numpyro import distributions as dist
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description
from retrodict.models.impact import MOMENTUM, SHORT, Impact, Separation


def forward_model(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """B's approach, an impulse and yaw rates from wide priors; then momentum, eqs 19 and 20."""
    m_a, m_b = x["mass_a"], x["mass_b"]
    v_a = parts.approach_of_a(x)[:2]

    v_b = parts.velocity_of_b(structure, data)

    # the impact
    impulse = dist.Normal(0.0, m_a * data.priors["impulse"][0])
    P = jnp.stack([numpyro.sample("impulse_x", impulse), numpyro.sample("impulse_y", impulse)])
    V_a, V_b = v_a + P / m_a, v_b - P / m_b  # eqs 19, 20
    # the contact pushes: A away from B, whose centre of gravity lies beyond the impact centre
    lever_a, lever_b = parts.levers(x)
    parts.close_in(jnp.minimum((v_b - v_a) @ P, (lever_b - lever_a) @ P))
    if "heading" in structure.rests:
        spin = dist.Normal(0.0, data.priors["Omega"][0])
        Omega_a, Omega_b = numpyro.sample("Omega_a", spin), numpyro.sample("Omega_b", spin)
        after = jnp.stack([*V_a, Omega_a, *V_b, Omega_b])
    else:
        after = jnp.concatenate([V_a, V_b])
    parts.record_motion(jnp.concatenate([V_a, V_b]), jnp.stack([P / m_a, -P / m_b]))
    return after


def unknowns(after: Separation, x: parts.Values) -> tuple[parts.Values, Float[Array, ""]]:
    """The unknowns that lead to these velocities after the impact, and the log determinant."""
    m_a, m_b = x["mass_a"], x["mass_b"]
    V_a, V_b = after.reshape(2, -1)
    P = m_a * (V_a[:2] - parts.approach_of_a(x)[:2])
    sites = {"velocity_b": V_b[:2] + P / m_b, "impulse_x": P[0], "impulse_y": P[1]}
    if V_a.size == 3:
        sites |= {"Omega_a": V_a[2], "Omega_b": V_b[2]}
    return sites, 2 * jnp.log(m_a)


IMPACT = Impact(
    description=Description(
        name="momentum",
        title="momentum alone",
        equations=MOMENTUM,
        assumptions=(
            SHORT,
            "impulse and yaw rates after the impact may be anything: no coefficient of the impact "
            "is used or found",
        ),
        left_out=("restitution, friction and moment of the contact; where the vehicles touched",),
    ),
    forward_model=forward_model,
    answers=("speed_a", "speed_b"),
    levels=(),
    unknowns=unknowns,
    priors=("speed_a", "speed_b", "impulse", "Omega"),
    nesting=frozenset(),
)
