"""Motion from impact to rest of a vehicle that skids and yaws on four wheels, locked or rolling.

The clock is not time but the generalised speed W = sqrt(Vx² + Vy² + k² Omega²). Sliding friction
only ever lowers W, so every run has the same number of steps, ends exactly at rest, and needs
neither an event nor a regularised stop, each of which distorts the rest pose or its gradient.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from retrodict.mechanics.rotation import cos_sin
from retrodict.mechanics.surface import NO_ZONES, Coefficients, Insets, Polygon, Zone, friction
from retrodict.mechanics.tyre import SLIP, SLOW, Wheels, force

GRAVITY = 9.80665  # m/s²

# A locked tyre's contact patch has a size: under spin some of it slips even when its middle does
# not. Slip of the patch is sqrt(v² + (PATCH Omega)²), so friction turns smoothly where a wheel is
# the instant centre, and vanishes with the motion, unlike a fixed smoothing speed.
PATCH = 0.08  # m, radius of gyration of a contact patch of about 0.2 m by 0.18 m

ROWS = 96  # of a path, at steps as the run-out takes them
_TOLERANCE = 1e-9  # of adaptive steps: what derivatives need to be exact to 1e-4 (measured)
MOST_STEPS = 32768  # of them: on ice at 0.05, sixty turns took 3700, about one locked wheel 13400
_MOST_FIXED = 3072
# Of W: from here to rest in closed form, for at W = 0 friction has no direction. Adaptive steps go
# further, to `_STANDS` at most: a rolling car's motion still turns in its last centimetres a second
# (measured), and below that its tyres hold so little to the side that it would hardly lose W.
_LAST_FIXED, _LAST_ADAPTIVE = 1e-3, 1e-5
_ABOVE_CREEP = (
    3.0  # of the speed of a rolling car's creep across a slope: from here to rest likewise
)
_TINY = 1e-18  # m²/s²: a wheel that is the instant centre of a motion without spin
_STANDS = 1e-4  # m/s: what is slower is taken at this, to rest in closed form: derivatives exist
# W falls as (1 - s)^0.85 over the steps: the exponent with the least error, measured
_CLUSTER = 0.85

# Of paced steps, least error at equal cost (measured): share of the time in which friction would end
# a wheel's slip, where much of it is left and where it is near its balance; of a radian; of the time
# to a stop. Slip counts as near its balance below a tangent of `_BALANCED` times SLIP.
_OF_SLIP, _OF_BALANCE, _OF_TURN, _OF_STOP, _BALANCED = 0.5, 2.2, 0.1, 0.3, 0.15
_MOST_PACED = 6000  # of them: a car that rolls 700 m on the least drag takes 1100

Pose = Float[Array, "3"]  # x, y, heading: m, rad
Velocity = Float[Array, "3"]  # Vx, Vy, Omega: m/s, rad/s
ThreeNumbers = Float[Array | np.ndarray, "3"] | Sequence[float]  # either, as it may be given


class Car(NamedTuple):
    """The properties of a vehicle that its run-out depends on.

    Args:
        k2: yaw inertia over mass, m².
        front_axle: centre of gravity to front axle, m.
        rear_axle: centre of gravity to rear axle, m.
        track: between the wheels of an axle, m.
        wheels: how they turn; None where all four are locked. Rolling wheels dissipate little, so
            clock W runs stiff: steps in time, placed by the motion (`Paced`), follow it.
        height: of the centre of gravity, m, where load moves to the wheels that brake the most; None
            for static loads. Where a wheel lifts there is no rest pose; sideways transfer is shared
            between the axles as they share the weight.
    """

    k2: Float[Array, ""] | float
    front_axle: Float[Array, ""] | float
    rear_axle: Float[Array, ""] | float
    track: Float[Array, ""] | float
    wheels: Wheels | None = None
    height: Float[Array, ""] | float | None = None


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
        speed_dependence: c, s/m, of f exp(-c v), likewise; None where f does not depend on speed.
        zones: half-planes.
        polygons: corners of each, m, shape (corners, 2).
        insets: how far each polygon's outline lies inwards of its corners, m.
        incline: None where it is level. A motion to which it adds more energy than friction takes has
            no rest pose.
    """

    coefficients: Coefficients
    speed_dependence: Coefficients | None = None
    zones: Zone = NO_ZONES
    polygons: tuple[Polygon, ...] = ()
    insets: Insets = 0.0
    incline: Incline | None = None

    @property
    def surfaces(self) -> tuple[Any, ...]:
        """What `surface.friction` takes: all but the incline."""
        return self[:-1]


