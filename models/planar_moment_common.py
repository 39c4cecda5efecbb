"""The planar impact with a moment impulse, in which sliding ends (μ = μ_c)."""

from __future__ import annotations

from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import E_M, NO_SLIP, E, Separation, planar

from retrodict.mechanics import Coefficients, critical_mu


def story(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """B's approach, restitution, moment: then eqs 19-24."""
    to, before = parts.bodies(x), parts.approach(structure, data, x)
    e = parts.restitution(data, before, to)
    e_m = parts.moment_coefficient(data)
    mu = critical_mu(before, to, e, e_m)
    return parts.collide(before, to, Coefficients(e, mu, e_m))


IMPACT = planar(
    "planar-moment-common",
    "planar impact with moment impulse that ends the sliding (e, e_m)",
    (E, E_M, NO_SLIP),
    story,
)
