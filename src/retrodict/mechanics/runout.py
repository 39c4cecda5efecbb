"""Motion from impact to rest of a vehicle that skids and yaws on four wheels, locked or rolling.

The clock is not time but the generalised speed W = sqrt(Vx² + Vy² + k² Omega²). Sliding friction
only ever lowers W, so every run has the same number of steps, ends exactly at rest, and needs
neither an event nor a regularised stop, each of which distorts the rest pose or its gradient.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.mechanics.surface import Zone, friction
from retrodict.mechanics.tyre import Wheels, force

GRAVITY = 9.80665  # m/s²

# A locked tyre's contact patch has a size: under spin some of it slips even when its middle does
# not. Slip of the patch is sqrt(v² + (PATCH Omega)²), so friction turns smoothly where a wheel is
# the instant centre, and vanishes with the motion, unlike a fixed smoothing speed.
PATCH = 0.08  # m, radius of gyration of a contact patch of about 0.2 m by 0.18 m

STEPS = 96
_LAST = 1e-3  # of W: from here to rest in closed form, for at W = 0 friction has no direction
_TINY = 1e-18  # m²/s²: a wheel that is the instant centre of a motion without spin
_STANDS = 1e-4  # m/s: what is slower is run at this, some nanometres, so that derivatives exist
_CLUSTER = (
    0.85  # W falls as (1 - s)^0.85 over the steps: the exponent with the least error, measured
)

Pose = Float[Array, "3"]  # x, y, heading: m, rad
Velocity = Float[Array, "3"]  # Vx, Vy, Omega: m/s, rad/s


class Car(NamedTuple):
    """What of a vehicle matters to its run-out.

    Args:
        k2: yaw inertia over mass, m².
        front_axle: centre of gravity to front axle, m.
        rear_axle: centre of gravity to rear axle, m.
        track: between the wheels of an axle, m.
        wheels: how they turn; None where all four are locked. Rolling wheels dissipate little, so
            the clock runs stiff: take some 50 steps over the least drag, or compare with twice as many.
    """

    k2: Float[Array, ""] | float
    front_axle: Float[Array, ""] | float
    rear_axle: Float[Array, ""] | float
    track: Float[Array, ""] | float
    wheels: Wheels | None = None


class Ground(NamedTuple):
    """Surfaces and their edges, as `surface.friction` takes them."""

    coefficients: Float[Array, " surfaces"]
    speed_dependence: Float[Array, " surfaces"] | None
    zones: Zone


class Path(NamedTuple):
    """A run-out, one row a step: poses, velocities and the time of each."""

    pose: Float[Array, "steps 3"]
    velocity: Float[Array, "steps 3"]
    time: Float[Array, " steps"]


def rest(pose: Pose, velocity: Velocity, car: Car, ground: Ground, steps: int = STEPS) -> Pose:
    """Where a skidding vehicle comes to rest.

    Args:
        pose: x, y, heading at the start, m and rad.
        velocity: Vx, Vy, Omega at the start, m/s and rad/s.
        car: inertia, axles and track.
        ground: friction of the surfaces and their edges.
        steps: of the integration.

    Returns:
        x, y and heading at rest; the heading is not wrapped, so turns can be counted.

    Source:
        Rigid body on four wheels with static axle loads, in the spirit of Ellis, Vehicle
        Dynamics (1969), which SAE 770014 cites for its run-out.
    """
    end, _ = _integrate(pose, velocity, car, ground, steps, keep=False)
    return end[:3]


def run_out(pose: Pose, velocity: Velocity, car: Car, ground: Ground, steps: int = STEPS) -> Path:
    """The whole run-out of a skidding vehicle, from its start to rest; arguments as in `rest`."""
    _, states = _integrate(pose, velocity, car, ground, steps, keep=True)
    assert states is not None
    return Path(states[:, :3], states[:, 3:6], states[:, 6])


def _integrate(
    pose: Pose, velocity: Velocity, car: Car, ground: Ground, steps: int, keep: bool
) -> tuple[Float[Array, "7"], Float[Array, "stages 7"] | None]:
    """Fixed Runge-Kutta steps of order four, with W as the independent variable.

    The scan runs over stages, not steps: with one slope in its body, the program with its gradient
    compiles six times faster than with four, and runs faster too (measured on two cores).
    """
    metric = jnp.stack([jnp.ones(()), jnp.ones(()), jnp.asarray(car.k2)])
    moves = (velocity**2 * metric).sum() > _STANDS**2
    velocity = jnp.where(moves, velocity, jnp.array([_STANDS, 0.0, 0.0]))
    W_0 = jnp.sqrt((velocity**2 * metric).sum())
    slope = _slope(car, ground, metric)
    levels = _LAST + (1 - _LAST) * (1 - np.linspace(0.0, 1.0, steps + 1)) ** _CLUSTER
    h = np.repeat(np.diff(levels), 4)
    ahead = h * np.tile([0.5, 0.5, 1.0, 1.0], steps)  # where the next stage looks
    share = h * np.tile([1.0, 2.0, 2.0, 1.0], steps) / 6  # of a stage in its step
    last = np.tile([False, False, False, True], steps)

    Carry = tuple[Float[Array, "7"], Float[Array, "7"], Float[Array, "7"]]

    def stage(carry: Carry, weights: tuple[Array, Array, Array]) -> tuple[Carry, Array | None]:
        y, y_stage, y_sum = carry  # at the step's start, at this stage, summed so far
        ahead, share, last = weights
        k = W_0 * slope(y_stage)
        y_sum = y_sum + share * k
        y_stage = jnp.where(last, y_sum, y + ahead * k)
        y = jnp.where(last, y_sum, y)
        return (y, y_stage, y_sum), y if keep else None

    start = jnp.concatenate([pose, velocity, jnp.zeros(1)])
    (end, _, _), states = jax.lax.scan(
        stage, (start, start, start), (jnp.asarray(ahead), jnp.asarray(share), jnp.asarray(last))
    )
    # what is left of the motion keeps its direction: W falls evenly to nothing, and with it V, Omega
    left = -_LAST * W_0 * slope(end)
    halt = jnp.concatenate([end[:3] + left[:3] / 2, jnp.zeros(3), end[6:] + left[6:]])
    if states is None:
        return halt, None
    return halt, jnp.concatenate([start[None], states[3:-1:4], halt[None]])


def _slope(
    car: Car, ground: Ground, metric: Float[Array, "3"]
) -> Callable[[Float[Array, "7"]], Float[Array, "7"]]:
    """d(x, y, heading, Vx, Vy, Omega, t)/dW."""
    wheel_x = jnp.stack([car.front_axle, car.front_axle, -car.rear_axle, -car.rear_axle])
    wheel_y = jnp.array([0.5, -0.5, 0.5, -0.5]) * car.track
    wheelbase = car.front_axle + car.rear_axle
    front, rear = car.rear_axle / wheelbase / 2, car.front_axle / wheelbase / 2
    load = GRAVITY * jnp.stack([front, front, rear, rear])  # static, per unit of vehicle mass

    def slope(y: Float[Array, "7"]) -> Float[Array, "7"]:
        c, s = jnp.cos(y[2]), jnp.sin(y[2])
        arm_x, arm_y = c * wheel_x - s * wheel_y, s * wheel_x + c * wheel_y
        slip_x, slip_y = y[3] - y[5] * arm_y, y[4] + y[5] * arm_x
        slip = jnp.sqrt(slip_x**2 + slip_y**2 + (PATCH * y[5]) ** 2 + _TINY)
        position = jnp.stack([y[0] + arm_x, y[1] + arm_y], axis=1)
        grip = friction(position, slip, *ground) * load
        if car.wheels is None:
            force_x, force_y = -grip / slip * slip_x, -grip / slip * slip_y
        else:
            patch2 = (PATCH * y[5]) ** 2 + _TINY
            force_x, force_y = grip * force(jnp.stack([slip_x, slip_y]), patch2, y[2], car.wheels)
        spin = arm_x * force_y - arm_y * force_x
        acceleration = jnp.stack([force_x.sum(), force_y.sum(), spin.sum() / car.k2])
        motion = y[3:6]
        W = jnp.sqrt((motion**2 * metric).sum())
        dW_dt = (motion * metric * acceleration).sum() / W
        return jnp.concatenate([motion, acceleration, jnp.ones(1)]) / dW_dt

    return slope