class Steps(NamedTuple):
    """A number of fixed steps as an argument of a compiled program, which then takes any number.

    No derivatives in reverse mode; `fixed_steps` makes it.

    Args:
        number: of the steps.
        lengths: lost share of W of each, then zeros.
    """

    number: Int[Array | np.ndarray, ""]
    lengths: Float[Array | np.ndarray, " most"]


class Paced(NamedTuple):
    """Time steps whose lengths adapt to the motion: for vehicles with rolling wheels.

    The lateral slip of a rolling tyre relaxes to equilibrium at a rate that limits a step of order
    four (above 2.8 over the rate it is unstable, and its derivatives even more so). That rate, and those
    of turning and stopping, are known in closed form along the path.

    No derivatives in reverse mode.

    Args:
        fineness: how many times shorter than `_OF_SLIP`, `_OF_BALANCE`, `_OF_TURN` and `_OF_STOP` say.
    """

    fineness: Float[Array | np.ndarray, ""] | float = 1.0


class Path(NamedTuple):
    """A run-out, one row a step: poses, velocities and the time of each."""

    pose: Float[Array, "steps 3"]
    velocity: Float[Array, "steps 3"]
    time: Float[Array, " steps"]

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {np.shape(value)}" for name, value in self._asdict().items())
        return f"<Path: {shapes}>"


def fixed_steps(count: int) -> Steps:
    """`count` fixed steps for `rest`, 1 to 3072."""
    if not 0 < count <= _MOST_FIXED:
        raise ValueError(f"steps are 1 to {_MOST_FIXED}; not {count}")
    lengths = np.diff(_levels(count, _LAST_FIXED))
    return Steps(np.array(count), np.pad(lengths, (0, _MOST_FIXED - count)))


def rest(
    pose: ThreeNumbers,
    velocity: ThreeNumbers,
    car: Car,
    ground: Ground,
    steps: int | Steps | Paced | None = None,
) -> Pose:
    """The rest pose of a skidding vehicle.

    Args:
        pose: x, y, heading at the start, m and rad; single precision is computed in double.
        velocity: Vx, Vy, Omega at the start, m/s and rad/s.
        car: inertia, axles and track.
        ground: friction of the surfaces and where they lie.
        steps: None for as many as it takes, of order eight (diffrax), with derivatives in reverse
            mode only; or a number, of order four, which compiles and runs several times faster, more
            so in batches, with the error that `step_error` estimates; or such a number as an
            argument of a compiled program; or `Paced` steps for a rolling vehicle.

    Returns:
        x, y and heading at rest; the heading is not wrapped, so turns can be counted. NaN
        where the integration did not reach rest.

    Raises:
        TypeError: differentiated in forward mode without a number of steps; the message says what to
            do. Where it is compiled first, as in `jax.jacfwd(jax.jit(rest))`, JAX's own is raised.

    Source:
        Rigid body on four wheels in the spirit of Ellis, Vehicle Dynamics (1969), which
        SAE 770014 cites for its run-out.
    """
    start = _start(pose, velocity)
    if isinstance(steps, Paced):
        return jnp.stack(_paced(start, car, ground, steps, rows=1)[1][:3])
    last = _last(steps, start, car, ground)
    if steps is None:
        end = tuple(v[-1] for v in _adaptive(start, car, ground, last, rows=1))
    else:
        end, _ = _fixed(start, car, ground, steps, last, keep=False)
    return jnp.stack(_halt(end, start, car, ground, last)[:3])


