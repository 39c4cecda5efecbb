"""What a user would pick instead: NumPyro, blackjax and emcee on the forward model as it stands.

All sample one density: the rung's own, its sites unconstrained as NumPyro does it. All start at draws of
the reference posterior, one a chain or walker, which spares them the search for it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from numpyro.infer import NUTS
from retrodict.models.arrays import Data
from scipy import stats

from tests.shared import reference
from tests.shared.posteriors import Forward

if TYPE_CHECKING:
    import emcee

DEFAULT_NAME = "NumPyro NUTS at its defaults"
DENSE_NAME = "NumPyro NUTS, dense mass, compiled whole"
BLACKJAX_NAME = "blackjax NUTS, window adaptation, compiled whole"
EMCEE_NAME = "emcee, density compiled by JAX"
SCIPY_NAME = "emcee, forward model in SciPy"

THREADS = 2
CHAINS = 2  # one in each thread
# Iterations of warm-up, then draws. Trees are deep until the mass matrix is known, and with a diagonal
# one for good; a dense one needs more to be known well, and repays it.
DIAGONAL, DENSE = (300, 700), (500, 500)
FEWEST = 100  # draws of each chain before it is stopped
BLOCK = 10  # iterations in one program where the chain is compiled whole
WALKERS = 64
TOLERANCE = 1e-6  # of SciPy's RK45: the loosest decade as good as our steps on both scenes
STEPS = 20_000
THIN = 10  # of emcee's steps one is kept

Array = np.ndarray[Any, np.dtype[Any]]
Sites = dict[str, Array]


class Trace(NamedTuple):
    """What a competitor brought before its time was up.

    Args:
        name: of the sampler.
        u: draws after warm-up, shape (chains, draws, q).
        warm: seconds before the first of them.
        taken: seconds after them, in drawing, when so many draws were there: (seconds, draws).
        evaluations: of the gradient or density for the draws kept, all chains together.
        whole: draws of each chain that were asked for.
        compile: seconds.
        note: how it was stopped, and what its time was taken from.
    """

    name: str
    u: Array
    warm: float
    taken: list[tuple[float, int]]
    evaluations: float
    whole: int
    compile: float
    note: str = ""


class Sampler(NamedTuple):
    """A sampler by blocks: what starts a chain, what of its warm-up is one program, what goes on."""

    name: str
    begin: Callable[[Any, Any], Any]
    warm: Callable[[Any], Any]
    advance: Callable[[Any], tuple[Any, tuple[Any, Any]]]  # draws and gradients of each
    discard: int  # iterations of `advance` that still warm up
    block: int
    chains: int
    compile: float


def _numpyro(forward: Forward, name: str, dense: bool, whole: bool, warmup: int) -> Sampler:
    """NumPyro's NUTS at its defaults but for the mass matrix.

    Args:
        forward: what is sampled.
        name: to be read.
        dense: whether its mass matrix is.
        whole: blocks of iterations in one program, and chains in threads; otherwise a program an
            iteration and one chain, as MCMC does by default.
        warmup: iterations.
    """
    kernel, data = NUTS(forward.model, dense_mass=dense), forward.data
    block = BLOCK if whole else 1

    def begin(key: Any, u: Any) -> Any:
        return kernel.init(key, warmup, forward.unravel(u), (data,))

    def advance(state: Any, data: Data) -> Any:
        def iterate(state: Any, _: None) -> Any:
            state = kernel.sample(state, (data,), {})
            return state, (ravel_pytree(state.z)[0], state.num_steps)

        return jax.lax.scan(iterate, state, None, length=block)

    state = begin(jax.random.key(0), forward.starts[0])
    start = time.perf_counter()
    program = jax.jit(advance).lower(state, data).compile()
    taken = time.perf_counter() - start
    on = partial(_with, program, data)
    return Sampler(name, begin, lambda s: s, on, warmup, block, CHAINS if whole else 1, taken)


def _blackjax(forward: Forward, warmup: int) -> Sampler:
    """blackjax's NUTS after its window adaptation (diagonal), each compiled whole."""
    import blackjax  # in the group `bench` only, and tests read this module

    data = forward.data

    def warm(state: Any, data: Data) -> Any:
        key, u = state
        key, now = jax.random.split(key)
        density = partial(forward.log_density, data=data)
        adaptation = blackjax.window_adaptation(blackjax.nuts, density)
        (last, parameters), _ = adaptation.run(now, u, warmup)
        return key, last, parameters

    def advance(state: Any, data: Data) -> Any:
        key, last, parameters = state
        step = blackjax.nuts(partial(forward.log_density, data=data), **parameters).step

        def iterate(carry: Any, _: None) -> Any:
            key, now = jax.random.split(carry[0])
            last, info = step(now, carry[1])
            return (key, last), (last.position, info.num_integration_steps)

        (key, last), record = jax.lax.scan(iterate, (key, last), None, length=BLOCK)
        return (key, last, parameters), record

    state = (jax.random.key(0), jnp.asarray(forward.starts[0]))
    start = time.perf_counter()
    first = jax.jit(warm).lower(state, data).compile()
    then = jax.jit(advance).lower(jax.eval_shape(warm, state, data), data).compile()
    return Sampler(
        BLACKJAX_NAME,
        lambda key, u: (key, jnp.asarray(u)),
        lambda state: first(state, data),
        partial(_with, then, data),
        0,
        BLOCK,
        CHAINS,
        time.perf_counter() - start,
    )


