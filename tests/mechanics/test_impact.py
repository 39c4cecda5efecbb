"""The impact equations against the paper, published worked examples, and the laws they must keep."""

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
    contact_velocity,
    critical_mu,
    impulse,
    inverse_log_det,
    lever_arms,
    separation,
)

FOOT, MPH, DEGREE = 0.3048, 0.44704, math.pi / 180

# compiled once for all examples
_separation = jax.jit(separation)
_impulse = jax.jit(impulse)
_inverse = jax.jit(approach_and_coefficients)
_audit = jax.jit(audit)
_critical_mu = jax.jit(critical_mu)


def brach_1977() -> Bodies:
    """Recovered masses, inertias, arms and Gamma of SAE 770014's example."""
    return Bodies(1857.0, 1778.0, 3374.0, 3007.0, 1.636, 0.653, 0.205, 2.079, -0.155)


def test_table_3_leads_to_table_4() -> None:
    """SAE 770014, Tables 3 and 4: B's velocity, e, mu and e_m within their US rounding."""
    velocities_after = jnp.array([-7.0, 2.4, 0.61, 5.2, -6.1, 9.9])
    approach_b, c = approach_and_coefficients(
        velocities_after, jnp.array([-20.1, 0.0, 0.0]), brach_1977()
    )
    assert float(approach_b[0]) / FOOT == pytest.approx(62, abs=0.5)
    assert float(approach_b[1]) / FOOT == pytest.approx(-12, abs=0.5)
    assert float(approach_b[2]) / DEGREE == pytest.approx(-15, abs=2.5)  # printed to 5 deg/s
    assert float(jnp.hypot(*approach_b[:2])) / FOOT == pytest.approx(63.2, abs=0.5)
    assert float(c.e) == pytest.approx(0.10, abs=0.005)
    assert float(c.mu) == pytest.approx(0.35, abs=0.005)
    assert float(c.e_m) == pytest.approx(0.70, abs=0.005)


# SAE 2014-01-0469, Table 5 and Fig. 14 (lb, ft, s, deg). Its inputs are printed rounded, its outputs
# to more digits than they determine: so each input stands here as (printed, digits, a value that
# rounds to it), the last fitted jointly to all outputs.
SPREADSHEET_IN = {
    "m_1": (176.7, 1, 176.70029835264054),
    "m_2": (117.49, 2, 117.49497154493129),
    "I_1": (4327.15, 2, 4327.149967837477),
    "I_2": (2426.8, 1, 2426.799769248237),
    "arm_1": (6.8, 1, 6.750614725103365),
    "arm_2": (6.0, 1, 6.034356080124817),
    "phi_1": (25.61, 2, 25.61373743026946),
    "phi_2": (22.73, 2, 22.73053394803031),
    "theta_2": (2.04, 2, 2.040595167279492),
    "Gamma": (82.348, 3, 82.34849879253942),
    "e": (0.158, 3, 0.15766057505568487),
    "mu": (-1.562, 3, -1.56222396633775),
    "v_1x": (-59.79, 2, -59.79234157318886),
    "v_2x": (99.67, 2, 99.66842396234075),
    "v_2y": (3.55, 2, 3.552687554440599),
}
SPREADSHEET_OUT = {
    "V_1x": (-40.41, 2),
    "V_1y": (9.03, 2),
    "V_2x": (70.52, 2),
    "V_2y": (-10.02, 2),
    "Omega_1": (3.78, 2),
    "Omega_2": (-1.89, 2),
    "dV_1": (21.4, 1),
    "dV_2": (32.2, 1),
    "energy before": (900189.7, 1),
    "energy after": (449569.3, 1),
    "loss": (450620.4, 1),
    "normal": (21232.2, 1),
    "tangential": (429388.2, 1),
    "P_x": (3424.5, 1),
    "P_y": (1594.9, 1),
    "P": (3777.7, 1),
    "P_n": (2036.6, 1),
    "P_t": (-3181.7, 1),
    "critical mu": (-2.207, 3),
}


