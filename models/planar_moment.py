"""The planar impact of SAE 770014, eqs 19-24, with its moment impulse."""

from __future__ import annotations

from retrodict.models import parts
from retrodict.models.card import Card
from retrodict.models.impact import E_M, E, Impact, Separation, planar_unknowns

from retrodict.mechanics import Coefficients

LEVELS = (E, E_M)


def story(structure: parts.Structure, data: parts.Data, x: parts.Values) -> Separation:
    """B's approach, restitution, moment, friction: then eqs 19-24."""
    to, before = parts.bodies(x), parts.approach(structure, data, x)
    e = parts.restitution(data, before, to)
    e_m = parts.moment_coefficient(data)
    mu = parts.friction(data, before, to, e, e_m)
    return parts.collide(before, to, Coefficients(e, mu, e_m))


IMPACT = Impact(
    card=Card(
        name="planar-moment",
        title="planar impact with moment impulse (e, μ, e_m)",
        equations=(
            "momentum along x and y: SAE 770014 eqs 19, 20",
            "angular momentum: SAE 770014 eq 21, its misprinted last term corrected to "
            "m_a (d2+d4)(V_ay − v_ay)",
            "restitution e and equivalent friction μ along the contact line: SAE 770014 eqs 22, 23",
            "impact moment coefficient e_m: SAE 770014 eq 24, the sign of its bracket corrected, so "
            "that Ω_b − Ω_a = e_m [(ω_b + f_b/I_b) − (ω_a + f_a/I_a)]",
        ),
        assumptions=(
            "the impact is short: vehicles do not move and tyres do nothing while it lasts",
        ),
        left_out=("secondary impacts, and crush as evidence",),
    ),
    story=story,
    answers=("speed_b", "e", "e_m", "mu"),
    levels=LEVELS,
    unknowns=planar_unknowns(LEVELS),
    priors=("speed_b", "omega_b", "e", "e_m", "mu"),
    fullness=frozenset({"contact", "mu", "e_m"}),
)