def _with(program: Any, data: Data, state: Any) -> Any:
    return program(state, data)


def _run(sampler: Sampler, forward: Forward, limit: float, draws: int, seed: int) -> Trace:
    """Advance all chains side by side till they have their draws or the time is up."""
    chains = range(sampler.chains)
    keys = jax.random.split(jax.random.key(seed), sampler.chains)
    states = [sampler.begin(keys[i], forward.starts[i]) for i in chains]
    found: list[list[tuple[Array, Array]]] = [[] for _ in chains]
    marks: list[tuple[float, int]] = []

    def warm(chain: int) -> None:
        states[chain] = jax.block_until_ready(sampler.warm(states[chain]))

    def advance(chain: int) -> None:
        states[chain], (u, gradients) = sampler.advance(states[chain])
        found[chain].append((np.asarray(u), np.asarray(gradients)))

    begin = time.perf_counter()
    with ThreadPoolExecutor(sampler.chains) as pool:
        list(pool.map(warm, chains))
        warmed = passed = time.perf_counter() - begin
        for done in range(sampler.block, sampler.discard + draws + 1, sampler.block):
            list(pool.map(advance, chains))
            passed = time.perf_counter() - begin
            if done <= sampler.discard:
                warmed = passed
            else:
                marks.append((passed - warmed, done - sampler.discard))
            if passed > limit and done >= sampler.discard + FEWEST:
                break
    u, gradients = (np.stack([np.concatenate([b[i] for b in c]) for c in found]) for i in (0, 1))
    u, gradients = u[:, sampler.discard :], gradients[:, sampler.discard :]
    note = "" if u.shape[1] == draws else f"stopped after {passed:.0f} s, the rest extrapolated"
    return Trace(
        sampler.name, u, warmed, marks, float(gradients.sum()), draws, sampler.compile, note
    )


# --- emcee --------------------------------------------------------------------------------------


