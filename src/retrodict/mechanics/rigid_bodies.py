"""SAE 770014's first example (eqs 1-8): two bodies circle into one another and hit head on.

Each travels on a circle, so it both moves and spins, and they meet along the line of their motion
(y). A central force impulse alone leaves both spins as they were: even with e = 0 the bodies would
turn through one another about the point of contact. Surfaces that hold on to one another carry a
moment besides, and e_m says how much relative spin survives it.
"""

from __future__ import annotations

from typing import NamedTuple

from jaxtyping import Array, Float

Scalar = Float[Array, ""] | float


class CentralImpact(NamedTuple):
    """Velocities after (m/s, rad/s), force impulse P_y (N s) and moment impulse M (N m s).

    As in the paper's Fig. 2, -P_y and -M act on A, +P_y and +M on B.
    """

    V_ay: Scalar
    Omega_a: Scalar
    V_by: Scalar
    Omega_b: Scalar
    P_y: Scalar
    M: Scalar


def central_impact(
    approach: tuple[Scalar, Scalar, Scalar, Scalar],
    masses: tuple[Scalar, Scalar],
    inertias: tuple[Scalar, Scalar],
    e: Scalar,
    e_m: Scalar = 1.0,
) -> CentralImpact:
    """The central impact of two spinning bodies, with the moment or (e_m = 1) without it.

    Args:
        approach: (v_ay, omega_a, v_by, omega_b) before, m/s and rad/s.
        masses: (m_a, m_b), kg.
        inertias: (I_a, I_b), kg m².
        e: restitution.
        e_m: impact moment coefficient: 1 no moment, 0 both turn together, -1 elastic rebound.

    Returns:
        Velocities after and the impulses.

    Source:
        SAE 770014, eqs 1, 2, 5, 6 and 7a; eqs 3 and 4 are the case e_m = 1.
    """
    v_ay, omega_a, v_by, omega_b = approach
    (m_a, m_b), (I_a, I_b) = masses, inertias
    P_y = (1 + e) * (v_ay - v_by) / (1 / m_a + 1 / m_b)  # eqs 1, 2 in 5
    M = (1 - e_m) * (omega_a - omega_b) / (1 / I_a + 1 / I_b)  # eq 6's two halves in 7a
    return CentralImpact(
        V_ay=v_ay - P_y / m_a,
        Omega_a=omega_a - M / I_a,
        V_by=v_by + P_y / m_b,
        Omega_b=omega_b + M / I_b,
        P_y=P_y,
        M=M,
    )
