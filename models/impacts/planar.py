"""The planar impact of SAE 770014 (eqs 19-24), in four variants.

The impact moment coefficient e_m is either unknown or fixed at 1 (no moment impulse). The equivalent
friction mu is either unknown or fixed at mu_c (sliding ends within the contact).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpyro
from jaxtyping import Array, Float
from numpyro import distributions as dist
from retrodict.models import evidence, parts, priors
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description
from retrodict.models.friction import Friction
from retrodict.models.impact import (
    E_M,
    MOMENTUM,
    NO_MOMENT,
    NO_SLIP,
    SHORT,
    SLIDING,
    E,
    Impact,
    Separation,
)
from retrodict.models.priors import Number

from retrodict.mechanics import (
    Bodies,
    Coefficients,
    audit,
    axes,
    closing_speed,
    contact_velocity,
    critical_mu,
    either_side,
    impulse,
    inverse_log_det,
    separation,
    towards_b,
    undo,
)


def forward_model(
    free: tuple[str, ...], structure: Structure, data: Data, x: parts.Values
) -> Separation:
    """B's approach, restitution, moment coefficient and friction; then the impact, eqs 19-24.

    Args:
        free: names of the unknown coefficients, of "e_m" and "mu".
        structure: static structure of the scene: vehicles, and which velocities of B were measured.
        data: measured values and priors.
        x: measured inputs by name.

    Returns:
        Velocities after the impact, shape (6,): x and y (m/s) and yaw rate (rad/s), A's first; shape
        (3,), A's alone, where A struck a barrier, which keeps still.
    """
    bodies = parts.bodies(x)
    of_b = jnp.zeros(3) if structure.single else parts.approach_of_b(structure, data)
    before = jnp.concatenate([parts.approach_of_a(x), of_b])

    # coefficient of restitution: lower at higher closing speeds
    closing = jnp.abs(closing_speed(before, bodies))
    e = priors.unknown("e", structure, data, partial(_of_e, closing))

    # impact moment coefficient
    e_m = jnp.ones(())
    if "e_m" in free:
        e_m = priors.unknown("e_m", structure, data, _of_e_m)

    # equivalent friction, up to the mu_c that just ends the sliding
    mu_c = critical_mu(before, bodies, e, e_m)
    mu: Array | float = mu_c
    if "mu" in free:
        mu = _mu(structure, data, jnp.nan_to_num(mu_c, posinf=1e9, neginf=-1e9))

    coefficients = Coefficients(e, mu, e_m)
    after = separation(before, bodies, coefficients)  # eqs 19-24
    lost = _record(before, bodies, coefficients, mu_c, after)
    measurable = {"energy_lost": lost, "e": e, "e_m": e_m, "mu": jnp.abs(mu)}
    evidence.observe_impact(structure, data, measurable)
    moved = 3 * len(structure.vehicles)
    parts.record_motion(after[:moved], (after - before)[:moved].reshape(-1, 3)[:, :2])
    return after[:moved]


def _of_e(
    closing: Float[Array, ""], fast: Number, slow: Number, decay: Number
) -> dist.Distribution:
    """Law of e at a closing speed, m/s."""
    scale = fast + (slow - fast) * jnp.exp(-closing / decay)
    return dist.TruncatedNormal(0.0, scale, low=0.0, high=1.0)


def _of_e_m(centre: Number, scale: Number) -> dist.Distribution:
    """Law of e_m."""
    return dist.TruncatedNormal(centre, scale, low=-1.0, high=1.0)


def _mu(structure: Structure, data: Data, mu_c: Float[Array, ""]) -> Float[Array, ""]:
    """Sample mu, or the friction of the user's own that the contact can exert, of the sign of mu_c."""
    if structure.family("mu") is None:
        scale, median = data.priors["mu"]
        return numpyro.sample("mu", Friction(mu_c, scale, median, structure.interlocked))
    friction = priors.unknown("mu", structure, data, site="mu_available")
    size = friction if structure.interlocked else jnp.minimum(friction, jnp.abs(mu_c))
    return numpyro.deterministic("mu", jnp.where(mu_c < 0, -size, size))


def _record(
    before: Float[Array, "6"],
    bodies: Bodies,
    coefficients: Coefficients,
    mu_c: Float[Array, ""] | float,
    after: Float[Array, "6"],
) -> Float[Array, ""]:
    """Record energies (the one lost is returned), closing speed, normal impulse and mu_c.

    Vehicles that part are ruled out.
    """
    energy = audit(before, bodies, coefficients)
    lost = numpyro.deterministic("energy_lost", jnp.asarray(energy.before - energy.after))
    numpyro.deterministic("moment_work", energy.moment)
    closing = contact_velocity(before, bodies) @ axes(bodies)[0]
    # if both centres lie on one side of the contact line, only their motion shows the direction
    sign = jnp.where(either_side(bodies), towards_b(bodies), jnp.sign(closing))
    parts.close_in(numpyro.deterministic("closing_speed", closing * sign))
    P_n = impulse(before, bodies, coefficients)[0] @ axes(bodies)[0]
    numpyro.deterministic("normal_impulse", -P_n * sign)
    numpyro.deterministic("mu_critical", mu_c)
    return lost