def step_error(
    pose: ThreeNumbers, velocity: ThreeNumbers, car: Car, ground: Ground, steps: int
) -> Pose:
    """Estimated error of a rest pose by fixed steps: its change when the number of steps is doubled.

    It detects all but one in fifty of the rest poses with errors above 1 cm (docs/atlas.md).

    Args:
        pose: as in `rest`, and so are velocity, car and ground.
        velocity: at the start, m/s and rad/s.
        car: inertia, axles and track.
        ground: friction of the surfaces and where they lie.
        steps: a number that `rest` is given.

    Returns:
        The absolute error of x, y and heading, m and rad; costs three times the run-out itself.
    """
    few, twice = (rest(pose, velocity, car, ground, n) for n in (steps, 2 * steps))
    return jnp.abs(twice - few)


def run_out(
    pose: ThreeNumbers,
    velocity: ThreeNumbers,
    car: Car,
    ground: Ground,
    steps: int | Paced | None = None,
) -> Path:
    """The whole run-out of a skidding vehicle, from its start to rest; arguments as in `rest`."""
    start = _start(pose, velocity)
    if isinstance(steps, Paced):
        states, halt = _paced(start, car, ground, steps, rows=ROWS)
    else:
        last = _last(steps, start, car, ground)
        if steps is None:
            states = _adaptive(start, car, ground, last, rows=ROWS)
        else:
            _, states = _fixed(start, car, ground, steps, last, keep=True)
        halt = _halt(tuple(v[-1] for v in states), start, car, ground, last)
    rows = [
        jnp.concatenate([first[None], between, end[None]])
        for first, between, end in zip(start, states, halt, strict=True)
    ]
    return Path(jnp.stack(rows[:3], axis=1), jnp.stack(rows[3:6], axis=1), rows[6])


def wheel_paths(
    pose: Float[Array | np.ndarray, "*any 3"] | Sequence[float], car: Car
) -> Float[Array, "*any 4 2"]:
    """Wheel positions (front left, front right, rear left, rear right), as skid marks show them.

    Args:
        pose: of the centre of gravity, as of `Path`, m and rad.
        car: its axles and track.

    Returns:
        x and y of each wheel, m.
    """
    pose = jnp.asarray(pose)
    u, v = wheel_places(car)
    c, s = (a[..., None] for a in cos_sin(pose[..., 2]))
    arms = jnp.stack([c * u - s * v, s * u + c * v], axis=-1)
    return pose[..., None, :2] + arms


# x, y, heading, Vx, Vy, Omega, time: apart and not in one array, so that batches of each vectorise
State = tuple[Float[Array, "*any"], ...]


def _start(pose: ThreeNumbers, velocity: ThreeNumbers) -> State:
    """Initial state in double precision; a vehicle at rest is given the speed `_STANDS`."""
    pose, velocity = jnp.asarray(pose, float), jnp.asarray(velocity, float)
    stands = (velocity**2).sum() <= _STANDS**2
    velocity = jnp.where(stands, jnp.array([_STANDS, 0.0, 0.0]), velocity)
    return (*pose, *velocity, jnp.zeros(()))


