"""The planar impact without a moment impulse (SAE 770014 eqs 19-23, e_m = 1)."""

from __future__ import annotations

import jax.numpy as jnp
from retrodict.models import parts
from retrodict.models.card import Card
from retrodict.models.impact import NO_MOMENT, E, Impact, Separation, planar_unknowns

from retrodict.mechanics import Coefficients

LEVELS = (E, NO_MOMENT)


def story(structure: parts.Structure, data: parts.Data, x: parts.Values) -> Separation:
    """B's approach, restitution, friction: then eqs 19-24."""
    to, before = parts.bodies(x), parts.approach(structure, data, x)
    e = parts.restitution(data, before, to)
    e_m = jnp.ones(())
    mu = parts.friction(data, before, to, e, e_m)
    return parts.collide(before, to, Coefficients(e, mu, e_m))


IMPACT = Impact(
    card=Card(
        name="planar",
        title="planar impact (e, μ)",
        equations=(
            "momentum along x and y: SAE 770014 eqs 19, 20",
            "angular momentum: SAE 770014 eq 21, its misprinted last term corrected to "
            "m_a (d2+d4)(V_ay − v_ay)",
            "restitution e and equivalent friction μ along the contact line: SAE 770014 eqs 22, 23",
            "no moment impulse: SAE 770014 eq 24 with e_m = 1",
        ),
        assumptions=(
            "the impact is short: vehicles do not move and tyres do nothing while it lasts",
            "the contact passes no moment impulse: e_m = 1",
        ),
        left_out=("secondary impacts, and crush as evidence",),
    ),
    story=story,
    answers=("speed_b", "e", "mu"),
    levels=LEVELS,
    unknowns=planar_unknowns(LEVELS),
    priors=("speed_b", "omega_b", "e", "mu"),
    fullness=frozenset({"contact", "mu"}),
)