def unknowns(
    free: tuple[str, ...], after: Separation, x: parts.Values
) -> tuple[parts.Values, Float[Array, ""]]:
    """The unknowns that lead to these velocities after the impact, and the log determinant.

    Args:
        free: names of the unknown coefficients, of "e_m" and "mu".
        after: velocities after the impact, A's first, m/s and rad/s.
        x: measured inputs by name.

    Returns:
        The values of the sample sites and the log determinant, as for `Impact.unknowns`.
    """
    bodies, approach_a = parts.bodies(x), parts.approach_of_a(x)
    approach_b, found, log_det = inverse_log_det(after, approach_a, bodies)
    e, mu, e_m = map(jnp.asarray, found)
    sites = {"velocity_b": approach_b[:2], "omega_b": approach_b[2], "e": e}
    # the quantity that is fixed in place of a coefficient replaces it in the determinant
    if "e_m" in free:
        sites["e_m"] = e_m
    else:
        log_det = log_det + jnp.log(jnp.abs(undo(after, approach_a, bodies).free_spin))
        e_m = jnp.ones(())
    if "mu" in free:
        sites["mu"] = mu
    else:
        before = jnp.concatenate([approach_a, approach_b])

        def slip(mu: Array) -> Array:
            end = separation(before, bodies, Coefficients(e, mu, e_m))
            return contact_velocity(end, bodies) @ axes(bodies)[1]

        slope = jax.jvp(slip, (mu,), (jnp.ones(()),))[1]
        log_det = log_det + jnp.log(jnp.abs(slope))
    return sites, jnp.asarray(log_det)


# equations and assumptions of each coefficient, where it is unknown and where it is fixed
_EQUATIONS = {
    ("mu", True): (
        "restitution e and equivalent friction μ along the contact line: SAE 770014 eqs 22, 23",
    ),
    ("mu", False): (
        "restitution e along the normal of the contact line: SAE 770014 eq 22",
        "sliding along the contact line ends within the contact: μ of eq 23 at its critical value",
    ),
    ("e_m", True): (
        "impact moment coefficient e_m: SAE 770014 eq 24, the sign of its bracket corrected, so "
        "that Ω_b − Ω_a = e_m [(ω_b + f_b/I_b) − (ω_a + f_a/I_a)]",
    ),
    ("e_m", False): ("no moment impulse: SAE 770014 eq 24 with e_m = 1",),
}
_ASSUMPTIONS = {
    ("e_m", True): (),
    ("e_m", False): ("the contact passes no moment impulse: e_m = 1",),
    ("mu", True): (
        "friction opposes the sliding along the contact line and does not reverse it, unless the "
        "scene says that parts interlocked",
    ),
    ("mu", False): ("sliding along the contact line ends before the contact does: μ = μ_c",),
}
_FIXED = "impulse and moment on A: SAE 770014 eqs 9 to 11; a barrier takes up any, and keeps still"
_MOMENT_OF_BARRIER = (
    "impact moment coefficient e_m: SAE 770014 eq 24, the sign of its bracket corrected, against what "
    "does not turn, so that Ω_a = e_m (ω_a + f_a/I_a)"
)


def _variant(name: str, title: str, *free: str) -> Impact:
    moment, friction = ("e_m", "e_m" in free), ("mu", "mu" in free)
    description = Description(
        name=name,
        title=title,
        equations=(
            *MOMENTUM,
            "angular momentum: SAE 770014 eq 21, its misprinted last term corrected to "
            "m_a (d2+d4)(V_ay − v_ay)",
            *_EQUATIONS[friction],
            *_EQUATIONS[moment],
        ),
        assumptions=(
            SHORT,
            "the vehicles close in, each from its own side of the contact where it has one",
            *_ASSUMPTIONS[moment],
            *_ASSUMPTIONS[friction],
        ),
        left_out=("secondary impacts, and how the vehicles crush",),
    )
    of_moment = (_MOMENT_OF_BARRIER,) if "e_m" in free else _EQUATIONS[moment]
    return Impact(
        description=description,
        forward_model=partial(forward_model, free),
        answers=("speed_a", "speed_b", "e", *free),
        levels=(E, E_M if "e_m" in free else NO_MOMENT, SLIDING if "mu" in free else NO_SLIP),
        unknowns=partial(unknowns, free),
        priors=("speed_a", "speed_b", "omega_a", "omega_b", "e", *free),
        nesting=frozenset({"contact", *free}),
        against_barrier=replace(
            description,
            equations=(_FIXED, *_EQUATIONS[friction], *of_moment),
            assumptions=(
                SHORT,
                "the barrier is rigid, and neither moves nor breaks; the vehicle closes in on it",
                *_ASSUMPTIONS[moment],
                *_ASSUMPTIONS[friction],
            ),
            left_out=(
                "secondary impacts, and how the vehicle crushes; one that climbs the barrier, dives "
                "under it or is held by it",
            ),
        ),
        evidence=evidence.of_impact("energy_lost", "e", *free),
        needs=("contact_line", "impact_centre"),
    )


IMPACTS = (
    _variant("planar-common", "planar impact that ends the sliding (e)"),
    _variant("planar", "planar impact (e, μ)", "mu"),
    _variant(
        "planar-moment-common",
        "planar impact with moment impulse that ends the sliding (e, e_m)",
        "e_m",
    ),
    _variant("planar-moment", "planar impact with moment impulse (e, μ, e_m)", "e_m", "mu"),
)
