"""The clocks and solvers that are compared, and their compiled programs."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

from retrodict.mechanics import Car, Ground, Wheels, Zone, rest
from retrodict.mechanics.motion import vector_field
from tests.shared.reference import Scene

BATCH = 1000  # the scenes, repeated
FEWER = 10  # adaptive Jacobians take long: every tenth scene makes their batch
FIXED = (64, 128, 256, 512, 1024)
INFERENCE = 64  # about the steps that inference begins with, 48
DEFAULT = "rest (W, Dopri8), in turn"
LAST = 1e-5  # of W: from here to rest in closed form, as after adaptive steps in retrodict
SLOWLY = 0.01  # m/s: below this W, regularised friction fades


# start, car, ground, tolerance -> pose, evaluations of the slope
Solve = Callable[[Any, Any, Any, Any], tuple[Any, Any]]


class Method(NamedTuple):
    """A way to rest.

    Args:
        name: clock and solver.
        setting: steps or tolerance, to be read.
        solve: the pose at rest.
        tolerance: what `solve` takes as its last argument.
        mark: what it is the default of.
        in_turn: whether a batch is one scene after another in one program, and not abreast.
        fixed: whether its steps are.
        reverse: whether its derivatives are in reverse mode.
        twin: takes the same steps, and counts them.
        aside: off the frontier: its Jacobian is not timed.
    """

    name: str
    setting: str
    solve: Solve
    tolerance: float = 0.0
    mark: str = ""
    in_turn: bool = False
    fixed: bool = False
    reverse: bool = False
    twin: Solve | None = None
    aside: bool = False


def _rest(start: Any, car: Car, ground: Ground, _: Any) -> tuple[Any, Any]:
    return rest(start[:3], start[3:], car, ground), jnp.nan


@functools.cache
def _steps(steps: int) -> Solve:
    def solve(start: Any, car: Car, ground: Ground, _: Any) -> tuple[Any, Any]:
        return rest(start[:3], start[3:], car, ground, steps), jnp.asarray(4.0 * steps)

    return solve


def _slope(car: Car, ground: Ground) -> Callable[[Any], Any]:
    """d(pose, velocity, time)/dW of one array."""
    rate = vector_field(car, ground)
    return lambda y: jnp.stack(rate((*y[:6], jnp.zeros(()))))


def _speed(car: Car, y: Any) -> Any:
    return jnp.sqrt(y[3] ** 2 + y[4] ** 2 + car.k2 * y[5] ** 2)


def _halt(y: Any, W: Any, rate: Any) -> Any:
    """The rest pose when W is left and the state changes at this rate with W."""
    return y[:3] - W * rate[:3] / 2


def last_in_time(tolerance: Any) -> Any:
    """Share of W at which a clock of time stops: where its tolerance still distinguishes W from zero."""
    return jnp.clip(10 * tolerance, LAST, 1e-3)


@functools.cache
def _on_w(solver: type[diffrax.AbstractERK]) -> Solve:
    """Adaptive, over the share of W that is lost: the end is known."""

    def solve(start: Any, car: Car, ground: Ground, tolerance: Any) -> tuple[Any, Any]:
        slope, W_0 = _slope(car, ground), _speed(car, start)
        term = diffrax.ODETerm(lambda s, y, args: -W_0 * slope(y)[:6])
        y, evaluations = _diffrax(term, solver, 1 - LAST, start, tolerance, W_0, None)
        return _halt(y, LAST * W_0, slope(y)), evaluations

    return solve


@functools.cache
def _on_time(solver: type[diffrax.AbstractERK], regularised: bool) -> Solve:
    """Adaptive, over time: an event ends it.

    Regularised, friction fades with W below `SLOWLY`: the end is no kink, and where exactly the
    event strikes does not matter, but the last of the way is crept.
    """

    def solve(start: Any, car: Car, ground: Ground, tolerance: Any) -> tuple[Any, Any]:
        slope, W_0 = _slope(car, ground), _speed(car, start)

        def field(t: Any, y: Any, args: Any) -> Any:
            rate = slope(y)
            rate = rate[:6] / rate[6]
            if not regularised:
                return rate
            W = _speed(car, y)
            return jnp.concatenate([rate[:3], rate[3:] * W / jnp.hypot(W, SLOWLY)])

        def left(t: Any, y: Any, args: Any, **_: Any) -> Any:
            W = _speed(car, y)
            return W - 0.01 * SLOWLY if regularised else W / W_0 - last_in_time(tolerance)

        finder = None if regularised else optimistix.Newton(1e-10, 1e-10)
        event, term = diffrax.Event(left, finder), diffrax.ODETerm(field)
        y, evaluations = _diffrax(term, solver, jnp.inf, start, tolerance, W_0, event)
        return y[:3] if regularised else _halt(y, _speed(car, y), slope(y)), evaluations

    return solve


def _diffrax(
    term: Any,
    solver: type[diffrax.AbstractERK],
    end: Any,
    start: Any,
    tolerance: Any,
    W_0: Any,
    event: Any,
) -> tuple[Any, Any]:
    solution = diffrax.diffeqsolve(
        term,
        solver(),
        0.0,
        end,
        1e-3,
        start,
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=0.1 * tolerance * W_0),
        adjoint=diffrax.ForwardMode(),
        event=event,
        max_steps=50_000,
        throw=False,
    )
    a_step = solver.tableau.num_stages - solver.tableau.fsal
    return solution.ys[-1], 1.0 * a_step * solution.stats["num_steps"]


def methods() -> Iterator[Method]:
    """All that are compared, but for SciPy's."""
    tsit5, dopri8 = _on_w(diffrax.Tsit5), _on_w(diffrax.Dopri8)
    mark = "default of rest"
    yield Method(DEFAULT, "1e-09", _rest, 1e-9, mark, in_turn=True, reverse=True, twin=dopri8)
    for steps in FIXED:
        mark = "about what inference begins with" if steps == INFERENCE else ""
        yield Method("W, RK4", f"{steps} steps", _steps(steps), 0.0, mark, fixed=True)
    steps = FIXED[-2]
    yield Method("W, RK4, in turn", f"{steps} steps", _steps(steps), in_turn=True, aside=True)
    event, faded = (_on_time(diffrax.Tsit5, regularised) for regularised in (False, True))
    adaptive: tuple[tuple[str, Solve, tuple[float, ...], bool, bool], ...] = (
        ("W, Tsit5", tsit5, (1e-6,), False, True),
        ("W, Tsit5, in turn", tsit5, (1e-4, 1e-6, 1e-8), True, False),
        ("W, Dopri8, in turn", dopri8, (1e-6, 1e-7), True, False),
        ("time, Tsit5, event, in turn", event, (1e-4, 1e-6, 1e-8), True, False),
        ("time, Tsit5, regularised, in turn", faded, (1e-6,), True, True),
    )
    for name, solve, tolerances, in_turn, aside in adaptive:
        for tolerance in tolerances:
            yield Method(name, f"{tolerance:.0e}", solve, tolerance, in_turn=in_turn, aside=aside)


