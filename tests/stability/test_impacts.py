"""The edges of the impact that docs/atlas.md lists."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import (
    Coefficients,
    NotDetermined,
    against_barrier,
    approach_and_coefficients,
    capped,
    critical_mu,
    feeding_term,
    printed_e_m,
    reverses_sliding,
    separation,
    severity,
    solve,
)
from retrodict.mechanics.solve import NAMES
from tests.shared.edges import (
    BEFORE,
    BODIES,
    COEFFICIENTS,
    endless_sliding,
    grazing,
    parted_by_spin,
    soft,
    undone,
)

NOWHERE = jnp.zeros(2)


def test_printed_eq_24_near_one_half() -> None:
    """Finite beside 1/2, not a number at it; the audit of what it does there gains energy."""
    beside = COEFFICIENTS._replace(e_m=0.5 + 1e-6)
    after = separation(jnp.array(BEFORE), BODIES, beside, "as-printed")
    assert np.isfinite(after).all()
    at = separation(jnp.array(BEFORE), BODIES, COEFFICIENTS._replace(e_m=0.5), "as-printed")
    assert np.isnan(at).any()
    as_corrected = beside._replace(e_m=printed_e_m(beside.e_m))
    audit = severity(jnp.array(BEFORE), BODIES, as_corrected, NOWHERE)
    np.testing.assert_allclose(audit.after, after, rtol=1e-12)
    assert feeding_term(audit.energy) is not None


def test_zero_closing_speed_is_refused_by_name() -> None:
    before = np.array([10.0, 4.0, 0.0, 10.0, -4.0, 0.0])
    bodies = BODIES._replace(Gamma=0.0)
    after = separation(jnp.array(before), bodies, COEFFICIENTS)
    np.testing.assert_array_equal(after, before)
    _, found = approach_and_coefficients(after, jnp.array(before[:3]), bodies)
    assert np.isnan([float(x) for x in found]).all()
    with pytest.raises(NotDetermined, match="e, mu, e_m can trade off"):
        undone(before, bodies, COEFFICIENTS)


def test_gamma_grazing_loses_e_slowly_and_is_then_refused() -> None:
    for offset in (1e-3, 1e-6, 1e-9):
        found = undone(BEFORE, grazing(offset), COEFFICIENTS)
        assert found["e"] == pytest.approx(0.1, abs=1e-15 / offset)
    with pytest.raises(NotDetermined):
        undone(BEFORE, grazing(1e-11), COEFFICIENTS)


def test_mu_past_critical_is_flagged_and_capped() -> None:
    critical = float(critical_mu(jnp.array(BEFORE), BODIES, 0.1, 0.7))
    for r, reverses in ((0.99, False), (1.01, True), (3.0, True), (-0.1, True)):
        c = COEFFICIENTS._replace(mu=r * critical)
        assert bool(reverses_sliding(jnp.array(BEFORE), BODIES, c)) == reverses
    held = capped(jnp.array(BEFORE), BODIES, 0.1, 3 * critical, 0.7)
    assert float(held.coefficients.mu) == pytest.approx(critical)
    assert bool(held.cut)


def test_sliding_that_no_friction_ends() -> None:
    """Critical mu is infinite: at it velocities are not numbers; the driving sign is flagged."""
    bodies, before = endless_sliding()
    critical = critical_mu(jnp.array(before), bodies, 0.0672, 1.0)
    assert math.isinf(float(critical))
    at = separation(jnp.array(before), bodies, Coefficients(0.0672, critical, 1.0))
    assert np.isnan(at).any()
    sign = math.copysign(1.0, float(critical))
    for mu, reverses in ((0.35 * sign, False), (-0.35 * sign, True), (0.0, False)):
        c = Coefficients(0.0672, mu, 1.0)
        assert bool(reverses_sliding(jnp.array(before), bodies, c)) == reverses


@pytest.mark.parametrize(("closing", "pulls"), [(20.0, False), (5.0, True)])
def test_an_impulse_that_pulls_is_flagged(closing: float, pulls: bool) -> None:
    before = jnp.array([closing - 12.0, 0.0, 0.0, 0.0, 0.0, 8.0])
    audit = severity(before, parted_by_spin(), Coefficients(0.1, 0.0, 0.0), NOWHERE)
    assert bool(audit.pulls) == pulls
    assert (float(audit.delta_v[0, 0]) > 0) == pulls  # the impulse on A


@pytest.mark.parametrize("share", [0.9, 0.99, 0.999999])
def test_a_contact_without_stiffness_gains_energy_and_says_so(share: float) -> None:
    audit = severity(*jax.tree.map(jnp.asarray, soft(share)), NOWHERE)
    assert np.isfinite(audit.after).all()
    assert bool(audit.gains_energy)
    assert feeding_term(audit.energy) == "moment"


def test_mass_ratios_tend_to_the_barrier() -> None:
    """The gap falls with the ratio; an unmoved body does not determine what hit it."""
    wall = against_barrier(1857.0, 3374.0, 0.205, 2.079, -0.155)
    before = jnp.array([*BEFORE[:3], 0.0, 0.0, 0.0])
    expected = separation(before, wall, COEFFICIENTS)
    for ratio in (1e2, 1e6, 1e12):
        heavy = wall._replace(m_b=1857.0 * ratio, I_b=3374.0 * ratio)
        after = separation(before, heavy, COEFFICIENTS)
        np.testing.assert_allclose(after, expected, atol=100 / ratio)
    known = dict(zip(NAMES, [*before, *expected, *COEFFICIENTS], strict=True))
    known = {name: float(value) for name, value in known.items()}
    with pytest.raises(NotDetermined):
        solve(known, wall, (*NAMES[:3], *NAMES[6:9]))


@pytest.mark.parametrize("kept", [[2, 5], [0, 1, 3, 4]], ids=["spin", "translation"])
def test_spin_alone_and_translation_alone_come_back(kept: list[int]) -> None:
    before = np.zeros(6)
    before[kept] = BEFORE[kept]
    found = undone(before, BODIES, COEFFICIENTS)
    expected = [*before[3:], *COEFFICIENTS]
    names = (*NAMES[3:6], *NAMES[12:])
    np.testing.assert_allclose([found[n] for n in names], expected, atol=1e-9)


@pytest.mark.parametrize("bodies", [BODIES, grazing(1e-5)], ids=["as it is", "grazing"])
def test_single_precision_keeps_five_digits(bodies: tuple) -> None:
    single = jax.tree.map(jnp.float32, (bodies, COEFFICIENTS))
    after = separation(jnp.asarray(BEFORE, jnp.float32), *single)
    assert after.dtype == jnp.float32
    expected = np.asarray(separation(jnp.array(BEFORE), bodies, COEFFICIENTS))
    np.testing.assert_allclose(after, expected, atol=1e-5 * np.abs(expected).max())
