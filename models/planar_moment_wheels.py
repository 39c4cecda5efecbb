"""The rung of SAE 770014: planar impact with a moment impulse, then two skids on four locked wheels."""

from __future__ import annotations

import jax.numpy as jnp
import numpyro
import numpyro.distributions as dist
from retrodict.models import parts
from retrodict.models.card import Card

from retrodict.mechanics import Coefficients, audit, critical_mu, separation

SPEED_SCALE = 30.0  # m/s
OMEGA_SCALE = 1.0  # rad/s
E_SCALE = 0.2
MU_SCALE = 1.0

CARD = Card(
    name="planar-moment-wheels",
    title="Planar impact with moment impulse (e, μ, e_m), then a skid to rest on four locked wheels",
    equations=(
        "momentum along x and y: SAE 770014 eqs 19, 20",
        "angular momentum: SAE 770014 eq 21, its misprinted last term corrected to "
        "m_a (d2+d4)(V_ay − v_ay)",
        "restitution e and equivalent friction μ along the contact line: SAE 770014 eqs 22, 23",
        "impact moment coefficient e_m: SAE 770014 eq 24, the sign of its bracket corrected, so that "
        "Ω_b − Ω_a = e_m [(ω_b + f_b/I_b) − (ω_a + f_a/I_a)]",
        "run-out: planar rigid body on four locked wheels with static loads, friction f exp(−c v) "
        "against the slip of each wheel, in the spirit of Ellis, which SAE 770014 cites",
    ),
    assumptions=(
        "the impact is short: vehicles do not move and tyres do nothing while it lasts",
        "all four wheels of both vehicles are locked, or slide as if they were, from impact to rest",
        "the road is plane and level; both vehicles slide on the same friction where they cross the "
        "same surface",
        "A's approach, the friction and the vehicles' data are normal (or lognormal where they "
        "cannot be negative) about what was measured, and independent of one another",
    ),
    left_out=(
        "rolling, steering or braking in between; load transfer, pitch and roll; slopes",
        "secondary impacts, and crush as evidence",
    ),
    priors=(
        (
            "speed of B",
            f"half-normal, scale {SPEED_SCALE:g} m/s",
            "nearly flat over road speeds (95 % below 59 m/s); the evidence speaks",
        ),
        ("direction of travel of B", "uniform over the circle", "none is favoured unless measured"),
        (
            "yaw rate of B",
            f"normal, 0 ± {OMEGA_SCALE:g} rad/s",
            "before impact a car seldom yaws faster than 1–2 rad/s; unless measured (judgement)",
        ),
        (
            "e",
            f"half-normal, scale {E_SCALE:g}, cut at 1",
            "staged car crashes: mean 0.09, largest 0.28 (SAE 2014-01-0469); higher at low speed",
        ),
        ("e_m", "uniform on (−1, 1)", "the whole range that SAE 770014 allows"),
        (
            "μ",
            f"normal, 0 ± {MU_SCALE:g}",
            "either direction of sliding; published values are mostly 0.3–1 in size, −1.6 seen "
            "(SAE 770014, 871993, 2014-01-0469)",
        ),
    ),
)


def model(
    structure: parts.Structure, data: parts.Data, rest_poses: parts.RestPoses = parts.rest_poses
) -> None:
    """The forward story: what was measured, B's approach, the impact, two skids, what was found.

    Args:
        structure: which inputs are uncertain and which surfaces there are.
        data: the scene's numbers.
        rest_poses: the skids, for who knows their slopes already.
    """
    x = parts.measured(structure, data)

    speed_b = numpyro.sample("speed_b", dist.HalfNormal(SPEED_SCALE))
    direction_b = numpyro.sample("direction_b", _prior_direction(structure, data))
    omega_b = numpyro.sample("omega_b", _prior_yaw_rate(structure, data))
    e = numpyro.sample("e", dist.TruncatedNormal(0.0, E_SCALE, low=0.0, high=1.0))
    mu = numpyro.sample("mu", dist.Normal(0.0, MU_SCALE))
    e_m = numpyro.sample("e_m", dist.Uniform(-1.0, 1.0))

    v_bx = numpyro.deterministic("vbx", speed_b * jnp.cos(direction_b))
    v_by = numpyro.deterministic("vby", speed_b * jnp.sin(direction_b))
    approach = jnp.concatenate([parts.approach_of_a(x), jnp.stack([v_bx, v_by, omega_b])])
    bodies, coefficients = parts.bodies(x), Coefficients(e, mu, e_m)
    after = separation(approach, bodies, coefficients)

    poses = rest_poses(structure, data, x, after)
    parts.observe(data, poses)

    for name, value in zip(("Vax", "Vay", "Omega_a", "Vbx", "Vby", "Omega_b"), after, strict=True):
        numpyro.deterministic(name, value)
    change = after - approach
    numpyro.deterministic("delta_v_a", jnp.hypot(change[0], change[1]))
    numpyro.deterministic("delta_v_b", jnp.hypot(change[3], change[4]))
    energy = audit(approach, bodies, coefficients)
    numpyro.deterministic("energy_lost", energy.before - energy.after)
    numpyro.deterministic("moment_work", energy.moment)
    numpyro.deterministic("mu_critical", critical_mu(approach, bodies, e, e_m))


def _prior_direction(structure: parts.Structure, data: parts.Data) -> dist.Distribution:
    if "direction_b" in structure.known_of_b:
        return dist.Normal(*data.inputs["direction_b"])
    return dist.Uniform(-jnp.pi, jnp.pi)


def _prior_yaw_rate(structure: parts.Structure, data: parts.Data) -> dist.Distribution:
    if "omega_b" in structure.known_of_b:
        return dist.Normal(*data.inputs["omega_b"])
    return dist.Normal(0.0, OMEGA_SCALE)
