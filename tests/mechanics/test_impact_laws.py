"""The laws that every impact keeps, on many drawn impacts each."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from retrodict.mechanics import (
    Bodies,
    Coefficients,
    approach_and_coefficients,
    audit,
    closing_speed,
    contact_velocity,
    critical_mu,
    impulse,
    lever_arms,
    separation,
)

EPS = np.finfo(float).eps

# compiled once for all examples
_separation = jax.jit(separation)
_impulse = jax.jit(impulse)
_inverse = jax.jit(approach_and_coefficients)
_audit = jax.jit(audit)
_critical_mu = jax.jit(critical_mu)
_closing_speed = jax.jit(closing_speed)

mass = st.floats(500, 40_000)
gyration = st.floats(0.5, 2.5)  # yaw inertia over mass, square root
arm = st.floats(-3, 3)
angle = st.floats(-math.pi, math.pi)

# a motion so slight is none: the square of less than 1e-154 has no digits left in double precision
speed = st.floats(-40, 40).map(lambda v: v if abs(v) > 1e-100 else 0.0)
spin = st.floats(-6, 6).map(lambda w: w if abs(w) > 1e-100 else 0.0)


@st.composite
def any_bodies(draw: st.DrawFn) -> Bodies:
    m_a, m_b = draw(mass), draw(mass)
    I_a, I_b = m_a * draw(gyration) ** 2, m_b * draw(gyration) ** 2
    return Bodies(m_a, m_b, I_a, I_b, *(draw(arm) for _ in range(4)), draw(angle))


@st.composite
def any_approach(draw: st.DrawFn, spinning: bool = True) -> np.ndarray:
    w_a, w_b = (draw(spin), draw(spin)) if spinning else (0.0, 0.0)
    return np.array([draw(speed), draw(speed), w_a, draw(speed), draw(speed), w_b])


share = st.floats(0, 1)
signed = st.floats(-1, 1)


def cancellation(bodies: Bodies, mu: float, e_m: float) -> float:
    """The condition number of the normal impulse: it is divided by a sum whose terms may cancel."""
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, G = (float(v) for v in bodies)
    n = np.array([math.cos(G), math.sin(G)])
    line = n + mu * np.array([-n[1], n[0]])
    h_a, h_b = n[0] * d3 - n[1] * d4, n[0] * d1 - n[1] * d2
    g_a, g_b = line[0] * d3 - line[1] * d4, line[0] * d1 - line[1] * d2
    I_r = 1 / (1 / I_a + 1 / I_b)
    moment = (1 - e_m) * I_r * np.outer([g_b / I_b, -g_a / I_a], [h_a / I_a, -h_b / I_b])
    terms = [1 / m_a, 1 / m_b, h_a * g_a / I_a, h_b * g_b / I_b, *moment.ravel()]
    return float(np.abs(terms).sum() / abs(sum(terms)))


@given(any_bodies(), any_approach(), share, signed, signed, st.tuples(*[st.floats(-50, 50)] * 2))
def test_momentum_and_angular_momentum_about_any_point_are_kept(
    bodies: Bodies, before: np.ndarray, e: float, mu: float, e_m: float, point: tuple
) -> None:
    after = np.array(_separation(before, bodies, Coefficients(e, mu, e_m)))
    assert np.isfinite(after).all()
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, _ = (float(v) for v in bodies)
    # the impact centre is the origin: A lies at minus its lever (-d4, -d3), B at minus (d2, d1)
    (ax, ay), (bx, by) = np.array([d4, d3]) - point, np.array([-d2, -d1]) - point
    terms = np.array(
        [
            [m_a, 0, 0, m_b, 0, 0],
            [0, m_a, 0, 0, m_b, 0],
            [-m_a * ay, m_a * ax, I_a, -m_b * by, m_b * bx, I_b],
        ]
    )
    # below the smallest normal number XLA rounds to zero
    rounding = np.abs(terms) @ (1e-12 * (np.abs(before) + np.abs(after)) + np.finfo(float).tiny)
    assert (np.abs(terms @ after - terms @ before) <= rounding).all()


@given(any_bodies(), any_approach(), share, signed, signed)
def test_swapping_the_vehicles_changes_nothing(
    bodies: Bodies, before: np.ndarray, e: float, mu: float, e_m: float
) -> None:
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, G = bodies
    swapped = Bodies(m_b, m_a, I_b, I_a, -d3, -d4, -d1, -d2, G)
    c = Coefficients(e, mu, e_m)
    after = np.array(_separation(before, bodies, c))
    other = np.roll(np.array(_separation(np.roll(before, 3), swapped, c)), 3)
    agree(other, after, before, cancellation(bodies, mu, e_m))


@given(any_bodies(), any_approach(), share, signed, signed, angle)
def test_rotating_the_scene_rotates_the_outcome(
    bodies: Bodies, before: np.ndarray, e: float, mu: float, e_m: float, turn: float
) -> None:
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    moved = transformed(bodies, rotation, bodies.Gamma + turn)
    c = Coefficients(e, mu, e_m)
    expected = seen(np.array(_separation(before, bodies, c)), rotation)
    found = np.array(_separation(seen(before, rotation), moved, c))
    agree(found, expected, before, cancellation(bodies, mu, e_m))


@given(any_bodies(), any_approach(), share, signed, signed)
def test_mirroring_the_scene_mirrors_the_outcome(
    bodies: Bodies, before: np.ndarray, e: float, mu: float, e_m: float
) -> None:
    """Angles, spins and the tangent, and with it mu, change sign."""
    mirror = np.diag([1.0, -1.0])
    moved = transformed(bodies, mirror, -bodies.Gamma)
    expected = seen(np.array(_separation(before, bodies, Coefficients(e, mu, e_m))), mirror)
    found = np.array(_separation(seen(before, mirror), moved, Coefficients(e, -mu, e_m)))
    agree(found, expected, before, cancellation(bodies, mu, e_m))


@given(any_approach(), angle, *[st.floats(0.01, 3)] * 2, *[arm] * 2, st.sampled_from([0, math.pi]))
def test_vehicles_that_close_in_come_nearer_along_the_normal(
    before: np.ndarray, Gamma: float, a: float, b: float, aside: float, other: float, turned: float
) -> None:
    """Whichever way the normal points, if seen along it the contact lies between the centres."""
    normal, tangent = (np.array([math.cos(g), math.sin(g)]) for g in (Gamma, Gamma + math.pi / 2))
    lever_a, lever_b = a * normal + aside * tangent, -b * normal + other * tangent
    (ax, ay, w_a), (bx, by, w_b) = np.reshape(before, (2, 3))
    of_a = np.array([ax, ay]) + w_a * np.array([-lever_a[1], lever_a[0]])
    of_b = np.array([bx, by]) + w_b * np.array([-lever_b[1], lever_b[0]])
    widening = float((of_b - of_a) @ normal)
    bodies = Bodies(1000.0, 1000.0, 2000.0, 2000.0, *lever_arms(lever_a, lever_b), Gamma + turned)
    found = _closing_speed(before, bodies)
    assert float(found) == pytest.approx(-widening, rel=1e-9, abs=1e-9)


def transformed(bodies: Bodies, matrix: np.ndarray, Gamma: float) -> Bodies:
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, _ = bodies
    levers = lever_arms(matrix @ [-d4, -d3], matrix @ [d2, d1])
    return Bodies(m_a, m_b, I_a, I_b, *(float(d) for d in levers), Gamma)


def seen(state: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    spin = np.linalg.det(matrix)
    return np.concatenate(
        [matrix @ state[:2], [spin * state[2]], matrix @ state[3:5], [spin * state[5]]]
    )


def agree(found: np.ndarray, expected: np.ndarray, before: np.ndarray, condition: float) -> None:
    """Equal to rounding, as far as the normal impulse's condition number lets it through."""
    scale = max(np.abs(before).max(), np.abs(expected).max())
    np.testing.assert_allclose(found, expected, rtol=0, atol=64 * EPS * condition * scale)