def test_worked_spreadsheet_of_sae_2014_01_0469_to_every_printed_digit() -> None:
    """Brach et al., SAE 2014-01-0469, Fig. 14: nineteen outputs from inputs within their rounding."""
    for name, (printed, digits, used) in SPREADSHEET_IN.items():
        assert round(used, digits) == printed, name
    x = {name: used for name, (_, _, used) in SPREADSHEET_IN.items()}
    at_1, at_2 = x["phi_1"] * DEGREE, (x["theta_2"] + x["phi_2"]) * DEGREE
    bodies = Bodies(
        x["m_1"],
        x["m_2"],
        x["I_1"],
        x["I_2"],
        x["arm_2"] * math.sin(at_2),
        x["arm_2"] * math.cos(at_2),
        x["arm_1"] * math.sin(at_1),
        x["arm_1"] * math.cos(at_1),
        x["Gamma"] * DEGREE,
    )
    before = jnp.array([x["v_1x"], 0.0, 0.0, x["v_2x"], x["v_2y"], 0.0])
    c = Coefficients(x["e"], x["mu"], 1.0)
    after = np.array(separation(before, bodies, c))
    P, M = impulse(before, bodies, c)
    energy = audit(before, bodies, c)
    G = x["Gamma"] * DEGREE
    found = {
        "V_1x": after[0],
        "V_1y": after[1],
        "V_2x": after[3],
        "V_2y": after[4],
        "Omega_1": after[2] / DEGREE,
        "Omega_2": after[5] / DEGREE,
        "dV_1": math.hypot(*(after - before)[:2]),
        "dV_2": math.hypot(*(after - before)[3:5]),
        "energy before": energy.before,
        "energy after": energy.after,
        "loss": energy.before - energy.after,
        "normal": -energy.normal,
        "tangential": -energy.tangential,
        "P_x": P[0],
        "P_y": P[1],
        "P": math.hypot(*P),
        "P_n": P[0] * math.cos(G) + P[1] * math.sin(G),
        "P_t": -P[0] * math.sin(G) + P[1] * math.cos(G),
        "critical mu": critical_mu(before, bodies, x["e"], 1.0),
    }
    assert abs(float(M)) < 1e-9  # e_m = 1: no moment
    for name, (printed, digits) in SPREADSHEET_OUT.items():
        assert round(float(found[name]), digits) == printed, (name, float(found[name]))


# Rose, Fenton & Beauchamp, SAE 2006-01-0908 (NHTSA tests 4363 and 4364): r ft, theta deg, heading
# deg, speed mph, weight lb, inertia slug ft²; normal deg; e; delta-v mph; change of yaw rate deg/s
ROSE = {
    "4363": (
        (2.6, 23.8, 180, 35.1, 3451.1, 2152),
        (5.7, 10.6, 32, 35.0, 4695.4, 2805),
        (55.0, 0.126, 0.51, (39.5, 29.1), (31, 182)),
    ),
    "4364": (
        (2.3, 45.7, 180, 35.0, 3451.1, 2152),
        (7.1, 11.2, 30, 34.9, 5192.5, 3563),
        (51.9, 0.089, 0.42, (40.1, 26.6), (108, 148)),
    ),
}


@pytest.mark.parametrize("test", ROSE)
def test_planar_impact_of_rose_2006(test: str) -> None:
    """SAE 2006-01-0908, Figs. 13 and 14: common velocity along the contact line, no moment."""
    *vehicles, (normal, e, mu_printed, delta_v, delta_omega) = ROSE[test]
    levers, velocities = [], []
    for r, theta, heading, speed, _, _ in vehicles:
        psi = -heading * DEGREE  # headings are clockwise there
        along = np.array([math.cos(psi), math.sin(psi)])
        across = np.array([-along[1], along[0]])
        levers.append(r * (math.cos(-theta * DEGREE) * along + math.sin(-theta * DEGREE) * across))
        velocities.append(speed * MPH / FOOT * along)
    psi_1 = -vehicles[0][2] * DEGREE
    bodies = Bodies(
        vehicles[0][4] / 32.2,
        vehicles[1][4] / 32.2,
        vehicles[0][5],
        vehicles[1][5],
        *lever_arms(jnp.array(levers[0]), jnp.array(levers[1])),
        psi_1 - normal * DEGREE,
    )
    before = jnp.array([*velocities[0], 0.0, *velocities[1], 0.0])
    mu = critical_mu(before, bodies, e, 1.0)
    change = np.array(separation(before, bodies, Coefficients(e, mu, 1.0)) - before)
    assert abs(float(mu)) == pytest.approx(mu_printed, abs=0.01)
    for i in (0, 1):
        assert math.hypot(*change[3 * i : 3 * i + 2]) * FOOT / MPH == pytest.approx(
            delta_v[i], abs=0.2
        )
        # lengths are printed to 0.1 ft: their rounding moves the yaw rates by up to 1.3 deg/s
        off = abs(abs(change[3 * i + 2]) / DEGREE - delta_omega[i])
        assert round(off, 1) <= 1.3, off


