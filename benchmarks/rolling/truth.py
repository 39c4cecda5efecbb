"""What really happens in a synthetic crash: NumPy and SciPy, without JAX or `retrodict.mechanics`.

The impact is a linear system (SAE 770014, eqs 19-24 with the two corrections of docs/model.md). The
run-out is that of `tests.shared.reference`: a rigid body on four wheels, followed over time by DOP853
at a tolerance of 1e-12 until a millionth of the motion is left.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tests.shared import reference

Array = np.ndarray[Any, np.dtype[Any]]


class Impact(NamedTuple):
    """Two bodies and the line along which they touch; A's row first.

    Args:
        mass: kg, shape (2,).
        inertia: in yaw, kg m², shape (2,).
        lever: from each centre of gravity to the impact centre, in the road's axes, m, shape (2, 2).
        Gamma: angle of the contact line from the y axis, rad.
    """

    mass: Array
    inertia: Array
    lever: Array
    Gamma: float


def separation(before: Array, impact: Impact, e: float, mu: float, e_m: float) -> Array:
    """Velocities after the impact: six linear equations in six velocities.

    Args:
        before: Vx, Vy, yaw rate of A, then of B, m/s and rad/s, shape (6,).
        impact: the bodies.
        e: restitution.
        mu: tangential over normal impulse.
        e_m: share of the relative spin left by the force impulse that survives the moment.

    Returns:
        The same after the impact.

    Source:
        SAE 770014, eqs 19-24; eqs 21 and 24 as corrected in docs/model.md.
    """
    P_a, normal, tangent = _impulse_on_a(impact), *_axes(impact)
    friction = (tangent - mu * normal) @ P_a  # eq 23: P_t - mu P_n = 0
    return _solve(before, impact, e, e_m, friction, float(friction @ before))


def critical_mu(before: Array, impact: Impact, e: float, e_m: float) -> float:
    """The mu at which the sliding along the contact line just ends; arguments as in `separation`."""
    P_a, (normal, tangent) = _impulse_on_a(impact), _axes(impact)
    change = P_a @ (_solve(before, impact, e, e_m, tangent @ _slip(impact), 0.0) - before)
    return float((tangent @ change) / (normal @ change))


def closing_speed(before: Array, impact: Impact) -> float:
    """How fast the vehicles come together along the normal, m/s; negative where they part."""
    normal = _axes(impact)[0]
    from_a, from_b = impact.lever / np.linalg.norm(impact.lever, axis=1, keepdims=True)
    sense = np.sign(normal @ (from_a - from_b))  # the normal has none of its own; from A to B
    return float(sense * (normal @ _slip(impact) @ before))


def energy(velocity: Array, impact: Impact) -> float:
    """Kinetic energy of both bodies, J."""
    inertia = np.stack([impact.mass, impact.mass, impact.inertia], axis=1).ravel()
    return float(inertia @ velocity**2 / 2)


def _axes(impact: Impact) -> tuple[Array, Array]:
    """Normal and tangent of the contact line."""
    c, s = np.cos(impact.Gamma), np.sin(impact.Gamma)
    return np.array([c, s]), np.array([-s, c])


def _impulse_on_a(impact: Impact) -> Array:
    """The force impulse on A from changes of the six velocities, N s, shape (2, 6)."""
    return impact.mass[0] * np.eye(2, 6)


def _slip(impact: Impact) -> Array:
    """A's impact centre's velocity over B's from the six velocities, shape (2, 6)."""
    (a_x, a_y), (b_x, b_y) = impact.lever
    return np.array([[1, 0, -a_y, -1, 0, b_y], [0, 1, a_x, 0, -1, -b_x]])


def _solve(
    before: Array, impact: Impact, e: float, e_m: float, tangential: Array, value: float
) -> Array:
    """Eqs 19-22 and 24, with `tangential` @ after = value in the place of eq 23."""
    (m_a, m_b), (I_a, I_b), (lever_a, lever_b) = impact.mass, impact.inertia, impact.lever
    P_a, normal = _impulse_on_a(impact), _axes(impact)[0]

    def moment(lever: Array) -> Array:
        """Of the force impulse on A about a point that far from the impact centre."""
        return lever[0] * P_a[1] - lever[1] * P_a[0]

    momentum = np.array([[m_a, 0, 0, m_b, 0, 0], [0, m_a, 0, 0, m_b, 0]])  # eqs 19, 20
    angular = np.array([0, 0, I_a, 0, 0, I_b]) - moment(lever_a - lever_b)  # eq 21
    opening = normal @ _slip(impact)  # eq 22: times -e after
    spin = np.array([0.0, 0, -1, 0, 0, 1])
    # eq 24: spin after = e_m (spin before + what the force impulse alone makes of it)
    by_force = -moment(lever_b) / I_b - moment(lever_a) / I_a
    kept = spin - e_m * by_force
    rows = np.stack([*momentum, angular, opening, tangential, kept])
    values = [
        *(momentum @ before),
        angular @ before,
        -e * (opening @ before),
        value,
        e_m * ((spin - by_force) @ before),
    ]
    return np.linalg.solve(rows, np.array(values))


class Car(NamedTuple):
    """A car on its four wheels, front left, front right, rear left, rear right.

    Args:
        k2: yaw inertia over mass, m².
        front: centre of gravity to front axle, m.
        rear: to rear axle, m.
        track: m.
        drag: of each wheel, braking force over the available friction; 1 is locked.
        steer: of the front wheels from the heading, rad.
    """

    k2: float
    front: float
    rear: float
    track: float
    drag: Array
    steer: float


def path(pose: Array, velocity: Array, car: Car, friction: float) -> Array:
    """Poses of a car from the impact to rest, as close together as the solver's steps.

    Args:
        pose: x, y, heading at the start, m and rad.
        velocity: Vx, Vy, yaw rate at the start, m/s and rad/s.
        car: the car.
        friction: of the road.

    Returns:
        x, y and heading, unwrapped, shape (poses, 3); the last row is the rest pose.
    """
    scene = reference.Scene(
        pose=pose,
        velocity=velocity,
        k2=car.k2,
        front_axle=car.front,
        rear_axle=car.rear,
        track=car.track,
        coefficients=np.full(2, friction),  # the same beyond the edge: there is none
        speed_dependence=np.zeros(2),
        point=np.zeros(2),
        inward=np.array([1.0, 0.0]),
        drag=car.drag,
        steer=car.steer * np.array([1.0, 1.0, 0.0, 0.0]),
    )
    rest, states, _ = reference.solve(scene)
    return np.vstack([states[:, :3], rest])


def way(poses: Array) -> Array:
    """Length of the path of the centre of gravity up to each pose, m."""
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T)))
