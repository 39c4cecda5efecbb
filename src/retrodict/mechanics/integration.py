"""Integration of a run-out: fixed or adaptive steps of W, and steps in time where wheels roll."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from retrodict.constants import GRAVITY
from retrodict.mechanics.motion import (
    Car,
    Ground,
    Joined,
    State,
    generalised_speed,
    vector_field,
    wheel_places,
    yaw_arm2,
)
from retrodict.mechanics.rotation import cos_sin
from retrodict.mechanics.tyre import SLIP, SLOW

_TOLERANCE = 1e-9  # of adaptive steps: what derivatives need to be exact to 1e-4 (measured)
MOST_STEPS = 32768  # of them: on ice at 0.05, sixty turns took 3700, about one locked wheel 13400
_MOST_FIXED = 3072
# Share of W from which on the motion to rest is in closed form: at W = 0 friction has no direction.
# Adaptive steps go further, to `STANDS` at most: a rolling car's motion still turns in its last
# centimetres a second (measured), and below that its tyres hold so little to the side that it would
# hardly lose W.
_LAST_FIXED, _LAST_ADAPTIVE = 1e-3, 1e-5
_ABOVE_CREEP = (
    3.0  # times the speed of a rolling car's creep across a slope: from here to rest in closed form
)
STANDS = 1e-4  # m/s: what is slower is taken at this, to rest in closed form: derivatives exist
# W falls as (1 - s)^0.85 over the steps: the exponent with the least error, measured
_CLUSTER = 0.85

# Of paced steps, least error at equal cost (measured): share of the time in which friction would end
# a wheel's slip, where much of it is left and where it is near its balance; of a radian; of the time
# to a stop. Slip counts as near its balance below a tangent of `_BALANCED` times SLIP.
_OF_SLIP, _OF_BALANCE, _OF_TURN, _OF_STOP, _BALANCED = 0.5, 2.2, 0.1, 0.3, 0.15
_MOST_PACED = 6000  # of them: a car that rolls 700 m on the least drag takes 1100


class Steps(NamedTuple):
    """A number of fixed steps as an argument of a compiled program, which then takes any number.

    It has no derivatives in reverse mode; `fixed_steps` makes it.

    Args:
        number: number of steps.
        lengths: share of the initial W lost in each step, padded with zeros.
    """

    number: Int[Array | np.ndarray, ""]
    lengths: Float[Array | np.ndarray, " most"]


class Paced(NamedTuple):
    """Time steps whose lengths adapt to the motion: for vehicles with rolling wheels.

    The lateral slip of a rolling tyre relaxes to equilibrium at a rate that limits a step of order
    four (above 2.8 over the rate it is unstable, and its derivatives even more so). That rate, and those
    of turning and stopping, are known in closed form along the path.

    They have no derivatives in reverse mode.

    Args:
        fineness: factor by which steps are shorter than `_OF_SLIP`, `_OF_BALANCE`, `_OF_TURN` and
            `_OF_STOP` say.
    """

    fineness: Float[Array | np.ndarray, ""] | float = 1.0


def fixed_steps(count: int) -> Steps:
    """`count` fixed steps for `rest`, 1 to 3072."""
    if not 0 < count <= _MOST_FIXED:
        raise ValueError(f"steps are 1 to {_MOST_FIXED}; not {count}")
    lengths = np.diff(_lost_shares(count, _LAST_FIXED))
    return Steps(np.array(count), np.pad(lengths, (0, _MOST_FIXED - count)))


def _lost_shares(
    steps: int, last: Float[Array, ""] | float
) -> Float[np.ndarray, " shares"] | Float[Array, " shares"]:
    """Lost shares of W after each of so many steps, from none to all but the last of it."""
    return (1 - last) * (1 - (1 - np.linspace(0.0, 1.0, steps + 1)) ** _CLUSTER)


def closing_share(
    steps: int | Steps | Paced | None, start: State, car: Car | Joined, ground: Ground
) -> Float[Array, ""] | float:
    """Share of W from which a run-out is closed."""
    creeps = ground.incline is not None and car.wheels is not None
    if steps is not None and not creeps:
        return _LAST_FIXED
    # where it is closed is no property of the motion: derivatives are those at this share
    W_0 = jax.lax.stop_gradient(generalised_speed(start[3:6], car.k2))
    last = jnp.clip(STANDS / W_0, _LAST_ADAPTIVE, 1.0) if steps is None else _LAST_FIXED
    if ground.incline is None or not creeps:
        return last
    # Across a slope rolling tyres, whose sideways force fades below SLOW, creep downhill at about this
    # speed, where the model's W would fall no further.
    creep = SLIP * SLOW * jnp.abs(ground.incline.grade) / jnp.min(jnp.asarray(ground.coefficients))
    above = jax.lax.stop_gradient(_ABOVE_CREEP * creep) / W_0
    return jnp.clip(above, last, 1.0)


def by_fixed_steps(
    start: State,
    car: Car | Joined,
    ground: Ground,
    steps: int | Steps,
    last: Float[Array, ""] | float,
    keep: bool,
) -> tuple[State, State]:
    """Runge-Kutta steps of order four, with the lost share of W as the independent variable.

    The scan runs over stages, not steps: with one rate in its body, the program with its gradient
    compiles six times faster than with four, and runs faster too (measured on two cores).

    Returns:
        The last state, and where kept the state after each step.
    """
    rate = _rate_by_loss(start, car, ground)
    ahead = jnp.array([0.5, 0.5, 1.0, 1.0])  # of a step: where a stage's rate is next taken to
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
    lengths = shorter * jnp.asarray(np.repeat(np.diff(_lost_shares(steps, _LAST_FIXED)), 4))
    # in reverse a stage is computed anew from its start: a quarter faster than keeping all of it, and
    # in a seventeenth of the memory (measured)
    (end, _, _), states = jax.lax.scan(
        jax.checkpoint(stage, prevent_cse=False),
        (start, start, start),
        weights(lengths, jnp.arange(4 * steps) % 4),
    )
    return end, () if states is None else tuple(v[3::4] for v in states)


def by_adaptive_steps(
    start: State, car: Car | Joined, ground: Ground, last: Float[Array, ""] | float, rows: int
) -> State:
    """States at the ends of the fixed steps, by adaptive steps of order eight."""
    import diffrax  # takes a second to import; inference does not need it

    lost = _lost_shares(rows, last)[1:]
    rate = _rate_by_loss(start, car, ground)
    W_0 = generalised_speed(start[3:6], car.k2)
    try:
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(lambda _, state, args: rate(state)),
            diffrax.Dopri8(),
            0.0,
            lost[-1],
            1e-3,
            start,
            saveat=diffrax.SaveAt(ts=jnp.asarray(lost[:-1]), t1=True),
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


def by_paced_steps(
    start: State, car: Car | Joined, ground: Ground, steps: Paced, rows: int
) -> tuple[State, State]:
    """Runge-Kutta steps of order four in time, each as long as the motion at its start allows.

    Returns:
        States, of which each is the first to have lost as much of W as so many fixed steps lose; and
        the vehicle at rest. Not numbers where the motion took too many steps.
    """
    by_W, longest = vector_field(car, ground), _longest_step(car, ground)
    W_0 = generalised_speed(start[3:6], car.k2)
    Carry = tuple[State, Int[Array, ""]]

    def rate(state: State) -> tuple[State, Array]:
        """d(state)/dt, and dW/dt."""
        rates = by_W(state)
        return tuple(k / rates[6] for k in rates), 1 / rates[6]

    def along(state: State, rates: State, time: Array) -> State:
        return tuple(a + time * b for a, b in zip(state, rates, strict=True))

    def step(carry: Carry, W: Array) -> Carry:
        state, count = carry
        first, dW = rate(state)
        # a little beyond the next speed, so that rows lie where they are asked for
        beyond = 1.2 * (W - generalised_speed(state[3:6], car.k2)) / dW
        h = jax.lax.stop_gradient(jnp.minimum(longest(state, dW) / steps.fineness, beyond))
        second = rate(along(state, first, h / 2))[0]
        third = rate(along(state, second, h / 2))[0]
        last = rate(along(state, third, h))[0]
        rates = (first, second, third, last)
        mean = (a / 6 + b / 3 + c / 3 + d / 6 for a, b, c, d in zip(*rates, strict=True))
        return along(state, tuple(mean), h), count + 1

    def to_speed(carry: Carry, W: Array) -> tuple[Carry, State]:
        def above(carry: Carry) -> Array:
            return (generalised_speed(carry[0][3:6], car.k2) > W) & (carry[1] < _MOST_PACED)

        carry = jax.lax.while_loop(above, lambda carry: step(carry, W), carry)
        return carry, carry[0]

    speeds = W_0 * (
        1 - jnp.asarray(_lost_shares(rows, closing_share(steps, start, car, ground)))[1:]
    )
    (end, count), states = jax.lax.scan(to_speed, (start, jnp.zeros((), int)), speeds)
    rates, dW = rate(end)
    left = -generalised_speed(end[3:6], car.k2) / dW  # until rest, if it slows down evenly
    moved = (a + left / 2 * b for a, b in zip(end[:3], rates[:3], strict=True))
    halt = (*moved, *(jnp.zeros_like(left),) * 3, end[6] + left)
    return states, tuple(jnp.where(count < _MOST_PACED, v, jnp.nan) for v in halt)


def _longest_step(car: Car | Joined, ground: Ground) -> Callable[[State, Array], Array]:
    """Largest time step at a state with this dW/dt, s."""
    wheel_u, wheel_v = wheel_places(car)
    assert car.wheels is not None, "only where a wheel rolls do steps have to be paced"
    steer, drag = cos_sin(jnp.asarray(car.wheels.steer)), jnp.asarray(car.wheels.drag)
    # friction times how much of it a rolling wheel has for sideways forces; in yaw it acts on k²
    grip = GRAVITY * jnp.asarray(ground.coefficients).max()
    grip *= jnp.sqrt(jnp.clip(1 - drag**2, 0.0))
    grip *= jnp.maximum(1.0, yaw_arm2(car) / car.k2)

    def longest(state: State, dW: Array) -> Array:
        _, _, heading, Vx, Vy, Omega, _ = state
        c, s = cos_sin(heading)
        u, v = c * Vx + s * Vy - Omega * wheel_v, c * Vy - s * Vx + Omega * wheel_u
        ahead, across = steer[0] * u + steer[1] * v, steer[0] * v - steer[1] * u
        soft2 = SLIP**2 * (ahead**2 + SLOW**2)
        rate = grip / jnp.sqrt(across**2 + soft2)  # at which slip goes
        near = 1 / (1 + across**2 / (_BALANCED**2 * soft2))
        per_time = rate / (_OF_SLIP + (_OF_BALANCE - _OF_SLIP) * near)
        stop = -dW / generalised_speed((Vx, Vy, Omega), car.k2)
        turn = jnp.abs(Omega)
        return 1 / jnp.maximum(per_time.max(), jnp.maximum(turn / _OF_TURN, stop / _OF_STOP))

    return longest


def at_rest(
    end: State, start: State, car: Car | Joined, ground: Ground, last: Float[Array, ""] | float
) -> State:
    """State at rest: the last of the motion keeps its direction while W falls linearly to zero."""
    left = [last * k for k in _rate_by_loss(start, car, ground)(end)]
    moved = (a + b / 2 for a, b in zip(end[:3], left[:3], strict=True))
    return (*moved, *(jnp.zeros_like(end[0]),) * 3, end[6] + left[6])


def _rate_by_loss(start: State, car: Car | Joined, ground: Ground) -> Callable[[State], State]:
    """d(state)/d(lost share of W)."""
    rate, W_0 = vector_field(car, ground), generalised_speed(start[3:6], car.k2)
    return lambda state: tuple(-W_0 * k for k in rate(state))
