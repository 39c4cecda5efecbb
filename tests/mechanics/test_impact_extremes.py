"""Where impacts turn strange, the numbers stay finite and right, or the case is refused by name."""

import itertools
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import (
    Bodies,
    Coefficients,
    NotDetermined,
    approach_and_coefficients,
    audit,
    capped,
    contact_velocity,
    critical_mu,
    impulse,
    separation,
    solve,
)
from retrodict.mechanics.solve import NAMES

BEFORE = np.array([-20.1, 3.0, 0.2, 18.9, -3.6, -0.3])
_separation = jax.jit(separation)
_audit = jax.jit(audit)


def cars(**change: float) -> Bodies:
    """The cars of SAE 770014's example."""
    bodies = Bodies(1857.0, 1778.0, 3374.0, 3007.0, 1.636, 0.653, 0.205, 2.079, -0.155)
    return bodies._replace(**change)


def holds(before: np.ndarray, bodies: Bodies, c: Coefficients, tolerance: float = 1e-12) -> None:
    """Momentum, eq 22, eq 24 and the audit, each to rounding of the terms that it adds."""
    after = np.array(_separation(before, bodies, c))
    assert np.isfinite(after).all()
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, G = (float(b) for b in bodies)
    v, V = np.asarray(before, float), np.asarray(after, float)
    scale = np.abs([v, V]).max()
    for i in (0, 1):
        gain = m_a * (V[i] - v[i]) + m_b * (V[i + 3] - v[i + 3])
        assert abs(gain) <= tolerance * (m_a + m_b) * scale
    normal = np.array([math.cos(G), math.sin(G)])
    opening, closing = (np.array(contact_velocity(jnp.array(u), bodies)) @ normal for u in (V, v))
    assert opening == pytest.approx(-float(c.e) * closing, abs=10 * tolerance * scale)
    # eq 24 with the impulse from the lighter body, whose change of velocity is the larger
    P = m_a * (V[:2] - v[:2]) if m_a < m_b else -m_b * (V[3:5] - v[3:5])
    free = v[5] + (P[0] * d1 - P[1] * d2) / I_b - v[2] - (P[0] * d3 - P[1] * d4) / I_a
    assert V[5] - V[2] == pytest.approx(float(c.e_m) * free, abs=10 * tolerance * scale)
    energy = _audit(before, bodies, c)
    work = float(energy.normal + energy.tangential + energy.moment)
    sizes = sum(abs(float(term)) for term in energy)
    assert abs(work - float(energy.after - energy.before)) <= tolerance * sizes


@pytest.mark.parametrize(
    ("e", "e_m", "mu"),
    list(itertools.product((0.0, 1.0), (-1.0, -0.5, 0.0, 0.5, 1.0), (0.0, 0.35))),
)
def test_the_ends_of_every_coefficient(e: float, e_m: float, mu: float) -> None:
    holds(BEFORE, cars(), Coefficients(e, mu, e_m))


@pytest.mark.parametrize("kept", [slice(2, None, 3), [0, 1, 3, 4]], ids=["spin", "translation"])
@pytest.mark.parametrize("e_m", [-1.0, 0.0, 0.7, 1.0])
def test_spin_without_translation_and_the_reverse(kept: slice | list[int], e_m: float) -> None:
    before = np.zeros(6)
    before[kept] = BEFORE[kept]
    holds(before, cars(), Coefficients(0.1, 0.35, e_m))


@pytest.mark.parametrize("ratio", [1e-6, 1e6])
@pytest.mark.parametrize("e_m", [-1.0, 0.0, 0.7, 1.0])
def test_mass_ratio_of_a_million(ratio: float, e_m: float) -> None:
    bodies = cars(m_b=1857.0 * ratio, I_b=3374.0 * ratio)
    holds(BEFORE, bodies, Coefficients(0.1, 0.35, e_m))
    after = np.array(_separation(BEFORE, bodies, Coefficients(0.1, 0.35, e_m)))
    heavy = slice(3, 6) if ratio > 1 else slice(0, 3)
    np.testing.assert_allclose(after[heavy], BEFORE[heavy], atol=1e-3)  # hardly notices
    known = dict(zip(NAMES, [*BEFORE, *map(float, after), 0.1, 0.35, e_m], strict=True))
    found = solve(known, bodies, NAMES[6:12])
    np.testing.assert_allclose(list(found.values.values())[6:12], after, rtol=1e-9, atol=1e-12)


