"""Any six of the fifteen quantities of eqs 19-24 from the other nine."""

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
    Solution,
    against_barrier,
    contact_velocity,
    critical_mu,
    printed_e_m,
    separation,
    solve,
)
from retrodict.mechanics.solve import NAMES

_separation = jax.jit(separation)
COMBINATIONS = list(itertools.combinations(NAMES, 6))
COEFFICIENTS = ("e", "mu", "e_m")


def collision(rng: np.random.Generator) -> tuple[dict[str, float], Bodies]:
    """Two cars in general position and the fifteen quantities of their impact."""
    m_a, m_b = rng.uniform(800, 3000, 2)
    I_a, I_b = m_a * rng.uniform(1.1, 1.6) ** 2, m_b * rng.uniform(1.1, 1.6) ** 2
    bodies = Bodies(m_a, m_b, I_a, I_b, *rng.uniform(0.3, 2.2, 4), rng.uniform(0.1, 1.4))
    before = rng.normal(size=6) * [15, 15, 1, 15, 15, 1]
    c = Coefficients(rng.uniform(0, 0.5), rng.uniform(0.1, 0.6), rng.uniform(0, 0.9))
    after = np.array(_separation(before, bodies, c))
    return dict(zip(NAMES, [*before, *after, *c], strict=True)), bodies


def misfits(x: dict[str, float] | np.ndarray, b: Bodies) -> np.ndarray:
    """Eqs 19-24 as SAE 770014 writes them, 21 and 24 corrected."""
    v, V, (e, mu, e_m) = np.split(np.array(list(x.values()) if isinstance(x, dict) else x), [6, 12])
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, G = b
    sin, cos = np.sin(G), np.cos(G)
    d = V - v
    f_a = m_a * (d3 * d[0] - d4 * d[1])
    f_b = -m_b * (d1 * d[3] - d2 * d[4])

    def normal(u: np.ndarray) -> complex:
        y = u[1] - d4 * u[2] - u[4] - d2 * u[5]
        return y * sin + (u[0] + d3 * u[2] - u[3] + d1 * u[5]) * cos

    return np.array(
        [
            m_b * d[3] + m_a * d[0],
            m_b * d[4] + m_a * d[1],
            I_b * d[5] + I_a * d[2] + m_b * (d1 + d3) * d[3] + m_a * (d2 + d4) * d[1],
            normal(V) + e * normal(v),
            m_a * d[1] * (cos - mu * sin) + m_b * d[3] * (sin + mu * cos),
            (V[5] - V[2]) * (1 - e_m) + e_m * ((d[5] - f_b / I_b) - (d[2] - f_a / I_a)),
        ]
    ) / [m_a, m_a, I_a, 1, m_a, 1]  # fmt: skip


def paper_jacobian(x: np.ndarray, b: Bodies, unknown: tuple[str, ...]) -> np.ndarray:
    """By complex steps, exact to rounding."""
    columns = []
    for name in unknown:
        moved = x.astype(complex)
        moved[NAMES.index(name)] += 1e-30j
        columns.append(misfits(moved, b).imag / 1e-30)
    return np.stack(columns, axis=1)


def attempt(known: dict[str, float], b: Bodies, unknown: tuple) -> Solution | NotDetermined:
    try:
        return solve(known, b, unknown)
    except NotDetermined as refusal:
        return refusal


@pytest.mark.slow
def test_every_choice_of_six_is_solved_or_refused_with_reason() -> None:
    """All 5005: back comes the truth, which satisfies the paper's equations, or the rank is short."""
    true, bodies = collision(np.random.default_rng(1977))
    x = np.array(list(true.values()))
    solved = refused = 0
    for unknown in COMBINATIONS:
        columns = paper_jacobian(x, bodies, unknown)
        sizes = np.linalg.svd(columns, compute_uv=False)
        tiny = 1e-9 * sizes[0]
        found = attempt(true, bodies, unknown)
        if isinstance(found, Solution):
            assert sizes[-1] > tiny, unknown
            assert np.abs(misfits(found.values, bodies)).max() < 1e-8
            np.testing.assert_allclose(list(found.values.values()), x, rtol=1e-8, atol=1e-8)
            solved += 1
            continue
        assert found.rank == (sizes > tiny).sum() < 6, unknown
        assert not found.contradicts  # the known values come from one impact
        for i, name in enumerate(unknown):
            # an unknown that trades off is one whose column the others can make up for
            rank = np.linalg.matrix_rank(np.delete(columns, i, axis=1), tol=tiny)
            assert (rank == found.rank) == (name in found.trade_off), (unknown, name)
        refused += 1
    assert (solved, refused) == (2848, 2157)


