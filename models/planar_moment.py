"""The planar impact of SAE 770014, eqs 19-24, with its moment impulse."""

from __future__ import annotations

from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import E_M, SLIDING, E, Separation, planar

from retrodict.mechanics import Coefficients


def story(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """B's approach, restitution, moment, friction: then eqs 19-24."""
    to, before = parts.bodies(x), parts.approach(structure, data, x)
    e = parts.restitution(data, before, to)
    e_m = parts.moment_coefficient(data)
    mu = parts.friction(structure, data, before, to, e, e_m)
    return parts.collide(before, to, Coefficients(e, mu, e_m))


IMPACT = planar(
    "planar-moment",
    "planar impact with moment impulse (e, μ, e_m)",
    (E, E_M, SLIDING),
    story,
)