def along_the_contact_line(offset: float) -> Bodies:
    """Gamma such that the relative velocity at the impact centre lies `offset` off the tangent."""
    x, y = (float(u) for u in contact_velocity(jnp.array(BEFORE), cars()))
    return cars(Gamma=math.atan2(y, x) - math.pi / 2 + offset)


@pytest.mark.parametrize("offset", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("e_m", [-1.0, 0.0, 0.7, 1.0])
def test_grazing_contact(offset: float, e_m: float) -> None:
    bodies = along_the_contact_line(offset)
    holds(BEFORE, bodies, Coefficients(0.1, 0.35, e_m))
    if e_m == 1:  # no moment: the impulse vanishes with the closing speed
        P, _ = impulse(jnp.array(BEFORE), bodies, Coefficients(0.1, 0.35, 1.0))
        assert float(jnp.hypot(*P)) < 4000 * 40 * offset


def test_zero_closing_speed() -> None:
    """Side by side at one speed: nothing happens forward, and the inverse is refused."""
    before = np.array([10.0, 4.0, 0.0, 10.0, -4.0, 0.0])
    bodies = cars(Gamma=0.0)
    after = np.array(_separation(before, bodies, Coefficients(0.5, 0.3, 0.2)))
    np.testing.assert_array_equal(after, before)
    assert math.isnan(float(critical_mu(jnp.array(before), bodies, 0.5, 0.2)))
    held = capped(jnp.array(before), bodies, 0.5, 0.3, 0.2)
    assert (float(held.coefficients.mu), bool(held.cut)) == (0.3, False)
    _, found = approach_and_coefficients(jnp.array(after), jnp.array(before[:3]), bodies)
    assert np.isnan([float(x) for x in found]).all()
    known = dict(zip(NAMES, [*before, *after, 0, 0, 0], strict=True))
    with pytest.raises(NotDetermined) as problem:
        solve(known, bodies, (*NAMES[3:6], "e", "mu", "e_m"))
    assert problem.value.trade_off == ("e", "mu", "e_m")


@pytest.mark.slow
@pytest.mark.parametrize("e_m", [-1.0, 0.0, 0.7, 1.0])
def test_single_precision(e_m: float) -> None:
    """Within 1e-5 of double precision, and single throughout."""
    single = Bodies(*(jnp.float32(b) for b in cars()))
    c = Coefficients(*(jnp.float32(x) for x in (0.1, 0.35, e_m)))
    before = jnp.array(BEFORE, jnp.float32)
    after = _separation(before, single, c)
    assert after.dtype == jnp.float32
    expected = np.array(_separation(BEFORE, cars(), Coefficients(0.1, 0.35, e_m)))
    np.testing.assert_allclose(np.array(after), expected, atol=1e-5 * np.abs(expected).max())
    holds(before, single, c, tolerance=2e-6)
    approach_b, found = approach_and_coefficients(after, before[:3], single)
    assert approach_b.dtype == found.e.dtype == jnp.float32
    np.testing.assert_allclose(np.array(approach_b), BEFORE[3:], atol=1e-4)
    np.testing.assert_allclose([float(x) for x in found], [0.1, 0.35, e_m], atol=1e-4)
    critical = critical_mu(before, single, c.e, c.e_m)
    assert critical.dtype == jnp.float32
    assert float(critical) == pytest.approx(float(critical_mu(BEFORE, cars(), 0.1, e_m)), rel=1e-4)