def test_hundreds_of_other_collisions() -> None:
    rng = np.random.default_rng(24)
    outcomes = []
    for _ in range(600):
        true, bodies = collision(rng)
        unknown = COMBINATIONS[rng.integers(len(COMBINATIONS))]
        found = attempt(true, bodies, unknown)
        outcomes.append(isinstance(found, Solution))
        if isinstance(found, NotDetermined):
            assert found.rank < 6
            continue
        assert np.abs(misfits(found.values, bodies)).max() < 1e-8
        # a well-conditioned choice returns the truth, an ill one as well as its condition allows
        x = np.array(list(true.values()))
        error = np.abs(np.array(list(found.values.values())) - x).max()
        assert error < max(1e-8, 1e-13 * found.condition * np.abs(x).max())
    assert 250 < sum(outcomes) < 450


@pytest.mark.parametrize(
    ("unknown", "rank", "trade_off"),
    [
        # both bodies may move faster along x together, whatever the impact
        ("v_ax V_ax v_bx V_bx e mu", 4, {"v_ax", "V_ax", "v_bx", "V_bx", "e"}),
        # A's speed before and after rise together and only eq 22 sees it, which e absorbs
        ("v_ax V_ax e mu omega_b v_by", 5, {"v_ax", "V_ax", "e"}),
        # spins stand in three equations
        (
            "omega_a omega_b Omega_a Omega_b v_ax mu",
            5,
            {"omega_a", "omega_b", "Omega_a", "Omega_b"},
        ),
    ],
)
def test_refusal_names_what_trades_off(unknown: str, rank: int, trade_off: set[str]) -> None:
    true, bodies = collision(np.random.default_rng(5))
    with pytest.raises(NotDetermined) as problem:
        solve(true, bodies, unknown.split())
    assert problem.value.rank == rank
    assert set(problem.value.trade_off) == trade_off
    assert f"{rank} of 6" in str(problem.value)
    assert "can trade off; give one of these a value" in str(problem.value)


def test_known_values_that_contradict_are_said_to() -> None:
    true, bodies = collision(np.random.default_rng(5))
    true["V_by"] += 3.0  # eq 20 no longer holds, and all of y is known
    with pytest.raises(NotDetermined, match="contradict"):
        solve(true, bodies, ["v_ax", "V_ax", "e", "mu", "omega_b", "omega_a"])


def test_tables_3_and_4_as_printed_in_the_paper() -> None:
    """SAE 770014's own choice of six: v_bx, v_by, omega_b, e, mu, e_m from Table 3."""
    bodies = Bodies(1857.0, 1778.0, 3374.0, 3007.0, 1.636, 0.653, 0.205, 2.079, -0.155)
    table_3 = [-20.1, 0.0, 0.0, -7.0, 2.4, 0.61, 5.2, -6.1, 9.9]
    names = [*NAMES[:3], *NAMES[6:12]]
    x = solve(dict(zip(names, table_3, strict=True)), bodies).values
    assert math.hypot(x["v_bx"], x["v_by"]) == pytest.approx(19.3, abs=0.1)
    assert (x["e"], x["mu"], x["e_m"]) == pytest.approx((0.10, 0.35, 0.70), abs=0.005)
    printed = solve(
        dict(zip(names, table_3, strict=True)), bodies, moment_equation="as-printed"
    ).values
    assert printed["e_m"] == pytest.approx(x["e_m"] / (2 * x["e_m"] - 1), rel=1e-12)


