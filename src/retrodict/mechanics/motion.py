"""The equations of motion of a vehicle on four wheels, with the generalised speed W as clock.

W = sqrt(Vx² + Vy² + k² Omega²). Sliding friction only ever lowers W.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.constants import GRAVITY
from retrodict.mechanics.rotation import cos_sin
from retrodict.mechanics.surface import NO_ZONES, Coefficients, Insets, Polygon, Zone, friction
from retrodict.mechanics.tyre import Wheels, force

# A locked tyre's contact patch has a size: under spin some of it slips even when its middle does
# not. Slip of the patch is sqrt(v² + (PATCH Omega)²), so friction turns smoothly where a wheel is
# the instant centre, and vanishes with the motion, unlike a fixed smoothing speed.
PATCH = 0.08  # m, radius of gyration of a contact patch of about 0.2 m by 0.18 m

_TINY = 1e-18  # m²/s²: a wheel that is the instant centre of a motion without spin

Pose = Float[Array, "3"]  # x, y, heading: m, rad
Velocity = Float[Array, "3"]  # Vx, Vy, Omega: m/s, rad/s
ThreeNumbers = Float[Array | np.ndarray, "3"] | Sequence[float]  # either, as it may be given
# x, y, heading, Vx, Vy, Omega, time: apart and not in one array, so that batches of each vectorise
State = tuple[Float[Array, "*any"], ...]


class Car(NamedTuple):
    """The properties of a vehicle that its run-out depends on.

    Args:
        k2: yaw inertia over mass, m².
        front_axle: distance from the centre of gravity to the front axle, m.
        rear_axle: distance from the centre of gravity to the rear axle, m.
        track: distance between the wheels of an axle, m.
        wheels: drag and steer of the wheels; None where all four are locked. Rolling wheels dissipate
            little, so clock W runs stiff: steps in time, placed by the motion (`Paced`), follow it.
        height: height of the centre of gravity, m, for load transfer to the wheels that brake the most;
            None for static loads. Where a wheel lifts there is no rest pose; sideways transfer is
            shared between the axles as they share the weight.
    """

    k2: Float[Array, ""] | float
    front_axle: Float[Array, ""] | float
    rear_axle: Float[Array, ""] | float
    track: Float[Array, ""] | float
    wheels: Wheels | None = None
    height: Float[Array, ""] | float | None = None


class Joined(NamedTuple):
    """Several vehicles joined to one body, on the wheels of all.

    Args:
        k2: yaw inertia over mass, m².
        ahead: place of each wheel ahead of the common centre of gravity, m.
        left: and to the left of it, m.
        load: static load of each wheel over the body's weight, times the grip of its tyre.
        wheels: drag and steer of the wheels; None where all are locked.
        height: None: loads are static.
    """

    k2: Float[Array, ""] | float
    ahead: Float[Array, " wheels"]
    left: Float[Array, " wheels"]
    load: Float[Array, " wheels"]
    wheels: Wheels | None = None
    height: None = None


class Incline(NamedTuple):
    """A constant slope of the whole ground; places and headings are counted in its plane.

    Args:
        grade: rise over run.
        uphill: direction in which the ground rises, counter-clockwise from the x axis, rad.
    """

    grade: Float[Array, ""] | float
    uphill: Float[Array, ""] | float


class Ground(NamedTuple):
    """Surfaces and where they lie, as `surface.friction` takes them; `Ground(0.7)` is one everywhere.

    Args:
        coefficients: friction f of the surface that lies everywhere, then of each zone, then of each
            polygon; a number where there is no other.
        speed_dependence: c of f exp(-c v), s/m, for the same surfaces; None where f does not depend on
            speed.
        zones: half-planes with a friction of their own.
        polygons: corners of each polygon, m, shape (corners, 2).
        insets: distance of each polygon's outline inwards of its corners, m.
        incline: slope of the ground; None where it is level. A motion to which the slope adds more
            energy than friction takes has no rest pose.
    """

    coefficients: Coefficients
    speed_dependence: Coefficients | None = None
    zones: Zone = NO_ZONES
    polygons: tuple[Polygon, ...] = ()
    insets: Insets = 0.0
    incline: Incline | None = None

    @property
    def surfaces(self) -> tuple[Any, ...]:
        """Arguments of `surface.friction`: all fields but the incline."""
        return self[:-1]


def generalised_speed(
    velocity: Velocity | tuple[Array, ...], k2: Float[Array, ""] | float
) -> Float[Array, ""]:
    """Generalised speed W, m/s."""
    return jnp.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + k2 * velocity[2] ** 2)


def vector_field(car: Car | Joined, ground: Ground) -> Callable[[State], State]:
    """d(x, y, heading, Vx, Vy, Omega, time)/dW as a function of these.

    W has to fall, for all is divided by dW/dt; on a slope of angle theta it does where friction takes
    more than gravity adds, which is at most g sin(theta) |V|. Of locked wheels friction takes the sum of
    f load |slip|, at least f_least g cos(theta) times the size of the slips' mean weighted by load. With
    static loads that mean is V, so tan(theta) < f_least is enough. A wheel that rolls ahead counts with
    its drag times f. Where W would rise all of this is not a number.
    """
    wheel_u, wheel_v = wheel_places(car)
    down_x, down_y, normal = _gravity(ground.incline)
    share = wheel_loads(car)
    load = normal * share  # static, per unit of vehicle mass

    def rate(state: State) -> State:
        x, y, heading, Vx, Vy, Omega, _ = state
        c, s = cos_sin(heading)
        # forces along (u) and across (v) the vehicle, where the wheels stay put
        slip_u = c * Vx + s * Vy - Omega * wheel_v
        slip_v = c * Vy - s * Vx + Omega * wheel_u
        patch2 = (PATCH * Omega) ** 2 + _TINY
        slip = jnp.sqrt(slip_u**2 + slip_v**2 + patch2)
        wheel_x, wheel_y = x + c * wheel_u - s * wheel_v, y + s * wheel_u + c * wheel_v
        grip = friction(wheel_x, wheel_y, slip, *ground.surfaces)
        if car.wheels is None:
            along, across = -grip / slip * slip_u, -grip / slip * slip_v
        else:
            along, across = grip * force(jnp.stack([slip_u, slip_v]), patch2, car.wheels)
        on_wheel = load if car.height is None else _moved(load, share, car, along, across)
        force_u, force_v = along * on_wheel, across * on_wheel
        A_u, A_v = force_u.sum(), force_v.sum()
        A_x, A_y = c * A_u - s * A_v, s * A_u + c * A_v
        if ground.incline is not None:  # at the centre of gravity: it moves no load
            A_x, A_y = A_x + down_x, A_y + down_y
        moment = (wheel_u * force_v - wheel_v * force_u).sum()
        # k² drops out of Omega k² dOmega/dt
        power = Vx * A_x + Vy * A_y + Omega * moment
        if ground.incline is not None:
            power = jnp.where(power < 0, power, jnp.nan)
        dt_dW = generalised_speed((Vx, Vy, Omega), car.k2) / power
        rates = (Vx, Vy, Omega, A_x, A_y, moment / car.k2, jnp.ones_like(x))
        return tuple(r * dt_dW for r in rates)

    return rate


def _gravity(incline: Incline | None) -> tuple[Array | float, Array | float, Array | float]:
    """Acceleration by gravity along the ground, x and y, and against it, m/s²."""
    if incline is None:
        return 0.0, 0.0, GRAVITY
    normal = GRAVITY / jnp.sqrt(1 + jnp.square(incline.grade))
    c, s = cos_sin(jnp.asarray(incline.uphill, float))
    return -normal * incline.grade * c, -normal * incline.grade * s, normal


def wheel_loads(car: Car | Joined) -> Float[Array, " wheels"]:
    """Static load of each wheel over the vehicle's weight."""
    if isinstance(car, Joined):
        return car.load
    wheelbase = car.front_axle + car.rear_axle
    front, rear = car.rear_axle / wheelbase / 2, car.front_axle / wheelbase / 2
    return jnp.stack([front, front, rear, rear])


