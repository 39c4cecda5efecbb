"""Impacts at random over wide ranges, each held against the laws and a second implementation.

The second implementation is Newton's laws and eqs 22-24 as nine linear equations in the velocities
after, P_n, P_t and M, solved by NumPy: no algebra of retrodict's is in it.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import numpy as np

from retrodict.mechanics import (
    Bodies,
    Coefficients,
    approach_and_coefficients,
    critical_mu,
    severity,
)

TOLERANCE = 1e-12  # of the terms that a law adds up

Array = np.ndarray


class Impacts(NamedTuple):
    """Impacts, a row each."""

    approach: Array
    bodies: Bodies
    coefficients: Coefficients


class Found(NamedTuple):
    """What is wrong with each impact, and what retrodict says of it.

    Args:
        faults: by law, how far it is broken over what rounding of its terms allows; above 1 is wrong.
        flags: by name, whether raised.
        odd: by name, whether so by NumPy's reckoning: what ought to be flagged.
    """

    faults: dict[str, Array]
    flags: dict[str, Array]
    odd: dict[str, Array]


def draw(number: int, seed: int = 0) -> Impacts:
    """Impacts as wild as a scene file may ask for, and wilder.

    Args:
        number: of them.
        seed: of the random numbers.

    Returns:
        Masses from 50 kg to 100 t, some B a barrier; arms to 6 m; speeds to 60 m/s and spins to
        20 rad/s, some of them zero; a tenth graze; coefficients to their ends; mu up to twice its
        critical value, or anything from -2 to 2.
    """
    rng = np.random.default_rng(seed)

    def sometimes(share: float, special: Array | float, usual: Array) -> Array:
        return np.where(rng.random(number) < share, special, usual)

    m = np.exp(rng.uniform(np.log(50), np.log(1e5), (2, number)))
    inertia = m * rng.uniform(0.3, 3, (2, number)) ** 2
    barrier = rng.random(number) < 0.1
    m[1], inertia[1] = np.where(barrier, np.inf, m[1]), np.where(barrier, np.inf, inertia[1])
    arms = rng.uniform(-6, 6, (4, number))
    before = rng.uniform(-60, 60, (6, number))
    before[[2, 5]] *= 1 / 3
    for i in range(6):
        before[i] = sometimes(0.1, 0.0, before[i])
    before[3:] = np.where(barrier, 0.0, before[3:])
    d1, d2, d3, d4 = arms
    slip_x = before[0] + d3 * before[2] - before[3] + d1 * before[5]
    slip_y = before[1] - d4 * before[2] - before[4] - d2 * before[5]
    near = 10.0 ** rng.uniform(-9, 0, number)
    grazing = np.arctan2(slip_y, slip_x) - np.pi / 2 + near
    Gamma = sometimes(0.1, grazing, rng.uniform(-np.pi, np.pi, number))
    bodies = Bodies(m[0], m[1], inertia[0], inertia[1], d1, d2, d3, d4, Gamma)
    e = sometimes(0.1, rng.integers(0, 2, number), rng.uniform(0, 1, number))
    e_m = sometimes(0.1, rng.integers(-1, 2, number), rng.uniform(-1, 1, number))
    critical = np.asarray(jax.jit(jax.vmap(critical_mu))(before.T, bodies, e, e_m))
    mu = np.where(np.isfinite(critical), critical, 0.0) * rng.uniform(0, 2, number)
    mu = sometimes(0.3, rng.uniform(-2, 2, number), np.clip(mu, -10, 10))
    return Impacts(before.T, bodies, Coefficients(e, mu, e_m))


def solved(impacts: Impacts) -> tuple[Array, Array]:
    """Velocities after and (P_n, P_t, M) by the second implementation, and the condition of each."""
    v, (m_a, m_b, I_a, I_b, d1, d2, d3, d4, G), (e, mu, e_m) = impacts
    c, s = np.cos(G), np.sin(G)
    n = len(v)
    A, right = np.zeros((n, 9, 9)), np.zeros((n, 9))
    for i in range(6):
        A[:, i, i] = 1.0
    right[:, :6] = v
    # P = P_n n + P_t t at (-d4, -d3) from A and -P at (d2, d1) from B; moment x P_y - y P_x
    for column, (P_x, P_y) in enumerate(((c, s), (-s, c)), start=6):
        A[:, 0, column], A[:, 1, column] = -P_x / m_a, -P_y / m_a
        A[:, 2, column] = -(-d4 * P_y + d3 * P_x) / I_a
        A[:, 3, column], A[:, 4, column] = P_x / m_b, P_y / m_b
        A[:, 5, column] = (d2 * P_y - d1 * P_x) / I_b
    A[:, 2, 8], A[:, 5, 8] = -1 / I_a, 1 / I_b
    normal = np.stack([c, s, d3 * c - d4 * s, -c, -s, d1 * c - d2 * s], axis=1)
    A[:, 6, :6], right[:, 6] = normal, -e * (normal * v).sum(1)  # eq 22
    A[:, 7, 7], A[:, 7, 6] = 1.0, -mu  # eq 23
    # eq 24: what the force alone would leave is the spin after less M's share
    A[:, 8, 5], A[:, 8, 2] = 1 - e_m, e_m - 1
    A[:, 8, 8] = -e_m * (1 / I_a + 1 / I_b)
    # impulses in units that give the lighter body a metre a second: the condition is then of velocities
    scale = np.ones((n, 9))
    scale[:, 6:8] = np.minimum(m_a, m_b)[:, None]
    scale[:, 8] = np.minimum(I_a, I_b)
    A = A * scale[:, None, :]
    A[:, 7] /= np.maximum(1.0, np.abs(mu))[:, None] * scale[:, 6:7]
    x = np.linalg.solve(A, right[..., None])[..., 0]
    return x * scale, np.linalg.cond(A)


def examine(impacts: Impacts) -> Found:
    """Run retrodict's impact both ways and hold it against the laws and the second implementation.

    Args:
        impacts: as `draw` makes them.

    Returns:
        What was found.
    """
    v, bodies, c = impacts
    audit = jax.jit(jax.vmap(severity))(*impacts, np.zeros((len(v), 2)))
    V = np.asarray(audit.after)
    inverse = jax.jit(jax.vmap(approach_and_coefficients))(V, v[:, :3], bodies)
    expected, condition = solved(impacts)
    scale = np.maximum(np.abs(v).max(1), np.abs(expected[:, :6]).max(1))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        faults = _laws(impacts, V) | _inverse(
            impacts, V, *map(np.asarray, inverse[0].T), *inverse[1]
        )
        for law in ("eq 22", "inverse: e"):  # spins by force and by moment may cancel
            faults[law] /= condition
        faults["second implementation"] = np.abs(V - expected[:, :6]).max(1) / (
            TOLERANCE * condition * scale
        )
        before, after = _energy(v, bodies), _energy(V, bodies)
        works = np.array([audit.energy.normal, audit.energy.tangential, audit.energy.moment])
        terms = np.abs(works).sum(0) + before + after
        faults["energy audit"] = np.abs(works.sum(0) - (after - before)) / (TOLERANCE * terms)
    faults["finite"] = np.where(np.isfinite(V).all(1), 0.0, np.inf)
    pushed = np.minimum(bodies.m_a, bodies.m_b) * scale**2
    smooth = _sliding(impacts._replace(coefficients=c._replace(mu=0 * c.mu)))
    left = _sliding(impacts)
    sure = np.abs(left) > 1e-6 * np.abs(smooth)
    return Found(
        faults={k: np.where(np.isnan(f), np.inf, f) for k, f in faults.items()},
        flags={
            "gains energy": np.asarray(audit.gains_energy),
            "reverses sliding": np.asarray(audit.reverses_sliding),
            "pulls": np.asarray(audit.pulls),
        },
        odd={
            "gains energy": after - before > 1e-9 * terms,
            "reverses sliding": sure & (left * smooth < 0),
            "pulls": expected[:, 6] * (_normal(bodies) * v).sum(1) > 1e-9 * pushed,
        },
    )


def _normal(bodies: Bodies) -> Array:
    """What of six velocities is normal contact velocity, a row each."""
    d1, d2, d3, d4, G = bodies[4:]
    c, s = np.cos(G), np.sin(G)
    return np.stack([c, s, d3 * c - d4 * s, -c, -s, d1 * c - d2 * s], axis=1)


def _laws(impacts: Impacts, V: Array) -> dict[str, Array]:
    """Eqs 19-24 in velocities before and after, each over the rounding of its terms."""
    v, (m_a, m_b, I_a, I_b, d1, d2, d3, d4, G), (e, mu, e_m) = impacts
    change, size = V - v, np.abs(V) + np.abs(v)
    still = np.isinf(m_b)  # a barrier takes any momentum
    zero = np.zeros_like(m_a)

    def broken(terms: list[Array], of: Array = change, sizes: Array = size) -> Array:
        rows = np.stack([np.broadcast_to(t, m_a.shape) for t in terms], axis=1)
        return np.abs((rows * of).sum(1)) / (TOLERANCE * (np.abs(rows) * sizes).sum(1) + 1e-300)

    ratio, spins = m_a / m_b, I_a / I_b
    momentum_x = broken([ratio, zero, zero, zero + 1, zero, zero])
    momentum_y = broken([zero, ratio, zero, zero, zero + 1, zero])
    # about the impact centre, over I_b
    by_b = np.where(still, 0.0, m_b) / I_b
    spin = broken([-d3 * m_a / I_b, d4 * m_a / I_b, spins, d1 * by_b, -d2 * by_b, zero + 1])
    normal, c, s = _normal(impacts.bodies), np.cos(G), np.sin(G)
    restitution = np.abs((normal * (V + e[:, None] * v)).sum(1)) / (
        TOLERANCE * (np.abs(normal) * size).sum(1) + 1e-300
    )
    friction = broken([-s - mu * c, c - mu * s, zero, zero, zero, zero])
    # eq 24: f_a and f_b from A's change of motion
    arm_x, arm_y = m_a * (d1 / I_b - d3 / I_a), m_a * (-d2 / I_b + d4 / I_a)
    kept = V[:, 5] - V[:, 2]
    free = v[:, 5] - v[:, 2] + arm_x * change[:, 0] + arm_y * change[:, 1]
    rounding = size[:, 5] + size[:, 2] + np.abs(arm_x) * size[:, 0] + np.abs(arm_y) * size[:, 1]
    return {
        "momentum": np.where(still, 0.0, np.maximum(momentum_x, momentum_y)),
        "angular momentum": np.where(still, 0.0, spin),
        "eq 22": restitution,
        "eq 23": friction,
        "eq 24": np.abs(kept - e_m * free) / (TOLERANCE * rounding + 1e-300),
    }


def _inverse(
    impacts: Impacts,
    V: Array,
    v_bx: Array,
    v_by: Array,
    w_b: Array,
    e: Array,
    mu: Array,
    e_m: Array,
) -> dict[str, Array]:
    """What the inverse finds, against what went in; a quotient as far as its divisor is known."""
    v, (m_a, m_b, I_a, I_b, d1, d2, d3, d4, G), c = impacts
    size = np.abs(V) + np.abs(v)
    ratio = m_a / m_b
    known_x, known_y = (ratio * size[:, i] + size[:, i + 3] for i in (0, 1))
    by_a = m_a / I_b * (np.abs(d1) + np.abs(d3) + np.abs(d2) + np.abs(d4))
    known_w = I_a / I_b * size[:, 2] + size[:, 5] + by_a * (size[:, 0] + size[:, 1])
    gaps = np.abs(np.stack([v_bx, v_by, w_b], axis=1) - v[:, 3:])
    approach = gaps / (TOLERANCE * np.stack([known_x, known_y, known_w], axis=1) + 1e-300)
    normal = np.abs(_normal(impacts.bodies))
    sizes = np.column_stack([size[:, :3], known_x, known_y, known_w])
    closing = np.abs((_normal(impacts.bodies) * v).sum(1))
    change = V - v
    P_n = m_a * np.abs(change[:, 0] * np.cos(G) + change[:, 1] * np.sin(G))
    arm_x, arm_y = m_a * (d1 / I_b - d3 / I_a), m_a * (-d2 / I_b + d4 / I_a)
    free = np.abs(v[:, 5] - v[:, 2] + arm_x * change[:, 0] + arm_y * change[:, 1])
    spins = known_w + size[:, 2] + size[:, 5]
    spins += np.abs(arm_x) * size[:, 0] + np.abs(arm_y) * size[:, 1]

    def quotient(found: Array, true: Array, known: Array, divisor: Array) -> Array:
        blur = TOLERANCE * known / divisor
        # a divisor lost in rounding determines nothing: `solve` refuses it by name
        gap = np.abs(found - true) / (blur * (1 + np.abs(true)))
        return np.where(blur < 1e-3, gap, 0.0)

    return {
        "inverse: approach of B": approach.max(1),
        "inverse: e": quotient(e, c.e, (normal * sizes).sum(1), closing),
        "inverse: mu": quotient(mu, c.mu, m_a * (size[:, 0] + size[:, 1]), P_n),
        "inverse: e_m": quotient(e_m, c.e_m, spins, free),
    }


def _energy(state: Array, bodies: Bodies) -> Array:
    """Kinetic energy, J; none of a barrier that stands still."""
    m_a, m_b, I_a, I_b = bodies[:4]
    masses = np.stack([m_a, m_a, I_a, m_b, m_b, I_b], axis=1)
    return np.asarray((np.where(np.isinf(masses), 0.0, masses) * state**2).sum(1) / 2)


def _sliding(impacts: Impacts) -> Array:
    """Tangential contact velocity after, over the normal impulse, by the second implementation."""
    _, bodies, _ = impacts
    d1, d2, d3, d4, G = bodies[4:]
    c, s = np.cos(G), np.sin(G)
    tangent = np.stack([-s, c, -d3 * s - d4 * c, s, -c, -d1 * s - d2 * c], axis=1)
    x, _ = solved(impacts)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((tangent * x[:, :6]).sum(1) / x[:, 6])
