"""Any six of the fifteen quantities of eqs 19-24 from the other nine.

No iteration is needed, whichever six: e stands in eq 22 alone, mu in eq 23 alone and e_m in eq 24
alone, and everything else is linear in the velocities. Leave out the equation of each unknown
coefficient, and as many linear equations remain as there are unknown velocities; each left-out
equation then gives its coefficient in one step. So there is one solution, or the choice of unknowns
does not determine any.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from retrodict.mechanics.contact import Bodies, axes, contact_velocity
from retrodict.mechanics.impact import (
    Coefficients,
    MomentEquation,
    _force_moments,
    _is_printed,
    printed_e_m,
)
from retrodict.mechanics.severity import reverses_sliding

NAMES = (
    "v_ax", "v_ay", "omega_a", "v_bx", "v_by", "omega_b",
    "V_ax", "V_ay", "Omega_a", "V_bx", "V_by", "Omega_b",
    "e", "mu", "e_m",
)  # fmt: skip
ROW_OF = {12: 3, 13: 4, 14: 5}  # the one equation in which each coefficient stands
SINGULAR = 1e-10  # of the scaled Jacobian: nine knowns exact to 1e-10 would not determine a tenth


class NotDetermined(ValueError):
    """Eqs 19-24 do not determine the unknowns.

    Args:
        rank: rank of the 6 x 6 Jacobian of eqs 19-24 in the unknowns.
        trade_off: the unknowns that can change together, or alone, without breaking an equation.
        contradicts: whether the known values moreover contradict one another.
    """

    def __init__(self, rank: int, trade_off: tuple[str, ...], contradicts: bool) -> None:
        self.rank, self.trade_off, self.contradicts = rank, trade_off, contradicts
        free = "can trade off" if trade_off[1:] else "has no effect"
        also = "; moreover the known values contradict one another" if contradicts else ""
        of_these = "one of these" if trade_off[1:] else "it"
        super().__init__(
            f"eqs 19-24 determine {rank} of 6 unknowns: {', '.join(trade_off)} {free}{also}; give "
            f"{of_these} a value, and take another quantity for unknown in its place"
        )


@dataclass(frozen=True)
class Solution:
    """All fifteen quantities.

    Args:
        values: value of each quantity by name, m/s, rad/s and coefficients.
        residual: the largest misfit of eqs 19-24, over the largest velocity.
        condition: condition number of the scaled Jacobian: factor by which a relative error may grow.
        reverses_sliding: whether mu exceeds its critical value or has the other sign.
    """

    values: dict[str, float]
    residual: float
    condition: float
    reverses_sliding: bool


def solve(
    known: Mapping[str, float],
    bodies: Bodies,
    unknown: Iterable[str] | str | None = None,
    moment_equation: MomentEquation = "corrected",
) -> Solution:
    """Any six of the fifteen quantities of eqs 19-24 from the other nine.

    Args:
        known: values by name, m/s, rad/s and coefficients. Names are v_ax, v_ay, omega_a, v_bx,
            v_by, omega_b before, V_ax, V_ay, Omega_a, V_bx, V_by, Omega_b after, e, mu, e_m.
        bodies: masses, inertias, lever arms and Gamma; one body's mass and inertia may be infinite.
        unknown: the six to solve for, names in a list or in one text; by default those not in
            `known`, and what `known` says of them is disregarded.
        moment_equation: eq 24 "corrected" or "as-printed".

    Returns:
        The solution, of which there is one.

    Raises:
        NotDetermined: the unknowns are not determined; says the rank and which trade off.
        ValueError: names or their number are wrong, a known value is no finite number, or both bodies
            are infinite; the message says what to give.

    Source:
        SAE 770014, eqs 19-24, eqs 21 and 24 corrected.
    """
    free = _indices_of_unknowns(known, unknown)
    values = np.array([0.0 if i in free else _number(known, name) for i, name in enumerate(NAMES)])
    row, column = _scales(bodies)

    def linearise(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        misfit, jacobian = _linearise(values, bodies, moment_equation)
        return np.asarray(misfit) / row, np.asarray(jacobian) * column / row[:, None]

    velocities = [i for i in free if i < 12]
    coefficients = [i for i in free if i >= 12]
    rows = [r for r in range(6) if r not in [ROW_OF[i] for i in coefficients]]
    # where a family of velocities fits, go on with a member in general position: on a special one a
    # coefficient could lose its meaning besides
    largest = np.abs(values[:12] / column[:12]).max() or 1.0
    values[velocities] = (largest * np.cos(np.arange(15)) * column)[velocities]
    misfit, jacobian = linearise(values)
    steps = np.linalg.lstsq(jacobian[np.ix_(rows, velocities)], -misfit[rows], rcond=SINGULAR)[0]
    values[velocities] += steps * column[velocities]

    misfit, jacobian = linearise(values)
    speed = np.abs(values[:12] / column[:12]).max() or 1.0
    for i in coefficients:
        divisor = jacobian[ROW_OF[i], i]
        # one that vanishes leaves the coefficient at 0 and its column empty, to be refused below
        values[i] = -misfit[ROW_OF[i]] / divisor if abs(divisor) > SINGULAR * speed else 0.0

    misfit, jacobian = linearise(values)
    condition = _require_rank(jacobian[:, free], misfit, [NAMES[i] for i in free], speed)
    return Solution(
        values=dict(zip(NAMES, values.tolist(), strict=True)),
        residual=float(np.abs(misfit).max() / speed),
        condition=condition,
        reverses_sliding=bool(_reverses(values, bodies, moment_equation)),
    )


def _indices_of_unknowns(
    known: Mapping[str, float], unknown: Iterable[str] | str | None
) -> list[int]:
    if isinstance(unknown, str):
        unknown = unknown.replace(",", " ").split()
    names = set(NAMES) - set(known) if unknown is None else set(unknown)
    for name in sorted((names | set(known)) - set(NAMES)):
        close = get_close_matches(name, NAMES, 1)
        meant = f"; did you mean {close[0]}?" if close else ""
        raise ValueError(f"{name!r} is none of {', '.join(NAMES)}{meant}")
    if missing := set(NAMES) - set(known) - names:
        raise ValueError(f"neither known nor unknown: {_listed(missing)}; give each a value")
    if len(names) > 6:
        raise ValueError(
            f"{len(names)} quantities are unknown, and six equations determine six: give a value to "
            f"{len(names) - 6} of {_listed(names)}"
        )
    if len(names) < 6:
        raise ValueError(
            f"{len(names)} quantities are unknown; six must be: leave out {6 - len(names)} more of "
            f"{_listed(set(NAMES) - names)}, or name the six with unknown="
        )
    return [i for i, name in enumerate(NAMES) if name in names]


def _listed(names: Iterable[str]) -> str:
    """Names in the order of `NAMES`."""
    return ", ".join(sorted(names, key=NAMES.index))


def _number(known: Mapping[str, float], name: str) -> float:
    try:
        value = float(known[name])
    except (TypeError, ValueError):
        value = np.nan
    if not np.isfinite(value):
        unit = "rad/s" if "mega" in name else "m/s" if name in NAMES[:12] else "no unit"
        raise ValueError(f"{name} is {known[name]!r}: give a finite number ({unit})")
    return value


def _scales(bodies: Bodies) -> tuple[np.ndarray, np.ndarray]:
    """Scales of each equation's residual and each unknown, so that all are speeds (m/s).

    A spin counts with the radius of gyration of the reduced mass and inertia.
    """
    m_a, m_b, I_a, I_b = (float(b) for b in bodies[:4])
    if min(m_a, m_b) == np.inf or min(I_a, I_b) == np.inf:
        raise ValueError("one of the two masses and one of the two inertias must be finite")
    length = np.sqrt((1 / m_a + 1 / m_b) / (1 / I_a + 1 / I_b))
    row = np.where(np.isin(range(6), (2, 5)), 1 / length, 1.0)
    column = np.where(np.isin(range(15), (2, 5, 8, 11)), 1 / length, 1.0)
    return row, column


def _require_rank(
    jacobian: np.ndarray, misfit: np.ndarray, names: list[str], speed: float
) -> float:
    """The condition number of a regular Jacobian (coefficients scaled by their effect over speed)."""
    weight = np.array([1 / speed if name in NAMES[12:] else 1.0 for name in names])
    left, sizes, right = np.linalg.svd(jacobian * weight)
    rank = int((sizes > SINGULAR * sizes[0]).sum())
    if rank < 6:
        moves = np.abs(right[rank:]).max(axis=0) > SINGULAR
        trade_off = tuple(name for name, some in zip(names, moves, strict=True) if some)
        contradicts = np.abs(left[:, rank:].T @ misfit).max() > np.sqrt(SINGULAR) * speed
        raise NotDetermined(rank, trade_off, bool(contradicts))
    return float(sizes[0] / sizes[-1])


def _residuals(
    values: Float[Array, "15"], bodies: Bodies, moment_equation: MomentEquation
) -> Float[Array, "6"]:
    """Eqs 19-24 as misfits, m/s and rad/s: divided by masses and inertias, one of which may be inf."""
    m_a, m_b, I_a, I_b = bodies[:4]
    before, after, (e, mu, e_m) = values[:6], values[6:12], values[12:]
    change = after - before
    share_of_a = (1 / m_b) / (1 / m_a + 1 / m_b)  # m_a / (m_a + m_b)
    momentum = share_of_a * change[:2] + (1 - share_of_a) * change[3:5]  # eqs 19, 20
    P = (change[:2] - change[3:5]) / (1 / m_a + 1 / m_b)  # eqs 9-14, whichever body is infinite
    f_a, f_b = _force_moments(P, bodies)
    spin_share = (1 / I_b) / (1 / I_a + 1 / I_b)
    both = (1 / I_a) * spin_share  # 1 / (I_a + I_b)
    spins = spin_share * change[2] + (1 - spin_share) * change[5] - both * (f_a + f_b)  # eq 21
    normal, tangent = axes(bodies)
    opening, closing = (contact_velocity(state, bodies) @ normal for state in (after, before))
    restitution = opening + e * closing  # eq 22
    per_mass = P * (1 / m_a + 1 / m_b)
    friction = per_mass @ tangent - mu * (per_mass @ normal)  # eq 23
    spin = after[5] - after[2]
    free_spin = (before[5] + f_b / I_b) - (before[2] + f_a / I_a)
    kept = (2 * e_m - 1) * spin if _is_printed(moment_equation) else spin
    moment = kept - e_m * free_spin  # eq 24
    return jnp.stack([*momentum, spins, restitution, friction, moment])


@partial(jax.jit, static_argnames="moment_equation")
def _reverses(
    values: Float[Array, "15"], bodies: Bodies, moment_equation: MomentEquation
) -> Bool[Array, ""]:
    e, mu, e_m = values[12:]
    kept = printed_e_m(e_m) if _is_printed(moment_equation) else e_m
    return reverses_sliding(values[:6], bodies, Coefficients(e, mu, kept))


@partial(jax.jit, static_argnames="moment_equation")
def _linearise(
    values: Float[Array, "15"], bodies: Bodies, moment_equation: MomentEquation
) -> tuple[Float[Array, "6"], Float[Array, "6 15"]]:
    residuals = partial(_residuals, bodies=bodies, moment_equation=moment_equation)
    return residuals(values), jax.jacfwd(residuals)(values)
