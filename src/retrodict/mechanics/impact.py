"""Planar impact of two vehicles with a moment impulse (SAE 770014, eqs 9-24), both ways.

Lower case is before impact, upper case after. P acts on A and -P on B, M on A and -M on B. Two
equations of the paper are misprinted and stand here corrected: in eq 21 the last term is
m_a (d2 + d4)(V_ay - v_ay), and in eq 24 the bracket's sign is reversed, which makes it
Omega_b - Omega_a = e_m [(omega_b + f_b/I_b) - (omega_a + f_a/I_a)]: the share of the relative spin
left by the force impulse alone that survives the moment. The printed eq 24 is that equation with
e_m / (2 e_m - 1) for e_m (`printed_e_m`); `moment_equation="as-printed"` uses it.

Single-precision inputs are computed in single precision, to five digits of the largest velocity.

A barrier or structure is a body of infinite mass and inertia (`against_barrier`): every function
here divides by m and I, so it keeps its velocity exactly.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from retrodict.mechanics.contact import (
    Bodies,
    Scalar,
    SixNumbers,
    State,
    axes,
    contact_velocity,
)

MomentEquation = Literal["corrected", "as-printed"]


class Coefficients(NamedTuple):
    """Restitution e, equivalent friction mu and impact moment coefficient e_m."""

    e: Scalar
    mu: Scalar
    e_m: Scalar


class Undone(NamedTuple):
    """Numerators and denominators of the inverse; all but `closing` are linear in the velocities after.

    Args:
        approach_b: (v_bx, v_by, omega_b) from eqs 19, 20, 21, m/s and rad/s.
        P: force impulse on A, along the normal and the tangent, N s.
        opening, closing: normal contact velocity after and before (eq 22), m/s.
        spin: relative spin after the impact, Omega_b - Omega_a, rad/s.
        free_spin: relative spin after the force impulse alone (eq 24), rad/s.
        sliding: sliding velocity of A along B at the impact centre after the impact, m/s.
        free_sliding: sliding velocity without the friction impulse, m/s.
    """

    approach_b: Float[Array, "3"]
    P: tuple[Scalar, Scalar]
    opening: Scalar
    closing: Scalar
    spin: Scalar
    free_spin: Scalar
    sliding: Scalar
    free_sliding: Scalar


class Capped(NamedTuple):
    """Coefficients limited so that sliding is not reversed.

    Args:
        coefficients: e, mu as held, e_m.
        critical: mu at which sliding just ends, mu_c.
        ratio: r = mu / mu_c as held, from 0 to 1; NaN where there is no sliding or no impulse.
        cut: whether mu had to be changed.
    """

    coefficients: Coefficients
    critical: Scalar
    ratio: Scalar
    cut: Bool[Array, ""]


def printed_e_m(e_m: Scalar) -> Scalar:
    """The e_m with which the corrected eq 24 moves bodies as the printed one does with the given e_m.

    Args:
        e_m: impact moment coefficient.

    Returns:
        e_m / (2 e_m - 1), which is its own inverse: 0 and 1 stay, 0.7 becomes 1.75 (the moment
        *feeds* relative spin), -1 becomes 1/3. Infinite at 1/2, where the printed equation no longer
        contains the relative spin after the impact.
    """
    return jnp.divide(e_m, 2 * e_m - 1)


def separation(
    approach: SixNumbers,
    bodies: Bodies,
    coefficients: Coefficients,
    moment_equation: MomentEquation = "corrected",
) -> State:
    """Velocities after the impact (eqs 19-24 solved for them).

    Args:
        approach: velocities before, (v_ax, v_ay, omega_a, v_bx, v_by, omega_b), m/s and rad/s.
        bodies: masses, inertias, lever arms and Gamma.
        coefficients: e, mu and e_m.
        moment_equation: eq 24 "corrected" or "as-printed"; the printed one is singular at
            e_m = 1/2 and gives NaN there.

    Returns:
        Velocities after, same order and units. A mu beyond `critical_mu` reverses the sliding:
        `capped` holds it, `severity` and `solve` flag it.

    Raises:
        ValueError: no such moment equation.
    """
    if _is_printed(moment_equation):
        coefficients = coefficients._replace(e_m=printed_e_m(coefficients.e_m))
    P, M = impulse(approach, bodies, coefficients)
    f_a, f_b = _force_moments(P, bodies)
    m_a, m_b, I_a, I_b = bodies[:4]
    return jnp.asarray(approach) + jnp.stack(
        [
            P[0] / m_a,  # eq 9
            P[1] / m_a,  # eq 10
            (f_a + M) / I_a,  # eq 11
            -P[0] / m_b,  # eq 12
            -P[1] / m_b,  # eq 13
            (f_b - M) / I_b,  # eq 14
        ]
    )


def impulse(
    approach: SixNumbers, bodies: Bodies, coefficients: Coefficients
) -> tuple[Float[Array, "2"], Scalar]:
    """Force impulse P on A (N s) and moment impulse M on A (N m s), in closed form.

    Args:
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        coefficients: e, mu and e_m.

    Returns:
        (P, M): eqs 22-24 with P_t = mu P_n and M = (1 - e_m) I_r [spin by the force alone].
    """
    (e, mu, e_m), (normal, tangent) = coefficients, axes(bodies)
    response = _response(bodies, e_m)
    spin = approach[5] - approach[2]
    # eq 22: u_n + carried + P_n * compliance = -e u_n
    u_n, carried = _without_force(approach, bodies, response)
    P_n = -((1 + e) * u_n + carried) / response.compliance(mu)
    M = response.shed * (spin - P_n * (response.turn_n + mu * response.turn_t))  # eq 24
    line = normal + mu * tangent  # P = P_n * line, eq 23
    return P_n * line, M


def approach_and_coefficients(
    separation: State,
    approach_a: Float[Array, "3"],
    bodies: Bodies,
    moment_equation: MomentEquation = "corrected",
) -> tuple[Float[Array, "3"], Coefficients]:
    """The paper's inverse: B's velocities before impact and the three coefficients.

    Args:
        separation: velocities after, (V_ax, V_ay, Omega_a, V_bx, V_by, Omega_b), m/s and rad/s.
        approach_a: A's velocities before, (v_ax, v_ay, omega_a).
        bodies: masses, inertias, lever arms and Gamma.
        moment_equation: eq 24 "corrected" or "as-printed".

    Returns:
        (v_bx, v_by, omega_b) from eqs 19, 20, 21 and e, mu, e_m from eqs 22, 23, 24. A coefficient
        that the motion does not determine (no closing speed, no normal impulse, no spin by the force
        alone) comes out infinite or NaN; `solve` refuses it by name.

    Raises:
        ValueError: no such moment equation.
    """
    found = undo(separation, approach_a, bodies)
    divisor = found.free_spin
    if _is_printed(moment_equation):
        divisor = 2 * found.spin - divisor
    return found.approach_b, Coefficients(
        e=-found.opening / found.closing,  # eq 22
        mu=found.P[1] / found.P[0],  # eq 23
        e_m=found.spin / divisor,  # eq 24
    )


def undo(separation: State, approach_a: Float[Array, "3"], bodies: Bodies) -> Undone:
    """B's velocities before impact, and the numerators and denominators of e, mu and e_m.

    Args:
        separation: velocities after, as in `approach_and_coefficients`.
        approach_a: A's velocities before.
        bodies: masses, inertias, lever arms and Gamma.
    """
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, Gamma = bodies
    V_ax, V_ay, Omega_a, V_bx, V_by, Omega_b = separation
    v_ax, v_ay, omega_a = approach_a
    P_x, P_y = m_a * (V_ax - v_ax), m_a * (V_ay - v_ay)
    v_bx, v_by = V_bx + P_x / m_b, V_by + P_y / m_b  # eqs 19, 20
    gain = -P_x * (d1 + d3) + P_y * (d2 + d4)
    omega_b = Omega_b + (I_a * (Omega_a - omega_a) + gain) / I_b  # eq 21, corrected
    c, s = jnp.cos(Gamma), jnp.sin(Gamma)

    def normal(v_x: Scalar, v_y: Scalar, w_a: Scalar, w_b: Scalar) -> Scalar:
        """Normal velocity of A relative to B at the impact centre, from that of the centres (eq 22)."""
        return (v_x + d3 * w_a + d1 * w_b) * c + (v_y - d4 * w_a - d2 * w_b) * s

    spin_a, spin_b = (P_x * d3 - P_y * d4) / I_a, (P_x * d1 - P_y * d2) / I_b
    P_t = P_y * c - P_x * s
    sliding = contact_velocity(separation, bodies) @ axes(bodies)[1]
    return Undone(
        approach_b=jnp.stack([v_bx, v_by, omega_b]),
        P=(P_x * c + P_y * s, P_t),
        opening=normal(V_ax - V_bx, V_ay - V_by, Omega_a, Omega_b),
        closing=normal(v_ax - v_bx, v_ay - v_by, omega_a, omega_b),
        spin=Omega_b - Omega_a,
        free_spin=(omega_b + spin_b) - (omega_a + spin_a),
        sliding=sliding,
        free_sliding=sliding - P_t * _response(bodies, 1.0).tt,
    )


def inverse_log_det(
    separation: State, approach_a: Float[Array, "3"], bodies: Bodies
) -> tuple[Float[Array, "3"], Coefficients, Scalar]:
    """The paper's inverse with its Jacobian determinant.

    Args:
        separation: velocities after, as in `approach_and_coefficients`.
        approach_a: A's velocities before.
        bodies: masses, inertias, lever arms and Gamma.

    Returns:
        (v_bx, v_by, omega_b), (e, mu, e_m) and log |det d(both) / d separation|. With C the compliance
        of `impulse`, u_n the closing speed and S the spin by the force alone it is
        m_a² I_a C / (I_r |P_n u_n S|): v_b and omega_b shift with V_b one to one, and at fixed v_b
        and omega_b V_a follows (P_n, mu, M), which follow (e, mu, e_m) by eqs 22-24.
    """
    found = undo(separation, approach_a, bodies)
    e, e_m = -found.opening / found.closing, found.spin / found.free_spin
    coefficients = Coefficients(e, found.P[1] / found.P[0], e_m)
    m_a, _, I_a, I_b = bodies[:4]
    compliance = _response(bodies, e_m).compliance(coefficients.mu)
    volume = m_a**2 * I_a * (1 / I_a + 1 / I_b) * compliance
    volume /= found.P[0] * found.closing * found.free_spin
    return found.approach_b, coefficients, jnp.log(jnp.abs(volume))


def restitution(P: Float[Array, "2"], approach: State, bodies: Bodies, e_m: Scalar) -> Scalar:
    """Coefficient of restitution of a force impulse at fixed e_m (eq 22): the inverse of `impulse`.

    Args:
        P: force impulse on A, along the normal and the tangent, N s.
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        e_m: impact moment coefficient.

    Returns:
        e.
    """
    response, (P_n, P_t) = _response(bodies, e_m), P
    u_n, carried = _without_force(approach, bodies, response)
    return -1 - (P_n * response.nn + P_t * response.nt + carried) / u_n


def friction_impulse(
    kept: Scalar, P_n: Scalar, approach: State, bodies: Bodies, e_m: Scalar
) -> Scalar:
    """The force impulse along the tangent that leaves a share of the sliding.

    Args:
        kept: share of the sliding that is left: sliding after the impact over that without friction.
        P_n: force impulse on A along the normal, N s.
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        e_m: impact moment coefficient.

    Returns:
        The tangential force impulse on A, N s.
    """
    response = _response(bodies, e_m)
    drift = _drift(approach, bodies, response)
    return -(drift + P_n * response.nt) * (1 - kept) / response.tt


def normal_impulse(e: Scalar, kept: Scalar, approach: State, bodies: Bodies, e_m: Scalar) -> Scalar:
    """The force impulse along the normal for which the restitution is e.

    Args:
        e: restitution.
        kept: share of the sliding that is left, as in `friction_impulse`.
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        e_m: impact moment coefficient.

    Returns:
        The normal force impulse on A, N s: eq 22 solved for it.
    """
    response = _response(bodies, e_m)
    u_n, carried = _without_force(approach, bodies, response)
    by_friction = response.nt * (1 - kept) / response.tt
    push = by_friction * _drift(approach, bodies, response) - (1 + e) * u_n - carried
    return push / (response.nn - by_friction * response.nt)


def critical_mu(approach: SixNumbers, bodies: Bodies, e: Scalar, e_m: Scalar) -> Scalar:
    """The mu at which sliding along the contact line just ends (the caution at eq 23).

    Args:
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        e: restitution.
        e_m: impact moment coefficient.

    Returns:
        mu with no tangential velocity left at the impact centre; its sign is that of the sliding.
        Beyond it the model would reverse the sliding, so r = mu / mu_c from 0 to 1 is the friction's
        natural parameter. Infinite where friction cannot end the sliding however large, because it
        unloads the contact faster than it brakes (grazing impacts); NaN without a normal impulse.
    """
    response = _response(bodies, e_m)
    before = contact_velocity(approach, bodies)
    u_n, u_t = (before @ axis for axis in axes(bodies))
    carried = response.shed * (approach[5] - approach[2])
    push = -(1 + e) * u_n - carried * response.turn_n  # eq 22: P_n * compliance
    drift = u_t + carried * response.turn_t
    # no sliding left: drift + P_n (nt + mu tt) = 0, linear in mu
    root = -(drift * response.nn + push * response.nt) / (drift * response.nt + push * response.tt)
    root = jnp.where(push == 0, jnp.nan, root)
    # the braking root has gone through infinity where only friction that drives the sliding is left,
    # though without friction it would go on
    goes_on = u_t * (drift + push * response.nt / response.nn) > 0
    braking = u_t * u_n  # has the sign of such a mu
    return jnp.where(goes_on & (root * braking < 0), jnp.copysign(jnp.inf, braking), root)


def capped(
    approach: SixNumbers,
    bodies: Bodies,
    e: Scalar,
    mu: Scalar | Literal["critical"],
    e_m: Scalar,
) -> Capped:
    """The coefficients with mu held between 0 and its critical value, so that no sliding reverses.

    Args:
        approach: velocities before, as in `separation`.
        bodies: masses, inertias, lever arms and Gamma.
        e: restitution.
        mu: equivalent friction; "critical" means that sliding just ends within the contact. For a
            share r of the critical value, pass `r * critical_mu(...)`.
        e_m: impact moment coefficient.

    Returns:
        Coefficients for `separation`, the critical mu, their ratio r = mu / mu_c after the cut, and
        whether mu was cut: it exceeded the critical value, or had the sign that drives the sliding
        (it then becomes 0).

    Raises:
        ValueError: mu is another word than "critical".
    """
    critical = critical_mu(approach, bodies, e, e_m)
    if isinstance(mu, str):
        if mu != "critical":
            raise ValueError(f'mu is a number or "critical", not {mu!r}')
        mu = critical
    # without a normal impulse there is no friction either, whatever mu: nothing to cut
    limit = jnp.where(jnp.isnan(critical), mu, critical)
    held = jnp.clip(mu, jnp.minimum(limit, 0), jnp.maximum(limit, 0))
    return Capped(Coefficients(e, held, e_m), critical, held / limit, held != mu)


class _Response(NamedTuple):
    """Change of the contact velocity by an impulse, along the normal n and the tangent t.

    Args:
        nn, nt, tt: change along the first per force impulse along the second, its moment included.
        turn_n, turn_t: change by a moment impulse.
        shed: moment impulse over the spin by the force alone, (1 - e_m) I_r (eq 24).
    """

    nn: Scalar
    nt: Scalar
    tt: Scalar
    turn_n: Scalar
    turn_t: Scalar
    shed: Scalar

    def compliance(self, mu: Scalar) -> Scalar:
        """Change of the normal contact velocity per normal impulse, with its friction."""
        return self.nn + mu * self.nt


def _response(bodies: Bodies, e_m: Scalar) -> _Response:
    m_a, m_b, I_a, I_b = bodies[:4]
    n, t = (_force_moments(axis, bodies) for axis in axes(bodies))
    turn_n, turn_t = n[0] / I_a - n[1] / I_b, t[0] / I_a - t[1] / I_b
    shed = (1 - e_m) / (1 / I_a + 1 / I_b)
    straight = 1 / m_a + 1 / m_b
    return _Response(
        nn=straight + n[0] ** 2 / I_a + n[1] ** 2 / I_b - shed * turn_n**2,
        nt=n[0] * t[0] / I_a + n[1] * t[1] / I_b - shed * turn_n * turn_t,
        tt=straight + t[0] ** 2 / I_a + t[1] ** 2 / I_b - shed * turn_t**2,
        turn_n=turn_n,
        turn_t=turn_t,
        shed=shed,
    )


def _is_printed(moment_equation: MomentEquation) -> bool:
    if moment_equation not in get_args(MomentEquation):
        raise ValueError(f"moment_equation is one of {get_args(MomentEquation)}")
    return moment_equation == "as-printed"


def _without_force(
    approach: SixNumbers, bodies: Bodies, response: _Response
) -> tuple[Scalar, Scalar]:
    """Normal contact velocity before the impact, and its change by the moment impulse alone."""
    u_n = contact_velocity(approach, bodies) @ axes(bodies)[0]
    return u_n, response.shed * (approach[5] - approach[2]) * response.turn_n


def _drift(approach: State, bodies: Bodies, response: _Response) -> Scalar:
    """Sliding velocity without a force impulse: before the impact, plus the moment's share."""
    spin = response.shed * (approach[5] - approach[2]) * response.turn_t
    return contact_velocity(approach, bodies) @ axes(bodies)[1] + spin


def _force_moments(P: Float[Array, "2"], bodies: Bodies) -> tuple[Scalar, Scalar]:
    """f_a = P_x d3 - P_y d4 and f_b = P_x d1 - P_y d2: moments of P about A's and B's centres."""
    _, _, _, _, d1, d2, d3, d4, _ = bodies
    return P[0] * d3 - P[1] * d4, P[0] * d1 - P[1] * d2
