"""Delta-V, direction of force, closing speed, and who fed an outcome that gains energy."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import (
    Bodies,
    Coefficients,
    against_barrier,
    audit,
    clock,
    closing_speed,
    critical_mu,
    either_side,
    feeding_term,
    lever_arms,
    reverses_sliding,
    separation,
    severity,
)


def cars(d1: float = 0.0, d3: float = 0.0, Gamma: float = 0.0) -> Bodies:
    return Bodies(1500.0, 1000.0, 2500.0, 1500.0, d1, 0.0, d3, 0.0, Gamma)


def test_head_on_crash_of_two_cars() -> None:
    """Central and inelastic: common velocity (1500 * 20 - 1000 * 10) / 2500 = 8 m/s."""
    before = jnp.array([20.0, 0.0, 0.0, -10.0, 0.0, 0.0])
    found = severity(before, cars(), Coefficients(0.0, 0.0, 1.0), jnp.array([0.0, math.pi]))
    np.testing.assert_allclose(found.after[jnp.array([0, 3])], [8, 8], rtol=1e-14)
    np.testing.assert_allclose(found.delta_v, [[-12, 0], [18, 0]], atol=1e-13)
    np.testing.assert_allclose(found.delta_v_size, [12, 18], rtol=1e-14)
    np.testing.assert_array_equal(clock(found.pdof), [12, 12])
    assert float(found.closing) == float(found.closing_normal) == pytest.approx(30)
    lost = 0.5 * 600 * 30**2  # half the reduced mass times the closing speed squared
    assert float(found.energy.before - found.energy.after) == pytest.approx(lost)
    assert not found.gains_energy


@pytest.mark.parametrize(
    ("heading_a", "hour"), [(0, 12), (90, 3), (180, 6), (270, 9), (30, 1), (-30, 11), (60, 2)]
)
def test_direction_of_force_is_clockwise_from_straight_ahead(heading_a: float, hour: int) -> None:
    """A is pushed to -x, so the force comes from +x: a car that points to +y feels it at its right."""
    before = jnp.array([20.0, 0.0, 0.0, -10.0, 0.0, 0.0])
    headings = jnp.array([math.radians(heading_a), 0.0])
    found = severity(before, cars(), Coefficients(0.0, 0.0, 1.0), headings)
    assert math.degrees(float(found.pdof[0])) == pytest.approx(heading_a % 360, abs=1e-9)
    assert int(clock(found.pdof)[0]) == hour
    assert int(clock(found.pdof)[1]) == 6  # B points to +x and is pushed that way


def test_closing_speed_counts_the_spins_and_both_directions() -> None:
    before = jnp.array([3.0, 4.0, 2.0, 0.0, 0.0, -1.0])
    found = severity(before, cars(d1=1.0, d3=0.5), Coefficients(0.0, 0.0, 1.0), jnp.zeros(2))
    # 3 + 0.5 * 2 + 1.0 * (-1) along the normal, 4 along the tangent
    assert float(found.closing_normal) == pytest.approx(3)
    assert float(found.closing) == pytest.approx(5)


def test_nothing_happens_without_a_closing_speed() -> None:
    before = jnp.array([12.0, 5.0, 0.0, 12.0, -5.0, 0.0])
    found = severity(before, cars(), Coefficients(0.5, 0.3, 1.0), jnp.zeros(2))
    np.testing.assert_array_equal(found.after, before)
    assert np.isnan(found.pdof).all()  # no force, no direction
    assert not found.gains_energy
    assert not found.reverses_sliding


@pytest.mark.parametrize(
    ("c", "spins", "term"),
    [
        (Coefficients(1.2, 0.0, 1.0), (0.0, 0.0), "normal"),
        (Coefficients(1.0, 0.3, 1.0), (0.0, 0.0), "tangential"),
        (Coefficients(1.0, 0.0, -1.5), (2.0, -2.0), "moment"),
    ],
)
def test_a_gain_of_energy_is_flagged_with_the_term_that_feeds_it(
    c: Coefficients, spins: tuple[float, float], term: str
) -> None:
    before = jnp.array([20.0, 5.0, spins[0], -10.0, 0.0, spins[1]])
    found = severity(before, cars(), c, jnp.zeros(2))
    gain = float(found.energy.after - found.energy.before)
    assert gain > 0
    assert bool(found.gains_energy)
    assert feeding_term(found.energy) == term
    work = found.energy.normal + found.energy.tangential + found.energy.moment
    assert float(work) == pytest.approx(gain, rel=1e-12)


def test_the_printed_eq_24_feeds_spin_and_the_audit_shows_it() -> None:
    """SAE 770014's printed eq 24 at e_m = 0.7 acts as the corrected one at 1.75."""
    before = jnp.array([20.0, 0.0, 2.0, -10.0, 0.0, -2.0])
    energy = audit(before, cars(), Coefficients(1.0, 0.0, 0.7 / (2 * 0.7 - 1)))
    assert feeding_term(energy) == "moment"
    assert feeding_term(audit(before, cars(), Coefficients(1.0, 0.0, 0.7))) is None