def wheel_places(car: Car | Joined) -> tuple[Float[Array, " wheels"], Float[Array, " wheels"]]:
    """Wheel positions ahead and to the left of the centre of gravity, m."""
    if isinstance(car, Joined):
        return car.ahead, car.left
    ahead = jnp.stack([car.front_axle, car.front_axle, -car.rear_axle, -car.rear_axle])
    return ahead, jnp.array([0.5, -0.5, 0.5, -0.5]) * car.track


def yaw_arm2(car: Car | Joined) -> Float[Array, ""] | float:
    """Square of the lever with which tyres turn the vehicle, m²."""
    if isinstance(car, Joined):
        return jnp.max(car.ahead**2 + car.left**2)
    return car.front_axle * car.rear_axle


def _moved(
    load: Float[Array, "4"],
    share: Float[Array, "4"],
    car: Car | Joined,
    along: Float[Array, "4"],
    across: Float[Array, "4"],
) -> Float[Array, "4"]:
    """Wheel loads with load transfer: two linear equations in the deceleration."""
    assert isinstance(car, Car), "joined bodies have static loads"
    assert car.height is not None
    by_u = car.height / (car.front_axle + car.rear_axle) / 2 * jnp.array([-1.0, -1.0, 1.0, 1.0])
    by_v = 2 * car.height / car.track * share * jnp.array([-1.0, 1.0, -1.0, 1.0])
    a, b, c = (along * load).sum(), (along * by_u).sum(), (along * by_v).sum()
    d, e, f = (across * load).sum(), (across * by_u).sum(), (across * by_v).sum()
    # A_u = a + b A_u + c A_v, A_v = d + e A_u + f A_v
    whole = (1 - b) * (1 - f) - c * e
    A_u, A_v = (a * (1 - f) + c * d) / whole, (d * (1 - b) + e * a) / whole
    moved = load + by_u * A_u + by_v * A_v
    # the model ends where a wheel lifts
    return jnp.where((moved >= 0).all(), moved, jnp.nan)
