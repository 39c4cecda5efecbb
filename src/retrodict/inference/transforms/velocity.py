"""Coordinates for scenes whose rest poses do not pin the motion after the impact.

Where of no vehicle with locked wheels any rest was measured, q holds velocities after the impact, which
is what the evidence speaks of; B's yaw rate before it, e_m and the share of the sliding that is kept, of
which it says less; and the measured inputs as standard normal deviates. (With yaw rates after the impact
in their place, e_m would be a quotient by the spin that the force alone makes, and where that may vanish
the density has a spike. With A's velocity along the contact line, so would the share.) Of B's velocity
only the part along a course that is known stands in q, beside the deviate of the course.

The force impulse along the normal follows from A's change of velocity, that along the tangent from the
share, and with both e and mu, and B's approach. Where A struck a barrier, there is no B, and A's speed
before the impact is one of the inputs. The normal part is moved to where e is within bounds,
softly in m/s: in e itself that bound would be the steeper the slower the vehicles close. All of it is
smooth, in closed form, and differentiated as it stands.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.special import ndtr, ndtri
from jaxtyping import Array, Float

from retrodict.inference.transforms.parameters import Q, TransformParameters
from retrodict.inference.transforms.protocol import Located, Transform
from retrodict.inference.transforms.soft_bounds import (
    soft_interval,
    soft_lower_bound,
    soft_lower_bound_inverse,
)
from retrodict.mechanics import (
    axes,
    contact_velocity,
    friction_impulse,
    normal_impulse,
    restitution,
)
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import E_M, SLIDING, E

_SOFTNESS = 1.0  # of the opening velocity where e is bounded, m/s
_SLOWLY = 0.5  # softness at zero of B's speed along a known course, m/s
KEPT = 0.2  # softness of the share of the sliding where nothing is known yet: its prior's scale
_INSIDE = 1e-6  # of e_m's range: how near to a bound a search may begin


def names(structure: Structure) -> tuple[str, ...]:
    """What stands in q before the deviates of the measured inputs."""
    levels = RUNGS[structure.rung].impact.levels
    course_known = "direction_b" in structure.known_of_b
    # then velocities lie in a wedge, narrow where B is slow
    of_b = ("V_along", "direction_b") if course_known else ("Vbx", "Vby")
    if not levels:  # momentum alone: yaw rates are unknowns of their own
        more = ("Omega_a", "Omega_b") if "heading" in structure.rests else ()
        return ("Vax", "Vay", *of_b, *more)
    free = [
        name for name, is_free in (("e_m", E_M in levels), ("kept", SLIDING in levels)) if is_free
    ]
    return ("Va_normal", *(() if structure.barrier else (*of_b, "omega_b")), *free)


def locate(
    structure: Structure, data: Data, q: Float[Array, " q"]
) -> tuple[parts.Values, Float[Array, ""]]:
    """The model's unknowns at q.

    Args:
        structure: of the scene.
        data: its numbers.
        q: as `names` says, then deviates of the inputs, shape (q,).

    Returns:
        A value for each of the model's sample sites, and log |d sites / d q|.
    """
    own = names(structure)
    u, xi = dict(zip(own, q, strict=False)), q[len(own) :]
    x = parts.from_standard(structure, data, xi)
    scale_a, scale_b = _scales(structure, data, x)
    m_a, m_b, approach_a = x["mass_a"], x.get("mass_b", np.inf), parts.approach_of_a(x)
    to = parts.bodies(x)
    normal = axes(to)[0]
    if "Va_normal" in u:  # the impulse along the tangent is not known yet
        raw_P_n = m_a * (scale_a * u["Va_normal"] - approach_a[:2] @ normal)
        P, log_det = raw_P_n * normal, jnp.log(m_a * scale_a)
    else:
        P = m_a * (scale_a * jnp.stack([u["Vax"], u["Vay"]]) - approach_a[:2])
        log_det = 2 * jnp.log(m_a * scale_a)
    sites: parts.Values = {"measured": xi} if structure.uncertain else {}
    if structure.barrier:
        v_b = jnp.zeros(2)
    elif "V_along" in u:
        middle, sd = data.inputs["direction_b"]
        raw = scale_b * u["V_along"] + _unit(middle) @ P / m_b
        speed, log_slope = soft_lower_bound(raw, _SLOWLY)
        direction = middle + sd * u["direction_b"]
        v_b = speed * _unit(direction)
        sites |= {"speed_b": speed, "direction_b": direction}
        log_det += jnp.log(scale_b * sd) + log_slope
    else:
        v_b = scale_b * jnp.stack([u["Vbx"], u["Vby"]]) + P / m_b
        log_det += 2 * jnp.log(scale_b)
    if not RUNGS[structure.rung].impact.levels:
        sites |= {"impulse_x": P[0], "impulse_y": P[1]}
        if "Omega_a" in u:
            sites |= {"Omega_a": scale_a * u["Omega_a"], "Omega_b": scale_b * u["Omega_b"]}
            log_det += jnp.log(scale_a * scale_b)
    else:
        omega_b, e_m = u.get("omega_b", jnp.zeros(())), jnp.ones(())
        sites |= {} if structure.barrier else {"omega_b": omega_b}
        if "e_m" in u:
            e_m = E_M.low + (E_M.high - E_M.low) * ndtr(u["e_m"])
            log_det += np.log((E_M.high - E_M.low) / np.sqrt(2 * np.pi)) - u["e_m"] ** 2 / 2
            sites["e_m"] = e_m
        before = jnp.concatenate([approach_a, v_b, omega_b[None]])

        kept = KEPT * u.get("kept", 0.0)
        if "kept" in u:
            log_det += np.log(KEPT)
            if not structure.interlocked:
                kept, log_slope = soft_lower_bound(kept, KEPT)
                log_det += log_slope

        def restitution_by(P_n: Array) -> Array:
            P_t = friction_impulse(kept, P_n, before, to, e_m)
            return jnp.asarray(restitution(jnp.stack([P_n, P_t]), before, to, e_m))

        def friction_by(kept: Array) -> Array:
            P_n = normal_impulse(e, kept, before, to, e_m)
            return jnp.asarray(friction_impulse(kept, P_n, before, to, e_m) / P_n)

        # the normal impulse, moved to where e is within bounds
        softness = _SOFTNESS / jnp.abs(contact_velocity(before, to) @ normal)
        raw_e, slope = jax.jvp(restitution_by, (raw_P_n,), (jnp.ones(()),))
        e, log_slope = soft_interval(raw_e, softness, E.low, E.high)
        log_det += jnp.log(jnp.abs(slope)) + log_slope
        if "kept" in u:
            sites["mu"], slope = jax.jvp(friction_by, (kept,), (jnp.ones(()),))
            log_det += jnp.log(jnp.abs(slope))
        sites["e"] = e
    if structure.barrier or "speed_b" in sites:
        return sites, log_det
    speed, direction = jnp.hypot(*v_b), jnp.arctan2(v_b[1], v_b[0])
    if "direction_b" in structure.known_of_b:  # its representative nearest to what was measured
        middle = data.inputs["direction_b"][0]
        direction = middle + jnp.arctan2(jnp.sin(direction - middle), jnp.cos(direction - middle))
    return sites | {"speed_b": speed, "direction_b": direction}, log_det - jnp.log(speed)


def _unit(direction: Float[Array, ""]) -> Float[Array, "2"]:
    return jnp.stack([jnp.cos(direction), jnp.sin(direction)])


def coordinates_near(
    structure: Structure, data: Data, crash: parts.Values
) -> Float[np.ndarray, " q"]:
    """About where a crash lies: q, but for the softness of bounds.

    Args:
        structure: of the scene.
        data: its numbers.
        crash: the model's unknowns and what follows from them.
    """
    xi = jnp.asarray(crash.get("measured", np.zeros(0)))
    x = parts.from_standard(structure, data, xi)
    scale = dict(zip("ab", _scales(structure, data, x), strict=True))
    own, (normal, tangent) = names(structure), axes(parts.bodies(x))
    of_a, of_b = (
        jnp.stack([crash.get(f"V{v}{axis}", np.zeros(())) for axis in "xy"]) for v in "ab"
    )
    if "Va_normal" in own and not structure.barrier:
        # B's but for what the impulse along the tangent makes of it
        P_t = x["mass_a"] * (of_a - parts.approach_of_a(x)[:2]) @ tangent
        of_b = of_b + P_t / x["mass_b"] * tangent
    values = dict(zip(("Vbx", "Vby"), of_b, strict=True)) | {"Va_normal": of_a @ normal}
    q = []
    for name in own:
        if name == "e_m":
            share = (crash["e_m"] - E_M.low) / (E_M.high - E_M.low)
            q.append(ndtri(np.clip(share, _INSIDE, 1 - _INSIDE)))
        elif name == "omega_b":
            q.append(crash["omega_b"])
        elif name == "direction_b":
            middle, sd = data.inputs["direction_b"]
            q.append((crash["direction_b"] - middle) / sd)
        elif name == "kept":
            kept = 1 - crash["mu"] / crash["mu_critical"]  # near enough
            raw = (
                float(kept)
                if structure.interlocked
                else soft_lower_bound_inverse(float(kept), KEPT)
            )
            q.append(jnp.asarray(raw / KEPT))
        elif name == "V_along":
            q.append(of_b @ _unit(data.inputs["direction_b"][0]) / scale["b"])
        else:
            vehicle = "b" if name in parts.AFTER[1] else "a"
            q.append((crash | values)[name] / scale[vehicle])
    return np.concatenate([np.array(q, float), np.asarray(xi)])


def _scales(structure: Structure, data: Data, x: parts.Values) -> Float[Array, "2"]:
    """Square root of what holds A and B back over what does as measured: with any, they go as far.

    Nothing of a barrier counts.
    """
    if not structure.rested:
        return jnp.ones(2)
    as_measured = parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))
    held = parts.drag_factors(structure, x) / parts.drag_factors(structure, as_measured)
    return jnp.sqrt(jnp.broadcast_to(held, (2,)))


class Velocity(Transform):
    """Velocities after the impact are coordinates: rest poses do not determine the motion."""

    exact_gradient = True
    refit_to_draws = True
    by_regressions = False
    by_prior_pilot = True

    def length(self, structure: Structure) -> int:
        """Number of entries of q."""
        return len(names(structure)) + len(structure.uncertain)

    def from_q(
        self,
        structure: Structure,
        data: Data,
        parameters: TransformParameters,
        q: Q,
        log_det: Float[Array, ""],
    ) -> Located:
        """The unknowns, the log determinant with that given, and q as it was moved."""
        sites, volume = locate(structure, data, q)
        return sites, volume + log_det, q