def test_an_elastic_impact_gains_nothing_by_rounding() -> None:
    rng = np.random.default_rng(7)
    compiled = jax.jit(audit)
    for before in rng.normal(size=(200, 6)) * [30, 30, 4, 30, 30, 4]:
        energy = compiled(before, cars(0.7, 1.1, 0.3), Coefficients(1.0, 0.0, 1.0))
        assert float(energy.after) == pytest.approx(float(energy.before), rel=1e-12)
        assert feeding_term(energy) is None


@pytest.mark.parametrize(("r", "reverses"), [(-0.1, True), (0.0, False), (1.0, False), (1.1, True)])
def test_reversal_of_sliding_is_flagged(r: float, reverses: bool) -> None:
    before = jnp.array([20.0, 5.0, 0.3, -10.0, 0.0, -0.2])
    bodies = cars(0.7, 1.1, 0.3)
    c = Coefficients(0.1, r * critical_mu(before, bodies, 0.1, 0.8), 0.8)
    assert bool(severity(before, bodies, c, jnp.zeros(2)).reverses_sliding) == reverses
    assert bool(reverses_sliding(before, bodies, c)) == reverses


@pytest.mark.slow
def test_a_batch_is_one_call() -> None:
    before = jnp.array([[20.0, 0, 0, -10, 0, 0], [10.0, 0, 0, 0, 0, 0]])
    c = Coefficients(jnp.array([0.0, 1.0]), jnp.zeros(2), jnp.ones(2))
    found = jax.vmap(severity, in_axes=(0, None, 0, None))(before, cars(), c, jnp.zeros(2))
    np.testing.assert_allclose(found.delta_v_size, [[12, 18], [8, 12]], rtol=1e-14)


# -- barrier ---------------------------------------------------------------------------------


def test_a_particle_bounces_off_a_wall_with_friction() -> None:
    """V_n = -e v_n and V_t = v_t - mu (1 + e) v_n; the energy lost is A's."""
    e, mu, G = 0.3, 0.2, 0.4
    n, t = np.array([math.cos(G), math.sin(G)]), np.array([-math.sin(G), math.cos(G)])
    v = -12.0 * n - 7.0 * t
    bodies = against_barrier(1500.0, 2500.0, 0.0, 0.0, G)
    before = jnp.array([*v, 0.9, 0.0, 0.0, 0.0])
    after = np.array(separation(before, bodies, Coefficients(e, mu, 1.0)))
    assert after[:2] @ n == pytest.approx(e * 12.0)
    assert after[:2] @ t == pytest.approx(-7.0 + mu * (1 + e) * 12.0)
    np.testing.assert_array_equal(after[2:], [0.9, 0.0, 0.0, 0.0])
    found = severity(before, bodies, Coefficients(e, mu, 1.0), jnp.zeros(2))
    assert float(found.energy.before) == pytest.approx(
        0.5 * 1500 * (12**2 + 7**2) + 0.5 * 2500 * 0.9**2
    )
    work = found.energy.normal + found.energy.tangential + found.energy.moment
    assert float(found.energy.after - found.energy.before) == pytest.approx(float(work), rel=1e-12)
    assert np.isnan(float(found.pdof[1]))  # nothing pushes the barrier anywhere
    assert int(clock(found.pdof)[1]) == 0
    assert float(critical_mu(before, bodies, e, 1.0)) == pytest.approx(7 / (12 * (1 + e)))