def test_moment_makes_interlocked_bodies_turn_together() -> None:
    """SAE 770014, eqs 1-8: two like bodies, spinning against one another, hit along y with e = 0.

    Without the moment (e_m = 1) they would turn through one another; with e_m = 0 all motion ends.
    """
    # A above B on the y axis, contact line along x: Gamma = 90 deg
    bodies = Bodies(1.0, 1.0, 2.0, 2.0, 1.0, 0.0, 1.0, 0.0, math.pi / 2)
    before = jnp.array([0.0, -3.0, 0.5, 0.0, 3.0, -0.5])
    free = np.array(separation(before, bodies, Coefficients(0.0, 0.0, 1.0)))
    np.testing.assert_allclose(free, [0, 0, 0.5, 0, 0, -0.5], atol=1e-12)
    locked = np.array(separation(before, bodies, Coefficients(0.0, 0.0, 0.0)))
    np.testing.assert_allclose(locked, np.zeros(6), atol=1e-12)
    elastic = np.array(separation(before, bodies, Coefficients(0.0, 0.0, -1.0)))
    np.testing.assert_allclose(elastic, [0, 0, -0.5, 0, 0, 0.5], atol=1e-12)


# -- laws ------------------------------------------------------------------------------------

mass = st.floats(500, 40_000)
gyration = st.floats(0.5, 2.5)  # yaw inertia over mass, square root
arm = st.floats(-3, 3)
angle = st.floats(-math.pi, math.pi)
speed = st.floats(-40, 40)
spin = st.floats(-6, 6)


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


@given(any_bodies(), any_approach(), share, st.floats(-1, 1), share)
def test_momentum_and_angular_momentum_are_kept(
    bodies: Bodies, before: np.ndarray, e: float, mu: float, e_m: float
) -> None:
    after = np.array(_separation(before, bodies, Coefficients(e, mu, e_m)))
    assume(np.abs(after).max() < 1e4)  # near-singular: mu with a vanishing compliance
    for state in (before, after):
        assert np.isfinite(state).all()
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, _ = (float(v) for v in bodies)
    p = np.array([m_a * s[:2] + m_b * s[3:5] for s in (before, after)])
    scale = (m_a + m_b) * max(1, np.abs(after).max(), np.abs(before).max())
    np.testing.assert_allclose(p[0], p[1], atol=1e-10 * scale)
    # about a point other than the impact centre, with A at -(lever of A) and B at -(lever of B)
    point = np.array([0.7, -1.3])
    at_a, at_b = np.array([d4, d3]) - point, np.array([-d2, -d1]) - point
    L = [
        m_a * (at_a[0] * s[1] - at_a[1] * s[0])
        + m_b * (at_b[0] * s[4] - at_b[1] * s[3])
        + I_a * s[2]
        + I_b * s[5]
        for s in (before, after)
    ]
    assert L[0] == pytest.approx(L[1], abs=1e-9 * scale * 10)