def _last(
    steps: int | Steps | Paced | None, start: State, car: Car, ground: Ground
) -> Float[Array, ""] | float:
    """Share of W from which a run-out is closed."""
    creeps = ground.incline is not None and car.wheels is not None
    if steps is not None and not creeps:
        return _LAST_FIXED
    # where it is closed is no property of the motion: derivatives are those at this share
    W_0 = jax.lax.stop_gradient(_speed(start[3:6], car.k2))
    last = jnp.clip(_STANDS / W_0, _LAST_ADAPTIVE, 1.0) if steps is None else _LAST_FIXED
    if ground.incline is None or not creeps:
        return last
    # Across a slope rolling tyres, whose sideways force fades below SLOW, creep downhill at about this
    # speed, where the model's W would fall no further.
    creep = SLIP * SLOW * jnp.abs(ground.incline.grade) / jnp.min(jnp.asarray(ground.coefficients))
    above = jax.lax.stop_gradient(_ABOVE_CREEP * creep) / W_0
    return jnp.clip(above, last, 1.0)


def _levels(
    steps: int, last: Float[Array, ""] | float
) -> Float[np.ndarray, " levels"] | Float[Array, " levels"]:
    """Lost shares of W after each of so many steps, from none to all but the last of it."""
    return (1 - last) * (1 - (1 - np.linspace(0.0, 1.0, steps + 1)) ** _CLUSTER)


