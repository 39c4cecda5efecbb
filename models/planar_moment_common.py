"""The planar impact with a moment impulse, in which sliding ends (μ = μ_c)."""

from __future__ import annotations

from retrodict.models import parts
from retrodict.models.card import Card
from retrodict.models.impact import E_M, NO_SLIP, E, Impact, Separation, planar_unknowns

from retrodict.mechanics import Coefficients, critical_mu

LEVELS = (E, E_M, NO_SLIP)


def story(structure: parts.Structure, data: parts.Data, x: parts.Values) -> Separation:
    """B's approach, restitution, moment: then eqs 19-24."""
    to, before = parts.bodies(x), parts.approach(structure, data, x)
    e = parts.restitution(data, before, to)
    e_m = parts.moment_coefficient(data)
    mu = critical_mu(before, to, e, e_m)
    return parts.collide(before, to, Coefficients(e, mu, e_m))


IMPACT = Impact(
    card=Card(
        name="planar-moment-common",
        title="planar impact with moment impulse that ends the sliding (e, e_m)",
        equations=(
            "momentum along x and y: SAE 770014 eqs 19, 20",
            "angular momentum: SAE 770014 eq 21, its misprinted last term corrected to "
            "m_a (d2+d4)(V_ay − v_ay)",
            "restitution e along the normal of the contact line: SAE 770014 eq 22",
            "sliding along the contact line ends within the contact: μ of eq 23 at its critical value",
            "impact moment coefficient e_m: SAE 770014 eq 24, the sign of its bracket corrected, so "
            "that Ω_b − Ω_a = e_m [(ω_b + f_b/I_b) − (ω_a + f_a/I_a)]",
        ),
        assumptions=(
            "the impact is short: vehicles do not move and tyres do nothing while it lasts",
            "the vehicles reach a common velocity along the contact line: μ = μ_c",
        ),
        left_out=("secondary impacts, and crush as evidence",),
    ),
    story=story,
    answers=("speed_b", "e", "e_m"),
    levels=LEVELS,
    unknowns=planar_unknowns(LEVELS),
    priors=("speed_b", "omega_b", "e", "e_m"),
    fullness=frozenset({"contact", "e_m"}),
)
