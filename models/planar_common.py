"""The planar impact without a moment impulse, in which sliding ends (e_m = 1, μ = μ_c)."""

from __future__ import annotations

import jax.numpy as jnp
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import NO_MOMENT, NO_SLIP, E, Separation, planar

from retrodict.mechanics import Coefficients, critical_mu


def story(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """B's approach, restitution: then eqs 19-24."""
    to, before = parts.bodies(x), parts.approach(structure, data, x)
    e = parts.restitution(data, before, to)
    e_m = jnp.ones(())
    mu = critical_mu(before, to, e, e_m)
    return parts.collide(before, to, Coefficients(e, mu, e_m))


IMPACT = planar(
    "planar-common",
    "planar impact that ends the sliding (e)",
    (E, NO_MOMENT, NO_SLIP),
    story,
)