def _fixed(
    start: State,
    car: Car,
    ground: Ground,
    steps: int | Steps,
    last: Float[Array, ""] | float,
    keep: bool,
) -> tuple[State, State]:
    """Runge-Kutta steps of order four, with the lost share of W as the independent variable.

    The scan runs over stages, not steps: with one slope in its body, the program with its gradient
    compiles six times faster than with four, and runs faster too (measured on two cores).

    Returns:
        The last state, and where kept the state after each step.
    """
    rate = _slope_of_loss(start, car, ground)
    ahead = jnp.array([0.5, 0.5, 1.0, 1.0])  # of a step: where a stage's slope is next taken to
    share = jnp.array([1.0, 2.0, 2.0, 1.0]) / 6  # and what it counts for

    Carry = tuple[State, State, State]
    Weights = tuple[Array, Array, Array]

    def weights(lengths: Array, which: Array) -> Weights:
        return lengths * ahead[which], lengths * share[which], which == 3

    def stage(carry: Carry, weights: Weights) -> tuple[Carry, State | None]:
        y, y_stage, y_sum = carry  # at the step's start, at this stage, summed so far
        ahead, share, last = weights
        k = rate(y_stage)
        y_sum = tuple(a + share * b for a, b in zip(y_sum, k, strict=True))
        next_stage = (a + ahead * b for a, b in zip(y, k, strict=True))
        y_stage = tuple(jnp.where(last, a, b) for a, b in zip(y_sum, next_stage, strict=True))
        y = tuple(jnp.where(last, a, b) for a, b in zip(y_sum, y, strict=True))
        return (y, y_stage, y_sum), y if keep else None

    # steps are made for `_LAST_FIXED`; 1 exactly where the run-out is closed there
    shorter = (1 - last) / (1 - _LAST_FIXED)
    if isinstance(steps, Steps):
        lengths = shorter * jnp.asarray(steps.lengths)
        end, _, _ = jax.lax.fori_loop(
            0,
            4 * jnp.asarray(steps.number),
            lambda i, carry: stage(carry, weights(lengths[i // 4], i % 4))[0],
            (start, start, start),
        )
        return end, ()
    lengths = shorter * jnp.asarray(np.repeat(np.diff(_levels(steps, _LAST_FIXED)), 4))
    # in reverse a stage is computed anew from its start: a quarter faster than keeping all of it, and
    # in a seventeenth of the memory (measured)
    (end, _, _), states = jax.lax.scan(
        jax.checkpoint(stage, prevent_cse=False),
        (start, start, start),
        weights(lengths, jnp.arange(4 * steps) % 4),
    )
    return end, () if states is None else tuple(v[3::4] for v in states)


def _adaptive(
    start: State, car: Car, ground: Ground, last: Float[Array, ""] | float, rows: int
) -> State:
    """States at the ends of the fixed steps, by adaptive steps of order eight."""
    import diffrax  # takes a second to import; inference does not need it

    levels = _levels(rows, last)[1:]
    rate = _slope_of_loss(start, car, ground)
    W_0 = _speed(start[3:6], car.k2)
    try:
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(lambda _, state, args: rate(state)),
            diffrax.Dopri8(),
            0.0,
            levels[-1],
            1e-3,
            start,
            saveat=diffrax.SaveAt(ts=jnp.asarray(levels[:-1]), t1=True),
            stepsize_controller=diffrax.PIDController(rtol=_TOLERANCE, atol=0.1 * _TOLERANCE * W_0),
            # every step kept: with fewer checkpoints derivatives came out wrong by up to a tenth
            adjoint=diffrax.RecursiveCheckpointAdjoint(checkpoints=MOST_STEPS),
            max_steps=MOST_STEPS,
            throw=False,
        )
    except TypeError as error:
        if "forward-mode" not in str(error):
            raise
        raise TypeError(
            "a run-out by adaptive steps has derivatives in reverse mode only: take jax.jacrev or "
            "jax.grad in place of jax.jacfwd, jax.jvp or jax.hessian, or give a number of steps, such "
            "as steps=200, which has both"
        ) from None
    arrived = solution.result == diffrax.RESULTS.successful
    return tuple(jnp.where(arrived, v, jnp.nan) for v in solution.ys)


def _paced(start: State, car: Car, ground: Ground, steps: Paced, rows: int) -> tuple[State, State]:
    """Runge-Kutta steps of order four in time, each as long as the motion at its start allows.

    Returns:
        States, of which each is the first to have lost as much of W as so many fixed steps lose; and
        the vehicle at rest. Not numbers where the motion took too many steps.
    """
    by_W, longest = slope(car, ground), _longest_step(car, ground)
    W_0 = _speed(start[3:6], car.k2)
    Carry = tuple[State, Int[Array, ""]]

    def rate(state: State) -> tuple[State, Array]:
        """d(state)/dt, and dW/dt."""
        slopes = by_W(state)
        return tuple(k / slopes[6] for k in slopes), 1 / slopes[6]

    def along(state: State, slopes: State, time: Array) -> State:
        return tuple(a + time * b for a, b in zip(state, slopes, strict=True))

    def step(carry: Carry, W: Array) -> Carry:
        state, count = carry
        first, dW = rate(state)
        # a little beyond the next level, so that rows lie where they are asked for
        beyond = 1.2 * (W - _speed(state[3:6], car.k2)) / dW
        h = jax.lax.stop_gradient(jnp.minimum(longest(state, dW) / steps.fineness, beyond))
        second = rate(along(state, first, h / 2))[0]
        third = rate(along(state, second, h / 2))[0]
        last = rate(along(state, third, h))[0]
        slopes = (first, second, third, last)
        mean = (a / 6 + b / 3 + c / 3 + d / 6 for a, b, c, d in zip(*slopes, strict=True))
        return along(state, tuple(mean), h), count + 1

    def to_level(carry: Carry, W: Array) -> tuple[Carry, State]:
        def above(carry: Carry) -> Array:
            return (_speed(carry[0][3:6], car.k2) > W) & (carry[1] < _MOST_PACED)

        carry = jax.lax.while_loop(above, lambda carry: step(carry, W), carry)
        return carry, carry[0]

    levels = W_0 * (1 - jnp.asarray(_levels(rows, _last(steps, start, car, ground)))[1:])
    (end, count), states = jax.lax.scan(to_level, (start, jnp.zeros((), int)), levels)
    slopes, dW = rate(end)
    left = -_speed(end[3:6], car.k2) / dW  # until rest, if it slows down evenly
    moved = (a + left / 2 * b for a, b in zip(end[:3], slopes[:3], strict=True))
    halt = (*moved, *(jnp.zeros_like(left),) * 3, end[6] + left)
    return states, tuple(jnp.where(count < _MOST_PACED, v, jnp.nan) for v in halt)


def _longest_step(car: Car, ground: Ground) -> Callable[[State, Array], Array]:
    """Largest time step at a state with this dW/dt, s."""
    wheel_u, wheel_v = wheel_places(car)
    assert car.wheels is not None, "only where a wheel rolls do steps have to be paced"
    steer, drag = cos_sin(jnp.asarray(car.wheels.steer)), jnp.asarray(car.wheels.drag)
    # friction times how much of it a rolling wheel has for sideways forces; in yaw it acts on k²
    grip = GRAVITY * jnp.asarray(ground.coefficients).max()
    grip *= jnp.sqrt(jnp.clip(1 - drag**2, 0.0))
    grip *= jnp.maximum(1.0, car.front_axle * car.rear_axle / car.k2)

    def longest(state: State, dW: Array) -> Array:
        _, _, heading, Vx, Vy, Omega, _ = state
        c, s = cos_sin(heading)
        u, v = c * Vx + s * Vy - Omega * wheel_v, c * Vy - s * Vx + Omega * wheel_u
        ahead, across = steer[0] * u + steer[1] * v, steer[0] * v - steer[1] * u
        soft2 = SLIP**2 * (ahead**2 + SLOW**2)
        rate = grip / jnp.sqrt(across**2 + soft2)  # at which slip goes
        near = 1 / (1 + across**2 / (_BALANCED**2 * soft2))
        per_time = rate / (_OF_SLIP + (_OF_BALANCE - _OF_SLIP) * near)
        stop = -dW / _speed((Vx, Vy, Omega), car.k2)
        turn = jnp.abs(Omega)
        return 1 / jnp.maximum(per_time.max(), jnp.maximum(turn / _OF_TURN, stop / _OF_STOP))

    return longest


def _halt(
    end: State, start: State, car: Car, ground: Ground, last: Float[Array, ""] | float
) -> State:
    """State at rest: the last of the motion keeps its direction while W falls linearly to zero."""
    left = [last * k for k in _slope_of_loss(start, car, ground)(end)]
    moved = (a + b / 2 for a, b in zip(end[:3], left[:3], strict=True))
    return (*moved, *(jnp.zeros_like(end[0]),) * 3, end[6] + left[6])


def _slope_of_loss(start: State, car: Car, ground: Ground) -> Callable[[State], State]:
    """d(state)/d(lost share of W)."""
    rate, W_0 = slope(car, ground), _speed(start[3:6], car.k2)
    return lambda state: tuple(-W_0 * k for k in rate(state))


def _speed(
    velocity: Velocity | tuple[Array, ...], k2: Float[Array, ""] | float
) -> Float[Array, ""]:
    """Generalised speed W, m/s."""
    return jnp.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + k2 * velocity[2] ** 2)


def slope(car: Car, ground: Ground) -> Callable[[State], State]:
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
        dt_dW = _speed((Vx, Vy, Omega), car.k2) / power
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


def wheel_loads(car: Car) -> Float[Array, "4"]:
    """Static load of each wheel over the vehicle's weight."""
    wheelbase = car.front_axle + car.rear_axle
    front, rear = car.rear_axle / wheelbase / 2, car.front_axle / wheelbase / 2
    return jnp.stack([front, front, rear, rear])


def wheel_places(car: Car) -> tuple[Float[Array, "4"], Float[Array, "4"]]:
    """Wheel positions ahead and to the left of the centre of gravity, m."""
    ahead = jnp.stack([car.front_axle, car.front_axle, -car.rear_axle, -car.rear_axle])
    return ahead, jnp.array([0.5, -0.5, 0.5, -0.5]) * car.track


def _moved(
    load: Float[Array, "4"],
    share: Float[Array, "4"],
    car: Car,
    along: Float[Array, "4"],
    across: Float[Array, "4"],
) -> Float[Array, "4"]:
    """Wheel loads with load transfer: two linear equations in the deceleration."""
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
