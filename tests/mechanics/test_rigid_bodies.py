"""SAE 770014, first section (eqs 1-8): two bodies on circles of radius R hit head on with e = 0."""

import math

import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import Bodies, Coefficients, central_impact, separation

m, inertia, R, v = 1500.0, 2500.0, 4.0, 6.0
APPROACH = (v, v / R, -v, -v / R)


def energy(V_ay: float, Omega_a: float, V_by: float, Omega_b: float) -> float:
    return 0.5 * m * (V_ay**2 + V_by**2) + 0.5 * inertia * (Omega_a**2 + Omega_b**2)


def test_without_the_moment_they_turn_through_one_another() -> None:
    after = central_impact(APPROACH, (m, m), (inertia, inertia), e=0.0)
    assert after[:4] == pytest.approx((0, v / R, 0, -v / R), abs=1e-12)
    assert energy(*after[:4]) == pytest.approx(inertia * (v / R) ** 2)
    assert after.M == 0


def test_with_e_m_zero_all_motion_ends() -> None:
    after = central_impact(APPROACH, (m, m), (inertia, inertia), e=0.0, e_m=0.0)
    assert after[:4] == pytest.approx((0, 0, 0, 0), abs=1e-12)


def test_with_e_m_minus_one_the_spin_rebounds_elastically() -> None:
    after = central_impact(APPROACH, (m, m), (inertia, inertia), e=1.0, e_m=-1.0)
    assert after[:4] == pytest.approx((-v, -v / R, v, v / R))
    assert energy(*after[:4]) == pytest.approx(energy(*APPROACH))


@pytest.mark.parametrize("e_m", [-1.0, 0.0, 0.4, 1.0])
def test_unlike_bodies_keep_every_equation_of_the_section(e_m: float) -> None:
    e, (m_a, m_b), (I_a, I_b) = 0.3, (1200.0, 2000.0), (1800.0, 3500.0)
    v_ay, omega_a, v_by, omega_b = before = (9.0, 1.1, -2.0, -0.4)
    V_ay, Omega_a, V_by, Omega_b, P_y, M = central_impact(before, (m_a, m_b), (I_a, I_b), e, e_m)
    assert m_a * (V_ay - v_ay) == pytest.approx(-P_y)  # eq 1
    assert m_b * (V_by - v_by) == pytest.approx(P_y)  # eq 2
    assert V_by - V_ay == pytest.approx(-e * (v_by - v_ay))  # eq 5
    assert I_a * (Omega_a - omega_a) + I_b * (Omega_b - omega_b) == pytest.approx(0, abs=1e-9)  # 6
    assert Omega_b - Omega_a == pytest.approx(e_m * (omega_b - omega_a))  # eq 7a
    moment = -e_m * M * (I_a + I_b) / (I_a * I_b)
    assert (Omega_b - Omega_a) * (1 - e_m) == pytest.approx(moment)  # eq 8


@pytest.mark.parametrize("e_m", [-1.0, 0.0, 0.4, 1.0])
def test_it_is_a_case_of_the_planar_impact(e_m: float) -> None:
    """Contact line along x (Gamma = 90 deg), B behind A on the y axis, arms along the force."""
    bodies = Bodies(1200.0, 2000.0, 1800.0, 3500.0, -1.0, 0.0, -1.0, 0.0, math.pi / 2)
    before = jnp.array([0.0, 9.0, 1.1, 0.0, -2.0, -0.4])
    planar = np.array(separation(before, bodies, Coefficients(0.3, 0.0, e_m)))
    central = central_impact((9.0, 1.1, -2.0, -0.4), (1200.0, 2000.0), (1800.0, 3500.0), 0.3, e_m)
    expected = [0, central.V_ay, central.Omega_a, 0, central.V_by, central.Omega_b]
    np.testing.assert_allclose(planar, expected, atol=1e-12)