@given(any_bodies(), any_approach(), share, share, signed)
def test_forward_and_inverse_undo_each_other(
    bodies: Bodies, before: np.ndarray, e: float, r: float, e_m: float
) -> None:
    """To 1e-10 of the largest velocity; a coefficient, a quotient, to 1e-10 of that over its divisor."""
    mu_c = float(_critical_mu(before, bodies, e, e_m))
    assume(math.isfinite(mu_c) and abs(mu_c) < 20)
    mu = r * mu_c
    c = Coefficients(e, mu, e_m)
    after = np.array(_separation(before, bodies, c))
    m_a, _, I_a, I_b, d1, d2, d3, d4, G = (float(v) for v in bodies)
    P = np.array(_impulse(before, bodies, c)[0])
    normal = np.array([math.cos(G), math.sin(G)])
    # what the inverse divides by must not vanish: the closing speed, the impulse, the free spin
    closing = abs(np.array(contact_velocity(jnp.array(before), bodies)) @ normal)
    gain = abs(P @ normal) / m_a
    f_a, f_b = P[0] * d3 - P[1] * d4, P[0] * d1 - P[1] * d2
    free_spin = abs((before[5] + f_b / I_b) - (before[2] + f_a / I_a))
    scale = max(np.abs(before).max(), np.abs(after).max())
    assume(closing > 0.5 and gain > 0.01 and free_spin > 0.05 and scale < 500)
    approach_b, found = _inverse(after, before[:3], bodies)
    np.testing.assert_allclose(np.array(approach_b), before[3:], rtol=0, atol=1e-10 * scale)
    assert float(found.e) == pytest.approx(e, abs=1e-10 * scale / closing)
    assert float(found.mu) == pytest.approx(mu, abs=1e-10 * (1 + abs(mu)) * scale / gain)
    assert float(found.e_m) == pytest.approx(e_m, abs=1e-10 * scale / free_spin)
    again = np.array(_separation(np.concatenate([before[:3], approach_b]), bodies, found))
    np.testing.assert_allclose(again, after, rtol=0, atol=1e-10 * scale)


