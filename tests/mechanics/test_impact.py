"""The impact equations against the paper, published worked examples, and the laws they must keep."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import (
    Bodies,
    Coefficients,
    approach_and_coefficients,
    audit,
    capped,
    contact_velocity,
    critical_mu,
    impulse,
    inverse_log_det,
    lever_arms,
    printed_e_m,
    separation,
)

FOOT, MPH, DEGREE = 0.3048, 0.44704, math.pi / 180


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


def eq_24(V: np.ndarray, v: np.ndarray, b: Bodies, e_m: float, printed: bool) -> tuple:
    """Both sides of SAE 770014's eq 24 with its impulses, as the paper writes it or corrected."""
    P_x, P_y = b.m_a * (V[0] - v[0]), b.m_a * (V[1] - v[1])
    bracket = (V[2] - v[2]) - (P_x * b.d3 - P_y * b.d4) / b.I_a
    bracket += -(V[5] - v[5]) + (P_x * b.d1 - P_y * b.d2) / b.I_b
    return (V[5] - V[2]) * (1 - e_m), -e_m * (bracket if printed else -bracket)


@pytest.mark.parametrize("printed", [False, True])
def test_eq_24_holds_as_corrected_and_as_printed(printed: bool) -> None:
    v = np.array([-20.1, 0.4, 0.3, 18.9, -3.6, -0.8])
    name = "as-printed" if printed else "corrected"
    for e_m in (-1.0, -0.3, 0.0, 0.2, 0.7, 1.0):
        c = Coefficients(0.1, 0.35, e_m)
        V = np.array(separation(jnp.array(v), brach_1977(), c, name))
        left, right = eq_24(V, v, brach_1977(), e_m, printed)
        assert left == pytest.approx(right, abs=1e-12)
        if e_m not in (0.0, 1.0):  # where both equations say the same
            left, right = eq_24(V, v, brach_1977(), e_m, not printed)
            assert abs(left - right) > 0.1
        approach_b, found = approach_and_coefficients(
            jnp.array(V), jnp.array(v[:3]), brach_1977(), name
        )
        np.testing.assert_allclose(np.array(approach_b), v[3:], rtol=1e-12)
        assert float(found.e_m) == pytest.approx(e_m, abs=1e-12)


def test_printed_eq_24_feeds_spin_and_is_singular_at_one_half() -> None:
    assert float(printed_e_m(0.7)) == pytest.approx(1.75, rel=1e-14)
    assert float(printed_e_m(printed_e_m(0.2))) == pytest.approx(0.2, rel=1e-14)
    assert float(printed_e_m(-1.0)) == pytest.approx(1 / 3, rel=1e-14)
    assert math.isinf(float(printed_e_m(0.5)))
    V = separation(jnp.zeros(6), brach_1977(), Coefficients(0.1, 0.3, 0.5), "as-printed")
    assert np.isnan(np.array(V)).any()


def test_an_unknown_moment_equation_is_refused() -> None:
    with pytest.raises(ValueError, match="as-printed"):
        separation(jnp.zeros(6), brach_1977(), Coefficients(0.1, 0.3, 0.5), "printed")


def test_mu_is_capped_where_sliding_ends() -> None:
    v = jnp.array([-20.1, 6.0, 0.3, 18.9, -3.6, -0.8])
    b = brach_1977()
    critical = critical_mu(v, b, 0.1, 0.7)

    def sliding_after(mu: float | str) -> tuple[float, float, bool]:
        held = capped(v, b, 0.1, mu, 0.7)
        after = contact_velocity(separation(v, b, held.coefficients), b)
        tangent = np.array([-math.sin(b.Gamma), math.cos(b.Gamma)])
        return float(np.array(after) @ tangent), float(held.ratio), bool(held.cut)

    assert sliding_after("critical") == (pytest.approx(0, abs=1e-12), 1, False)
    assert sliding_after(3 * critical) == (pytest.approx(0, abs=1e-12), 1, True)
    free, none, cut = sliding_after(-0.1 * critical)
    assert (none, cut) == (0, True)
    half, ratio, cut = sliding_after(0.5 * critical)
    assert (ratio, cut) == (pytest.approx(0.5), False)
    assert 0 < half / free < 1
    with pytest.raises(ValueError, match="critical"):
        capped(v, b, 0.1, "Critical", 0.7)


def test_friction_that_unloads_a_grazing_contact_never_ends_the_sliding() -> None:
    """The root of eq 23's caution has gone through infinity and come back with the other sign."""
    bodies = Bodies(2132.9, 2126.4, 2599.7, 4526.9, 0.66105, -0.27271, 1.83123, -0.62968, -0.62705)
    before = jnp.array([9.71544, -1.73468, 0.15864, -6.76114, -18.05650, -1.49781])
    e, tangent = 0.0672, jnp.array([-math.sin(-0.62705), math.cos(-0.62705)])

    def sliding_after(mu: float) -> float:
        after = separation(before, bodies, Coefficients(e, mu, 1.0))
        return float(contact_velocity(after, bodies) @ tangent)

    closing = float(contact_velocity(before, bodies) @ jnp.array([tangent[1], -tangent[0]]))
    sliding = float(contact_velocity(before, bodies) @ tangent)
    braking = math.copysign(1.0, sliding * closing)
    left = np.array([sliding_after(braking * mu) for mu in (0, 0.5, 20, 1e6)]) / sliding
    assert (np.diff(left) < 0).all()
    assert (left > 0).all()  # friction brakes and brakes, and sliding goes on
    assert float(critical_mu(before, bodies, e, 1.0)) == braking * math.inf
    kept = capped(before, bodies, e, braking * 0.5, 1.0)
    assert (float(kept.coefficients.mu), float(kept.ratio), bool(kept.cut)) == (
        braking * 0.5,
        0,
        False,
    )
    driven = capped(before, bodies, e, -braking * 0.35, 1.0)
    assert float(driven.coefficients.mu) == 0
    assert bool(driven.cut)