def _emcee(
    density: Callable[[Array], Any], starts: Array, steps: int, limit: float, vectorize: bool
) -> tuple[emcee.EnsembleSampler, list[tuple[float, int]]]:
    """The stretch move from draws of the posterior, with its clock."""
    import emcee  # in the group `bench` only, and tests read this module

    walkers = emcee.EnsembleSampler(*starts.shape, density, vectorize=vectorize)
    walkers.random_state = np.random.RandomState(0).get_state()
    marks: list[tuple[float, int]] = []
    begin = time.perf_counter()
    for _ in walkers.sample(starts, iterations=steps // THIN, thin_by=THIN):
        marks.append((time.perf_counter() - begin, len(marks) + 1))
        if marks[-1][0] > limit:
            break
    return walkers, marks


def _emcees(forward: Forward, limit: float, steps: int) -> Iterator[Trace]:
    """emcee on the density compiled by JAX, in batches; then as long as SciPy would take for it."""
    starts = forward.starts[:WALKERS]
    density = jax.jit(jax.vmap(partial(forward.log_density, data=forward.data)))

    def compiled(u: Array) -> Array:
        return np.nan_to_num(np.asarray(density(u)), nan=-np.inf)

    begin = time.perf_counter()
    compiled(starts), compiled(starts[::2])
    compiling = time.perf_counter() - begin
    walkers, marks = _emcee(compiled, starts, steps, limit, vectorize=True)
    u = np.swapaxes(walkers.get_chain(), 0, 1)
    spent, kept = marks[-1]
    asked = kept * THIN * WALKERS
    note = "" if kept * THIN >= steps else f"stopped after {spent:.0f} s, the rest extrapolated"
    whole = steps // THIN
    yield Trace(EMCEE_NAME, u, 0.0, marks, asked, whole, compiling, note)

    plain, some = scipy_density(forward), starts[:12]
    each, values = _each(plain, some)
    in_arrays, _ = _each(scipy_density(forward, first_written=True), some[:4])
    apart = np.ptp(np.array(values) - compiled(some))
    times = each / THREADS * asked / spent
    yield Trace(
        SCIPY_NAME,
        u,
        0.0,
        [(seconds * times, draws) for seconds, draws in marks],
        asked,
        whole,
        0.0,
        f"extrapolated: the walk on the compiled density, at {each * 1e3:.0f} ms a density in each of"
        f" {THREADS} processes, without loss ({in_arrays * 1e3:.0f} ms with a right-hand side in"
        f" NumPy arrays instead of plain numbers); log densities agree within {apart:.2g}",
    )


def _each(density: Callable[[Array], float], some: Array) -> tuple[float, list[float]]:
    """Seconds for a density, and those found."""
    begin = time.perf_counter()
    values = [density(row) for row in some]
    return (time.perf_counter() - begin) / len(some), values


def scipy_density(forward: Forward, first_written: bool = False) -> Callable[[Array], float]:
    """The same density, up to a constant, as one would write it in NumPy and SciPy.

    For two surfaces, friction that does not depend on speed, nothing known of B.

    Args:
        forward: whose density it is.
        first_written: whether run-outs compute in NumPy arrays, and not in the faster plain numbers.
    """
    structure, data = forward.structure, forward.data
    assert structure.rung == "planar-moment+wheels"
    assert structure.constant_friction
    assert not structure.rolling
    assert len(structure.surfaces) == 2
    assert not structure.known_of_b
    given = {name: pair[0] for name, pair in data.inputs.items()}
    location, scale = np.array([data.inputs[name] for name in structure.names]).T
    lognormal = np.array([law == "lognormal" for _, law in structure.uncertain])
    found, sd = np.array([data.evidence[name] for name in structure.evidence]).T

    def density(u: Array) -> float:
        # in the order of their names: direction_b, e, e_m, measured, mu, omega_b, speed_b
        share = 1 / (1 + np.exp(-u[:3]))
        direction, e, e_m = np.pi * (2 * share[0] - 1), share[1], 2 * share[2] - 1
        xi, (mu, omega_b, log_speed) = u[3:-3], u[-3:]
        speed = np.exp(log_speed)
        log_slope = np.log(share * (1 - share)).sum() + log_speed
        values = location + scale * xi
        x = given | dict(
            zip(structure.names, np.where(lognormal, np.exp(values), values), strict=True)
        )
        approach_b = np.array([speed * np.cos(direction), speed * np.sin(direction), omega_b])
        lever = {v: _lever(x, v) for v in "ab"}
        hit = partial(_impact, x, lever, approach_b)
        log_prior = _log_prior(data.priors, hit, (speed, omega_b), (e, mu, e_m))
        rests = [
            reference.solve(scene, "RK45", TOLERANCE, 1e-3, first_written)[0]
            for scene in (
                _skid(x, v, lever[v], V, data)
                for v, V in zip("ab", hit((e, mu, e_m)).after, strict=True)
            )
        ]
        miss = (np.concatenate(rests) - found) / sd
        return float(log_slope + log_prior - (xi @ xi + miss @ miss) / 2)

    return density


def _lever(x: dict[str, Any], v: str) -> Array:
    """From a centre of gravity to the impact centre."""
    angle = x[f"heading_{v}"] + x[f"impact_angle_{v}"]
    return np.asarray(x[f"impact_distance_{v}"] * np.array([np.cos(angle), np.sin(angle)]))


class Hit(NamedTuple):
    """An impact: velocities after it, a row a vehicle; contact velocities (normal, tangent); impulse."""

    after: Array
    closing: Array
    opening: Array
    P_n: float


def _impact(
    x: dict[str, Any], lever: dict[str, Array], approach_b: Array, coefficients: tuple
) -> Hit:
    """SAE 770014, eqs 9-14 and 22-24."""
    e, mu, e_m = coefficients
    course = x["direction_a"]
    approach_a = [x["speed_a"] * np.cos(course), x["speed_a"] * np.sin(course), x["omega_a"]]
    before = np.array([approach_a, approach_b])
    c, s = np.cos(x["Gamma"]), np.sin(x["Gamma"])
    axes, line = np.array([[c, s], [-s, c]]), np.array([c - mu * s, s + mu * c])
    mass, inertia = ([x[f"{what}_{v}"] for v in "ab"] for what in ("mass", "yaw_inertia"))

    def after(P_n: float) -> Array:
        P = np.array([P_n * line, -P_n * line])
        turn = [arm[0] * p[1] - arm[1] * p[0] for arm, p in zip(lever.values(), P, strict=True)]
        free = before[:, 2] + np.array(turn) / inertia
        M = (1 - e_m) * (free[1] - free[0]) / (1 / inertia[0] + 1 / inertia[1])
        spin = free + np.array([M, -M]) / inertia
        return np.column_stack([before[:, :2] + P / np.array(mass)[:, None], spin])

    def contact(V: Array) -> Array:
        at = [
            v[:2] + v[2] * np.array([-r[1], r[0]]) for v, r in zip(V, lever.values(), strict=True)
        ]
        return np.asarray(axes @ (at[0] - at[1]))

    # linear in P_n
    none, one, closing = contact(after(0.0)), contact(after(1.0)), contact(before)
    P_n = (-e * closing[0] - none[0]) / (one[0] - none[0])
    return Hit(after(P_n), closing, contact(after(P_n)), float(P_n))


def _log_prior(
    priors: dict[str, Any],
    hit: Callable[[tuple], Hit],
    motion: tuple[float, float],
    coefficients: tuple[float, float, float],
) -> float:
    """Of B's speed and yaw rate and of the coefficients, as `models/impacts/planar.py` has them."""
    (speed, omega_b), (e, mu, e_m) = motion, coefficients
    found = -((speed / priors["speed_b"][0]) ** 2 + (omega_b / priors["omega_b"][0]) ** 2) / 2
    without, full = hit((e, 0.0, e_m)), hit((e, 1.0, e_m))
    fast, slow, over = priors["e"]
    scale = fast + (slow - fast) * np.exp(-abs(without.closing[0]) / over)
    found += stats.truncnorm(0, 1 / scale, scale=scale).logpdf(e)
    centre, scale = priors["e_m"]
    found += stats.norm(centre, scale).logpdf(e_m)
    # the mu that ends the sliding; none where friction only drives it
    left = [h.opening[1] / h.P_n for h in (without, full)]
    critical = left[0] / (left[0] - left[1])
    sense = without.closing[1] * without.closing[0]
    if without.closing[1] * without.opening[1] > 0 and critical * sense < 0:
        critical = 1e9 * np.sign(sense)
    scale, median = priors["mu"]
    size, mu = abs(critical), mu * np.sign(critical)
    if mu > size:
        return -np.inf
    odds, other = (size / 2) ** 4, stats.fisk(5, scale=median)
    ends = stats.halfnorm(scale=scale).pdf(1 - mu / size) / size
    goes_on = other.pdf(mu) / other.cdf(size)
    return float(found + np.log((ends + odds * goes_on) / (1 + odds)))


def _skid(x: dict[str, Any], v: str, lever: Array, V: Array, data: Data) -> reference.Scene:
    """A vehicle's run-out, to be solved over time."""
    inward = np.asarray(data.edges.inward[0])
    road, berm = (name for name in x if name.startswith("friction_"))
    return reference.Scene(
        pose=np.array([*(np.array([x["impact_x"], x["impact_y"]]) - lever), x[f"heading_{v}"]]),
        velocity=V,
        k2=x[f"yaw_inertia_{v}"] / x[f"mass_{v}"],
        front_axle=x[f"front_axle_{v}"],
        rear_axle=x[f"rear_axle_{v}"],
        track=x[f"track_{v}"],
        coefficients=x[f"grip_{v}"] * np.array([x[road], x[berm]]),
        speed_dependence=np.zeros(2),
        point=data.edges.point[0] + x[f"edge_{berm.removeprefix('friction_')}"] * inward,
        inward=inward,
    )


def traces(forward: Forward, limit: float, share: float = 1.0) -> Iterator[Trace]:
    """Run every competitor, each for about so many seconds at most.

    Args:
        forward: what is sampled, and from where.
        limit: seconds of sampling, after which it ends as soon as there are a few draws; compilation
            is apart.
        share: of the iterations, for trials.
    """

    def few(iterations: tuple[int, int]) -> tuple[int, int]:
        warmup, draws = (max(2 * BLOCK, int(n * share) // BLOCK * BLOCK) for n in iterations)
        return warmup, draws

    for name, dense, iterations in (
        (DEFAULT_NAME, False, few(DIAGONAL)),
        (DENSE_NAME, True, few(DENSE)),
    ):
        warmup, draws = iterations
        yield _run(_numpyro(forward, name, dense, dense, warmup), forward, limit, draws, seed=1)
    warmup, draws = few(DIAGONAL)
    yield _run(_blackjax(forward, warmup), forward, limit, draws, seed=1)
    yield from _emcees(forward, limit / 2, int(STEPS * share) // THIN * THIN)
