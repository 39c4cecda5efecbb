"""The planar impact without a moment impulse (SAE 770014 eqs 19-23, e_m = 1)."""

from __future__ import annotations

import jax.numpy as jnp
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import NO_MOMENT, SLIDING, E, Separation, planar

from retrodict.mechanics import Coefficients


def story(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """B's approach, restitution, friction: then eqs 19-24."""
    to, before = parts.bodies(x), parts.approach(structure, data, x)
    e = parts.restitution(data, before, to)
    e_m = jnp.ones(())
    mu = parts.friction(structure, data, before, to, e, e_m)
    return parts.collide(before, to, Coefficients(e, mu, e_m))


IMPACT = planar(
    "planar",
    "planar impact (e, μ)",
    (E, NO_MOMENT, SLIDING),
    story,
)