@given(any_bodies(), any_approach(), share, share, share)
def test_forward_and_inverse_undo_each_other(
    bodies: Bodies, before: np.ndarray, e: float, r: float, e_m: float
) -> None:
    mu_c = float(_critical_mu(before, bodies, e, e_m))
    assume(math.isfinite(mu_c) and abs(mu_c) < 20)
    c = Coefficients(e, r * mu_c, e_m)
    after = np.array(_separation(before, bodies, c))
    # what the inverse divides by must not vanish: the closing speed, the impulse, the free spin
    G = float(bodies.Gamma)
    normal = np.array([math.cos(G), math.sin(G)])
    P, _ = _impulse(before, bodies, c)
    closing = float(np.array(contact_velocity(jnp.array(before), bodies)) @ normal)
    free = np.array(_separation(before, bodies, Coefficients(e, r * mu_c, 1.0)))
    assume(abs(closing) > 0.5 and abs(float(np.array(P) @ normal)) > 100)
    assume(np.abs(after).max() < 500)
    _, _, I_a, I_b, d1, d2, d3, d4, _ = (float(v) for v in bodies)
    f_a, f_b = float(P[0]) * d3 - float(P[1]) * d4, float(P[0]) * d1 - float(P[1]) * d2
    free_spin = (before[5] + f_b / I_b) - (before[2] + f_a / I_a)
    assume(abs(free_spin) > 0.05)
    assert free.shape == (6,)
    approach_b, found = _inverse(after, before[:3], bodies)
    scale = np.abs(np.concatenate([before, after])).max()
    np.testing.assert_allclose(np.array(approach_b), before[3:], atol=1e-10 * scale)
    # the coefficients' rounding grows with what was divided by
    np.testing.assert_allclose(float(found.e), e, atol=1e-10 * scale / abs(closing))
    np.testing.assert_allclose(float(found.mu), r * mu_c, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(float(found.e_m), e_m, atol=1e-10 * scale / abs(free_spin))
    again = np.array(_separation(np.concatenate([before[:3], approach_b]), bodies, found))
    np.testing.assert_allclose(again, after, atol=1e-9 * scale)


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


@given(any_bodies(), any_approach(), share, st.floats(-1, 1), st.floats(-1, 1))
def test_energy_audit_is_exact(
    bodies: Bodies, before: np.ndarray, e: float, mu: float, e_m: float
) -> None:
    energy = _audit(before, bodies, Coefficients(e, mu, e_m))
    work = float(energy.normal + energy.tangential + energy.moment)
    change = float(energy.after - energy.before)
    assume(float(energy.after) < 1e12)
    scale = float(energy.before + energy.after) + abs(float(energy.normal))
    scale += abs(float(energy.tangential)) + abs(float(energy.moment))
    assert work == pytest.approx(change, abs=1e-9 * scale + 1e-6)


def test_spin_before_the_impact_can_feed_energy_through_the_moment_and_the_audit_shows_it() -> None:
    """With approach spin the moment's work can be positive, and the audit names it."""
    bodies = brach_1977()
    before = jnp.array([-20.1, 0.0, 5.0, 18.9, -3.6, -5.0])
    energy = audit(before, bodies, Coefficients(0.1, 0.3, 0.0))
    assert float(energy.moment) > 0


@given(any_bodies(), any_approach(), share, share, share)
def test_swapping_the_vehicles_changes_nothing(
    bodies: Bodies, before: np.ndarray, e: float, mu: float, e_m: float
) -> None:
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, G = bodies
    swapped = Bodies(m_b, m_a, I_b, I_a, -d3, -d4, -d1, -d2, G)
    c = Coefficients(e, mu, e_m)
    after = np.array(_separation(before, bodies, c))
    assume(np.abs(after).max() < 1e4)
    other = np.array(_separation(np.roll(before, 3), swapped, c))
    np.testing.assert_allclose(np.roll(other, 3), after, atol=1e-9 * max(1, np.abs(after).max()))


def test_jacobian_of_the_inverse_in_closed_form_is_that_of_automatic_differentiation() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        V, v_a = jnp.array(rng.normal(size=6) * 5), jnp.array(rng.normal(size=3) * 10)
        bodies = brach_1977()._replace(Gamma=rng.uniform(-3, 3), d1=rng.normal(), d4=rng.normal())

        def unknowns(V: jax.Array, v_a: jax.Array = v_a, bodies: Bodies = bodies) -> jax.Array:
            approach_b, c = approach_and_coefficients(V, v_a, bodies)
            return jnp.concatenate([approach_b, jnp.stack(c)])

        expected = np.linalg.slogdet(np.array(jax.jacfwd(unknowns)(V)))[1]
        assert float(inverse_log_det(V, v_a, bodies)[2]) == pytest.approx(expected, rel=1e-9)


def test_corrected_eq_21_differs_from_the_printed_one() -> None:
    """The printed last term, m_a (d2+d4)(V_ax - v_ax), would not keep angular momentum."""
    V, v_a = np.array([-7.0, 2.4, 0.61, 5.2, -6.1, 9.9]), np.array([-20.1, 0.0, 0.0])
    b = brach_1977()
    omega_b = float(approach_and_coefficients(jnp.array(V), jnp.array(v_a), b)[0][2])
    gain = b.I_a * (V[2] - v_a[2]) - b.m_a * (b.d1 + b.d3) * (V[0] - v_a[0])
    corrected = V[5] + (gain + b.m_a * (b.d2 + b.d4) * (V[1] - v_a[1])) / b.I_b
    printed = V[5] + (gain + b.m_a * (b.d2 + b.d4) * (V[0] - v_a[0])) / b.I_b
    assert omega_b == pytest.approx(corrected, rel=1e-12)
    assert abs(printed - corrected) > 10  # rad/s
