"""Chains of NUTS in threads, by blocks, so that progress shows and Ctrl-C keeps draws."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import Any

import jax
import numpy as np

from retrodict.inference.density.compiled import BLOCK
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.samplers import checkpoint
from retrodict.inference.samplers.draws import Task


@dataclass(frozen=True)
class Chains:
    """What the chains brought.

    Args:
        w: draws in the sampled coordinates, shape (chains, draws, q).
        stats: per draw, each of shape (chains, draws): diverging, n_steps, energy, …
        complete: False when interrupted; then all chains are cut to the shortest.
        states: where each chain stands, so that it can go on.
        records: of every block of every chain, warm-up and cut ends included.
    """

    w: np.ndarray
    stats: dict[str, np.ndarray]
    complete: bool
    states: list[Any] = field(repr=False)
    records: list[list[dict[str, np.ndarray]]] = field(repr=False)


def sample(task: Task, target_accept: float, after: Chains | None = None) -> Chains:
    """Draw from a posterior by NUTS (numpyro's), one thread a chain over one compiled program.

    Args:
        task: posterior, chains, draws, warm-up (which adapts the step size) and seed.
        target_accept: mean acceptance that the step size aims for.
        after: chains that are to be continued, made with the same arguments but for fewer `draws`.

    Returns:
        The chains; on KeyboardInterrupt with the draws that all of them have, marked incomplete.
    """
    posterior, chains, warmup = task.posterior, task.chains, task.warmup
    arguments = (posterior.data, posterior.transform)
    start, advance = posterior.programs.sampler(warmup, target_accept, *arguments)
    n = posterior.size
    records: list[list[dict[str, np.ndarray]]]
    if after is None:
        keys = jax.random.split(jax.random.key(task.seed), chains)
        # spread wider than the posterior, so that R-hat has something to find
        starts = 1.5 * np.random.default_rng(task.seed).standard_normal((chains, n))
        states = [_start(posterior, start, key, w) for key, w in zip(keys, starts, strict=True)]
        records = [[] for _ in range(chains)]
        if task.resume is not None:
            states, records = checkpoint.load(task.resume, settings(task), states)
    else:
        states, records = list(after.states), [list(r) for r in after.records]
    total = warmup + task.draws

    def run_block(chain: int) -> None:
        states[chain], record = advance(states[chain], *arguments)
        records[chain].append({k: np.asarray(v) for k, v in record.items()})

    def all_have() -> int:
        return min(len(r) for r in records) * BLOCK

    with ThreadPoolExecutor(min(chains, os.cpu_count() or 1)) as pool:
        running: dict[Future[None], int] = {}
        ready = list(range(chains))
        try:
            while ready or running:
                # a block at a time, in turn, so that an interrupt finds chains nearly as far
                for chain in ready:
                    if len(records[chain]) * BLOCK < total:
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
    return Chains(joined.pop("w", np.empty((chains, 0, n))), joined, end == total, states, records)


def settings(task: Task) -> dict[str, int | str]:
    """What chains must share for one to go on where the other stopped."""
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


def _start(posterior: Posterior, start: Callable, key: jax.Array, w: np.ndarray) -> object:
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
    return start(key, w, potential, gradient, posterior.data, posterior.transform)
