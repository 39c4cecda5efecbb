"""Chains of NUTS in threads, by blocks, so that progress shows and Ctrl-C keeps draws."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import jax
import numpy as np
from jaxtyping import Array
from numpyro.infer.hmc import HMCState, hmc
from numpyro.infer.util import ParamInfo

from retrodict.inference.density.compiled import Programs
from retrodict.inference.density.kernels import Kernel
from retrodict.inference.density.log_density import Target
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.samplers.draws import Task
from retrodict.inference.threads import cores
from retrodict.inference.transforms.choice import Transform
from retrodict.models.arrays import Data
from retrodict.storage import checkpoint

BLOCK = 50  # iterations between which progress is reported and an interrupt is handled

# Good coordinates need trees of depth 3. A target that wants more than 63 leapfrogs a draw is not
# the one they were made for: better a run that ends soon and fails its checks than one that does not.
_MAX_TREE_DEPTH = 6

# Share of full trees, and way of a draw in standard deviations, beyond which a chain gets nowhere: all
# leapfrogs of a tree do not take it across the posterior. Chains that mix go three to five, with full
# trees too; of random crashes those that went less did not mix, and took minutes for it (measured).
_FULL, _LEAST_WAY = 0.9, 1.0


@dataclass(frozen=True)
class Chains:
    """Draws and statistics of the chains, and the states to continue them from.

    Args:
        w: draws in the sampled coordinates, shape (chains, draws, q).
        stats: statistics of the draws, each of shape (chains, draws): diverging, n_steps, energy, …
        complete: False when interrupted; then all chains are cut to the shortest.
        stuck: whether a chain gets nowhere; the others were not drawn to the end either.
        states: last state of each chain, from which it can be continued.
        records: arrays of every block of every chain, including warm-up and the ends cut from `w`.
    """

    w: np.ndarray
    stats: dict[str, np.ndarray]
    complete: bool
    stuck: bool
    states: list[Any] = field(repr=False)
    records: list[list[dict[str, np.ndarray]]] = field(repr=False)


def sample(task: Task, target_accept: float, after: Chains | None = None) -> Chains:
    """Draw from a posterior by NUTS (numpyro's), one thread a chain over one compiled program.

    Args:
        task: posterior, chains, draws, warm-up (which adapts the step size) and seed.
        target_accept: mean acceptance that the step size aims for.
        after: chains to be continued, made with the same arguments but for fewer `draws`.

    Returns:
        The chains; on KeyboardInterrupt with the draws that all of them have, marked incomplete.
    """
    posterior, chains, warmup = task.posterior, task.chains, task.warmup
    arguments = (posterior.data, posterior.transform)
    start, advance = kernels(posterior.programs, warmup, target_accept, *arguments)
    n = posterior.size
    records: list[list[dict[str, np.ndarray]]]
    if after is None:
        # spread wider than the posterior, so that R-hat has something to find
        starts = 1.5 * np.random.default_rng(task.seed).standard_normal((chains, n))
        states = [_first_state(posterior, start, (task.seed, i), w) for i, w in enumerate(starts)]
        records = [[] for _ in range(chains)]
        if task.resume is not None:
            states, records = checkpoint.load(task.resume, settings(task), states)
    else:
        states, records = list(after.states), [list(r) for r in after.records]
    total = warmup + task.draws

    def run_block(chain: int) -> None:
        states[chain], record = posterior.programs(advance, states[chain], *arguments)
        records[chain].append({k: np.asarray(v) for k, v in record.items()})

    def all_have() -> int:
        return min(len(r) for r in records) * BLOCK

    stuck, first = False, -(-warmup // BLOCK)  # block after the warm-up
    with ThreadPoolExecutor(min(chains, cores())) as pool:
        running: dict[Future[None], int] = {}
        ready = list(range(chains))
        try:
            while ready or running:
                # a block at a time, in turn, so that an interrupt finds chains nearly as far
                if all(len(r) > first for r in records):
                    stuck = any(gets_nowhere(r[first]) for r in records)
                for chain in ready:
                    if len(records[chain]) * BLOCK < total and not stuck:
                        running[pool.submit(run_block, chain)] = chain
                done = wait(running, timeout=0.1, return_when=FIRST_COMPLETED).done
                for future in done:
                    future.result()
                ready = [running.pop(future) for future in done]
                task.progress(chains * min(all_have(), total), chains * total)
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)

    kept = all_have()
    end = min(kept, total)
    joined = {
        k: np.stack([np.concatenate([b[k] for b in r])[warmup:end] for r in records])
        for k in (records[0][0] if kept else ())
    }
    w = joined.pop("w", np.empty((chains, 0, n)))
    return Chains(w, joined, end == total or stuck, stuck, states, records)


def gets_nowhere(block: dict[str, np.ndarray]) -> bool:
    """Whether a block of a chain shows full trees that do not cross the posterior.

    Args:
        block: records of the block's iterations, by name: `n_steps`, `step_size`.
    """
    full = np.mean(block["n_steps"] >= 2**_MAX_TREE_DEPTH - 1) > _FULL
    return bool(full and np.mean(block["n_steps"] * block["step_size"]) < _LEAST_WAY)


def kernels(
    programs: Programs,
    warmup: int,
    target_accept: float,
    data: Data,
    transform: Transform,
) -> tuple[Kernel[..., HMCState], Kernel[..., tuple[HMCState, dict[str, Array]]]]:
    """Kernels of NUTS that start a chain and advance it by a block; their compilation begins here.

    Args:
        programs: compiled programs of the posterior.
        warmup: iterations that adapt the step size.
        target_accept: mean acceptance that the step size aims for.
        data: the scene's numbers; only their shapes matter here.
        transform: parameters of the coordinates; only their shapes matter here.

    Returns:
        start((seed, chain), w, potential, gradient, data, transform) -> state and
        advance(state, data, transform) -> (state, records of BLOCK iterations).
    """

    @cache  # NumPyro's step works only once its start was traced
    def of(target: Target) -> tuple[Callable[..., Any], Callable[..., Any]]:
        def potential_of(data: Data, transform: Transform) -> Callable[[Array], Array]:
            return lambda w: target.steered(w, data, transform)

        return hmc(potential_fn_gen=potential_of, algo="NUTS")

    def first(
        target: Target, seeds: Any, w: Array, potential: Array, gradient: Array, *numbers: Any
    ) -> HMCState:
        seed, chain = seeds
        return of(target)[0](
            ParamInfo(w, potential, gradient),
            num_warmup=warmup,
            step_size=0.7,
            target_accept_prob=target_accept,
            max_tree_depth=_MAX_TREE_DEPTH,
            model_args=numbers,
            rng_key=jax.random.fold_in(jax.random.key(seed), chain),
        )

    def block(
        target: Target, state: HMCState, data: Data, transform: Transform
    ) -> tuple[HMCState, dict[str, Array]]:
        step = of(target)[1]

        def iterate(state: HMCState, _: None) -> tuple[HMCState, dict[str, Array]]:
            state = step(state, (data, transform))
            return state, {
                "w": state.z,
                "diverging": state.diverging,
                "n_steps": state.num_steps,
                "energy": state.energy,
                "acceptance_rate": state.accept_prob,
                "lp": -state.potential_energy,
                "step_size": state.adapt_state.step_size,
            }

        return jax.lax.scan(iterate, state, None, length=BLOCK)

    start: Kernel[..., HMCState] = Kernel(f"start {warmup} {target_accept}", first)
    advance: Kernel[..., tuple[HMCState, dict[str, Array]]] = Kernel(
        f"advance {warmup} {target_accept}", block
    )
    n = transform.whitening.size
    nowhere = ((0, 0), np.zeros(n), 0.0, np.zeros(n), data, transform)
    programs.expect(start, *nowhere)
    programs.expect(
        advance, lambda: jax.eval_shape(programs.function(start), *nowhere), data, transform
    )
    return start, advance


def settings(task: Task) -> dict[str, int | str]:
    """Settings that a run must share with an interrupted one to continue its chains."""
    posterior = task.posterior
    print_ = hashlib.sha256()
    for leaf in jax.tree.leaves((posterior.data, posterior.transform)):
        print_.update(np.asarray(leaf).tobytes())
    return {
        "seed": task.seed,
        "chains": task.chains,
        "warmup": task.warmup,
        "posterior": print_.hexdigest()[:16],
    }


def _first_state(
    posterior: Posterior, start: Kernel[..., HMCState], seeds: tuple[int, int], w: np.ndarray
) -> HMCState:
    """A chain's first state; a start that is far out on the density is drawn nearer to the mode.

    The density about the mode is close to a standard normal, whose potential rises by w² / 2; where it
    rises by more than twice that, the coordinates say little and a chain could be stuck for good.
    """
    at_mode, _ = posterior.potential(np.zeros_like(w))
    for _ in range(20):
        potential, gradient = posterior.potential(w)
        near = potential <= at_mode + w @ w
        if near and np.isfinite(gradient).all():
            break
        w = w / 2
    numbers = (posterior.data, posterior.transform)
    return posterior.programs(start, seeds, w, potential, gradient, *numbers)
