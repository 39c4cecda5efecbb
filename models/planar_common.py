"""The planar impact without a moment impulse, in which sliding ends (e_m = 1, μ = μ_c)."""

from __future__ import annotations

import jax.numpy as jnp
from retrodict.models import parts
from retrodict.models.card import Card
from retrodict.models.impact import NO_MOMENT, NO_SLIP, E, Impact, Separation, planar_unknowns

from retrodict.mechanics import Coefficients, critical_mu

LEVELS = (E, NO_MOMENT, NO_SLIP)


def story(structure: parts.Structure, data: parts.Data, x: parts.Values) -> Separation:
    """B's approach, restitution: then eqs 19-24."""
    to, before = parts.bodies(x), parts.approach(structure, data, x)
    e = parts.restitution(data, before, to)
    e_m = jnp.ones(())
    mu = critical_mu(before, to, e, e_m)
    return parts.collide(before, to, Coefficients(e, mu, e_m))


IMPACT = Impact(
    card=Card(
        name="planar-common",
        title="planar impact that ends the sliding (e)",
        equations=(
            "momentum along x and y: SAE 770014 eqs 19, 20",
            "angular momentum: SAE 770014 eq 21, its misprinted last term corrected to "
            "m_a (d2+d4)(V_ay − v_ay)",
            "restitution e along the normal of the contact line: SAE 770014 eq 22",
            "sliding along the contact line ends within the contact: μ of eq 23 at its critical value",
            "no moment impulse: SAE 770014 eq 24 with e_m = 1",
        ),
        assumptions=(
            "the impact is short: vehicles do not move and tyres do nothing while it lasts",
            "the contact passes no moment impulse: e_m = 1",
            "the vehicles reach a common velocity along the contact line: μ = μ_c",
        ),
        left_out=("secondary impacts, and crush as evidence",),
    ),
    story=story,
    answers=("speed_b", "e"),
    levels=LEVELS,
    unknowns=planar_unknowns(LEVELS),
    priors=("speed_b", "omega_b", "e"),
    fullness=frozenset({"contact"}),
)