@pytest.mark.parametrize(("e_m", "share"), [(1.0, 1.0), (0.0, 0.0), (0.4, 0.4)])
def test_the_end_of_a_rod_hits_a_wall(e_m: float, share: float) -> None:
    """A rod of length L, its end a lever L/2 from the middle, I = m L²/12.

    Without moment P = (1 + e) m v / 4 and the spin is 6 P / (m L). With e_m = 0 the wall holds the
    rod's direction, so that it cannot spin and P = (1 + e) m v; in between, the wall's moment leaves
    the share e_m of the spin that the force alone would give, and P = (1 + e) m v / (1 + 3 e_m).
    """
    m, L, v, e = 20.0, 3.0, 5.0, 0.4
    bodies = against_barrier(m, m * L**2 / 12, -L / 2, 0.0, 0.0)
    before = jnp.array([-v, 0.0, 0.0, 0.0, 0.0, 0.0])
    after = np.array(separation(before, bodies, Coefficients(e, 0.0, e_m)))
    P = (1 + e) * m * v / (1 + 3 * share)
    expected = [-v + P / m, 0, -share * 6 * P / (m * L), 0, 0, 0]
    np.testing.assert_allclose(after, expected, atol=1e-12)


def test_a_barrier_is_the_limit_of_a_heavy_vehicle() -> None:
    before, c = jnp.array([-20.0, 3.0, 0.5, 0.0, 0.0, 0.0]), Coefficients(0.1, 0.3, 0.6)
    wall = against_barrier(1500.0, 2500.0, 0.7, 1.5, 0.2)
    heavy = wall._replace(m_b=1e15, I_b=1e15)
    expected = np.array(separation(before, heavy, c))
    np.testing.assert_allclose(np.array(separation(before, wall, c)), expected, atol=1e-9)


def test_gradients_stay_finite_at_an_infinite_mass() -> None:
    before = jnp.array([-20.0, 3.0, 0.5, 0.0, 0.0, 0.0])

    def lost(before: jax.Array) -> jax.Array:
        bodies = against_barrier(1500.0, 2500.0, 0.7, 1.5, 0.2)
        energy = audit(before, bodies, Coefficients(0.1, 0.3, 0.6))
        return energy.before - energy.after

    assert np.isfinite(np.array(jax.grad(lost)(before))).all()


def test_a_barrier_lies_beyond_the_contact() -> None:
    """So that what drives at it closes in, whichever way the normal is counted."""
    for Gamma in (0.3, 0.3 + math.pi):
        bodies = against_barrier(1500.0, 2500.0, 0.2, -1.5, Gamma)  # impact centre at (1.5, -0.2)
        assert bool(either_side(bodies))
        closing = float(closing_speed([12.0, 0, 0, 0, 0, 0], bodies))
        assert closing == pytest.approx(12 * math.cos(0.3))


# Small-overlap tests into rigid barriers: e, mu over critical, centre of gravity to impact centre (ft),
# its angle and Gamma (deg), speed, delta-v backwards and to the right (ft/s), yaw rate after (deg/s).
# SAE 2014-01-0469, Appendix 2, Part 1
FORD_FUSION = {
    "CF10028, a pole": (0.232, 0.718, 3.9, 32.9, 74.6, 58.51, 32.29, 13.70, 60.83),
    "CF11002, a wall": (0.0, 0.852, 4.1, 29.0, 74.6, 58.60, 38.49, 10.69, 102.75),
    "CF11004, a wall": (0.0, 0.823, 4.0, 31.3, 74.6, 58.60, 36.41, 10.56, 103.00),
    "CF11012, a wall": (0.127, 0.865, 4.0, 30.6, 74.6, 58.69, 40.91, 12.51, 110.00),
    "CF11013, a wall": (0.0, 0.895, 3.9, 32.9, 74.6, 58.60, 41.95, 9.51, 142.19),
}


@pytest.mark.parametrize("test", FORD_FUSION)
def test_published_impacts_with_barriers_are_reproduced(test: str) -> None:
    """Mass and inertia are not published: the speeds hang on k² alone, k of 0.49 wheelbases, 2.728 m."""
    e, share, d, phi, Gamma, v, back, right, spin = FORD_FUSION[test]
    lever = 0.3048 * d * np.array([math.cos(math.radians(phi)), math.sin(math.radians(phi))])
    _, _, d3, d4 = lever_arms(jnp.asarray(lever), jnp.zeros(2))
    k2 = (0.49 * 2.728) ** 2
    bodies = against_barrier(1.0, k2, d3, d4, math.radians(Gamma))
    before = [0.3048 * v, 0, 0, 0, 0, 0]
    mu = share * critical_mu(before, bodies, e, 1.0)
    change = np.asarray(separation(before, bodies, Coefficients(e, mu, 1.0)))[:3] - before[:3]
    assert change[:2] / 0.3048 == pytest.approx([-back, -right], abs=2.2)
    assert math.degrees(change[2]) == pytest.approx(spin, rel=0.06)