@pytest.mark.parametrize("moment_equation", ["corrected", "as-printed"])
@pytest.mark.parametrize(("r", "reverses"), [(-0.1, True), (0.9, False), (1.1, True)])
def test_a_solution_that_reverses_the_sliding_says_so(
    r: float, reverses: bool, moment_equation: str
) -> None:
    """Beyond the critical mu friction turns round the sliding that there would be without it."""
    bodies = Bodies(1857.0, 1778.0, 3374.0, 3007.0, 1.636, 0.653, 0.205, 2.079, -0.155)
    before, e, e_m = jnp.array([-20.1, 6.0, 0.3, 18.9, -3.6, -0.8]), 0.1, 0.7
    acts_as = e_m if moment_equation == "corrected" else printed_e_m(e_m)
    mu = float(r * critical_mu(before, bodies, e, acts_as))
    after, smooth = (
        separation(before, bodies, Coefficients(e, mu, e_m), moment_equation) for mu in (mu, 0.0)
    )
    names, values = [*NAMES[:3], *NAMES[6:12]], [*before[:3], *after]
    known = dict(zip(names, map(float, values), strict=True))
    found = solve(known, bodies, moment_equation=moment_equation)
    assert found.values["mu"] == pytest.approx(mu)
    assert found.reverses_sliding == reverses
    tangent = np.array([-math.sin(bodies.Gamma), math.cos(bodies.Gamma)])
    slides = [float(contact_velocity(v, bodies) @ tangent) for v in (after, smooth)]
    assert (slides[0] * slides[1] < 0) == (r > 1)


def test_no_closing_speed_leaves_e_without_meaning() -> None:
    _, bodies = collision(np.random.default_rng(5))
    known = dict.fromkeys(NAMES, 0.0) | {"v_ax": 3.0, "v_bx": 3.0, "V_ax": 3.0}
    with pytest.raises(NotDetermined, match=r"\be\b.*mu") as problem:
        solve(known, bodies, ["v_by", "omega_b", "V_bx", "e", "mu", "e_m"])
    assert set(problem.value.trade_off) == {"e", "mu", "e_m"}


def test_a_barrier_does_not_determine_what_hit_it() -> None:
    bodies = against_barrier(1500.0, 2600.0, 0.4, 1.8, 0.2)
    before = jnp.array([-15.0, 2.0, 0.4, 0.0, 0.0, 0.0])
    after = separation(before, bodies, Coefficients(0.1, 0.3, 0.8))
    true = dict(zip(NAMES, [*map(float, before), *map(float, after), 0.1, 0.3, 0.8], strict=True))
    for unknown in (NAMES[6:12], (*NAMES[3:6], *COEFFICIENTS), (*NAMES[:3], *NAMES[9:12])):
        found = solve(true, bodies, unknown)
        assert found.values == pytest.approx(true, rel=1e-12, abs=1e-12)
    # between two vehicles B's change of motion would give A's velocities; a barrier's is nil
    with pytest.raises(NotDetermined) as problem:
        solve(true, bodies, (*NAMES[:3], *COEFFICIENTS))
    assert problem.value.rank == 3
    assert set(problem.value.trade_off) == {*NAMES[:3], *COEFFICIENTS}


@pytest.mark.parametrize(
    ("change", "unknown", "says"),
    [
        ({}, NAMES[:5], "5 quantities are unknown; six must be: leave out 1 more of omega_b, V_ax"),
        ({}, NAMES[:8], "give a value to 2 of v_ax, v_ay"),
        ({}, (*NAMES[:5], "E"), "'E' is none of"),
        ({}, (*NAMES[:5], "omega_B"), "did you mean omega_b"),
        ({"V_bx": math.nan}, NAMES[:6], r"V_bx is nan: give a finite number \(m/s\)"),
        ({"Omega_b": "fast"}, NAMES[:6], r"Omega_b is 'fast': give a finite number \(rad/s\)"),
    ],
)
def test_bad_questions_are_refused(change: dict, unknown: tuple, says: str) -> None:
    true, bodies = collision(np.random.default_rng(5))
    with pytest.raises(ValueError, match=says):
        solve(true | change, bodies, unknown)


def test_what_is_neither_known_nor_unknown_is_named() -> None:
    true, bodies = collision(np.random.default_rng(5))
    del true["V_by"]
    with pytest.raises(ValueError, match="neither known nor unknown: V_by; give"):
        solve(true, bodies, NAMES[:6])


def test_unknowns_may_be_one_text() -> None:
    true, bodies = collision(np.random.default_rng(5))
    assert solve(true, bodies, "v_bx, v_by omega_b e mu e_m").values == pytest.approx(true)


def test_two_infinite_bodies_are_refused() -> None:
    true, bodies = collision(np.random.default_rng(5))
    with pytest.raises(ValueError, match="must be finite"):
        solve(true, bodies._replace(m_a=math.inf, m_b=math.inf), NAMES[:6])