class Programs(NamedTuple):
    """Singly, batched, and batched with d(rest)/d(start pose, start velocity)."""

    single: Any
    batched: Any
    jacobian: Any


@functools.cache
def compiled(solve: Solve, in_turn: bool = False, reverse: bool = False) -> Programs:
    def over_scenes(function: Any) -> Any:
        if not in_turn:
            return jax.jit(jax.vmap(function, (0, 0, 0, None)))
        return jax.jit(lambda *a: jax.lax.map(lambda scene: function(*scene, a[3]), a[:3]))

    jacobian = (jax.jacrev if reverse else jax.jacfwd)(solve, has_aux=True)
    return Programs(jax.jit(solve), over_scenes(solve), over_scenes(jacobian))


def poses_and_jacobians(of: Sequence[Scene], steps: int | None) -> tuple[np.ndarray, np.ndarray]:
    """Rest poses and Jacobians of up to a hundred scenes by `rest`, by the programs that are timed."""
    programs = compiled(_rest, True, True) if steps is None else compiled(_steps(steps))
    sizes = (BATCH, BATCH // FEWER if steps is None else BATCH)
    every = as_jax(of)
    poses, jacobians = (
        np.asarray(program(*repeated(every, np.arange(len(of)), size), 0.0)[0])[: len(of)]
        for program, size in zip((programs.batched, programs.jacobian), sizes, strict=True)
    )
    return poses, jacobians


def as_jax(of: Sequence[Scene]) -> tuple[Any, Car, Ground]:
    """The scenes, all locked or all rolling."""
    names = [name for name, value in zip(Scene._fields, of[0], strict=True) if value is not None]
    column = {name: jnp.array([getattr(s, name) for s in of]) for name in names}
    start = jnp.concatenate([column["pose"], column["velocity"]], axis=1)
    wheels = Wheels(column["drag"], column["steer"]) if "drag" in column else None
    car = Car(*(column[name] for name in ("k2", "front_axle", "rear_axle", "track")), wheels)
    zone = Zone(column["point"][:, None], column["inward"][:, None])
    return start, car, Ground(column["coefficients"], column["speed_dependence"], zone)


def take(tree: Any, index: Any) -> Any:
    """Some of the scenes."""
    return jax.tree.map(lambda leaf: leaf[index], tree)


def repeated(tree: Any, index: np.ndarray, size: int) -> Any:
    """So many scenes, those of the index again and again: one program serves all sets."""
    return take(tree, np.resize(index, size))