@given(any_bodies(), any_approach(), share, signed, signed)
def test_energy_audit_is_exact(
    bodies: Bodies, before: np.ndarray, e: float, mu: float, e_m: float
) -> None:
    """To 1e-12 of the energies and works that it adds up."""
    energy = _audit(before, bodies, Coefficients(e, mu, e_m))
    scale = sum(abs(float(term)) for term in energy)
    work = float(energy.normal + energy.tangential + energy.moment)
    assert abs(work - float(energy.after - energy.before)) <= 1e-12 * scale


@given(any_bodies(), any_approach(spinning=False), share, share, share)
def test_kinetic_energy_never_rises(
    bodies: Bodies, before: np.ndarray, e: float, r: float, e_m: float
) -> None:
    """For e, e_m in [0, 1], mu from 0 to its critical value, and no spin before the impact."""
    mu_c = float(_critical_mu(before, bodies, e, e_m))
    assume(math.isfinite(mu_c) and abs(mu_c) < 1e3)
    c = Coefficients(e, r * mu_c, e_m)
    P, _ = _impulse(before, bodies, c)
    G = float(bodies.Gamma)
    # the vehicles approach, so that the impulse pushes them apart; friction opposes the sliding
    closing = np.array(contact_velocity(jnp.array(before), bodies))
    n, t = np.array([math.cos(G), math.sin(G)]), np.array([-math.sin(G), math.cos(G)])
    assume((np.array(P) @ n) * (closing @ n) < 0)
    assume(r * mu_c * (np.array(P) @ n) * (closing @ t) <= 0)
    energy = _audit(before, bodies, c)
    assert float(energy.after) <= float(energy.before) * (1 + 1e-9)
