"""The compiled programs of a rung and a scene's structure; numbers come in as arguments.

Two scenes of one structure share them, and the user's cache directory keeps them between runs, so
that only the first run of a structure pays for compilation.
"""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import Any

import jax
import numpy as np
from jaxtyping import Array
from numpyro.infer.hmc import hmc
from numpyro.infer.util import ParamInfo

from retrodict.inference.density import disk_cache
from retrodict.inference.density.log_density import Target
from retrodict.inference.transforms import rest_pose
from retrodict.inference.transforms.choice import transform_of
from retrodict.models.arrays import Data, Structure

BATCH = 512  # run-outs per call of `reached`
CHUNK = 500  # draws per call of `simulate`
# points per call of `evaluate`: of fewer each takes longer, and a curvature takes some 400
ROWS = 256
BLOCK = 50  # iterations per call of `advance`
"""Chains run in blocks: between them progress is reported and an interrupt is handled."""

# Good coordinates need trees of depth 3. A target that wants more than 63 leapfrogs a draw is not
# the one they were made for: better a run that ends soon and fails its checks than one that does not.
_MAX_TREE_DEPTH = 6

# Run a few times each: compiling them well would take longer than they do.
_SELDOM = dict.fromkeys(("inputs", "levels", "solve_back", "propagate", "prior", "paths"), 0)
# At the default level, 3, what runs through batches takes half as long again (measured).
_LEVELS = _SELDOM | {"reached": 1, "evaluate": 1, "simulate": 1}

# XLA compiles outside Python's lock, so two programs compile at once
_COMPILERS = ThreadPoolExecutor(2, thread_name_prefix="compile")


class Programs:
    """The programs of a target, each compiled once.

    Args:
        target: what they compute.
    """

    compile_seconds = 0.0  # of all structures: tracing, and waiting for the compiler

    def __init__(self, target: Target) -> None:
        self.target = target
        self.structure = target.structure
        self._programs: dict[str, Future[Any]] = {}
        self._anew: dict[str, Callable[[], Future[Any]]] = {}
        # draws are weighed in threads: one traces, or waits for a compiler, and the others for it
        self._one_prepares = Lock()

    def __call__(self, name: str, *arguments: Any) -> Any:
        """Run one of the target's `functions`."""
        with self._one_prepares:
            self.expect(name, *arguments)
            program = self._finished(name)
        return program(*arguments)

    def expect(self, name: str, *arguments: Any) -> None:
        """Have a program loaded, or compiled in the background, for arguments of these shapes.

        An argument may be a function that makes it, called only where the program is not yet kept.
        """

        def lower() -> jax.stages.Lowered:
            made = [a() if callable(a) else a for a in arguments]
            return jax.jit(self.target.functions[name]).lower(*made)

        self._submit(name, lower)

    def sampler(
        self, warmup: int, target_accept: float, *example: Any
    ) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """NUTS: how to start a chain, and how to advance it by a block.

        Args:
            warmup: iterations that adapt the step size.
            target_accept: acceptance that they aim for.
            example: data and transform, of which only the shapes matter.

        Returns:
            start(key, w, potential, gradient, data, transform) -> state and
            advance(state, data, transform) -> (state, records of BLOCK iterations).
        """

        def potential_of(
            data: Data, transform: rest_pose.TransformParameters
        ) -> Callable[[Array], Array]:
            return lambda w: self.target.steered(w, data, transform)

        initial, step = hmc(potential_fn_gen=potential_of, algo="NUTS")

        def first(key: Array, w: Array, potential: Array, gradient: Array, *arguments: Any) -> Any:
            return initial(
                ParamInfo(w, potential, gradient),
                num_warmup=warmup,
                step_size=0.7,
                target_accept_prob=target_accept,
                max_tree_depth=_MAX_TREE_DEPTH,
                model_args=arguments,
                rng_key=key,
            )

        def advance(state: Any, data: Data, transform: rest_pose.TransformParameters) -> Any:
            def iterate(state: Any, _: None) -> tuple[Any, dict[str, Array]]:
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

        which = f"{warmup} {target_accept}"

        def start(*arguments: Any) -> Any:
            self._finished(f"advance {which}")  # waited for once, not in every chain's thread
            return self._finished(f"start {which}")(*arguments)

        def advance_compiled(state: Any, *arguments: Any) -> Any:
            return self._finished(f"advance {which}")(state, *arguments)

        n = transform_of(self.structure).size(self.structure)
        nowhere = (jax.random.key(0), np.zeros(n), 0.0, np.zeros(n), *example)
        self._submit(f"start {which}", lambda: jax.jit(first).lower(*nowhere))
        self._submit(
            f"advance {which}",
            lambda: jax.jit(advance).lower(jax.eval_shape(first, *nowhere), *example),
        )
        return start, advance_compiled

    def _submit(self, name: str, lower: Callable[[], jax.stages.Lowered]) -> None:
        """Loaded elsewhere where it is kept; else traced here and now, and compiled elsewhere."""
        if name in self._programs:
            return
        path = disk_cache.path_of(self.structure, name)
        # unlike Path.exists, this raises nothing where nothing may be read
        if path and os.path.exists(path):
            self._programs[name] = _COMPILERS.submit(disk_cache.load, path)
            self._anew[name] = lambda: self._compile(name, lower, path)
        else:
            self._programs[name] = self._compile(name, lower, path)

    def _compile(
        self, name: str, lower: Callable[[], jax.stages.Lowered], path: Path | None
    ) -> Future[Any]:
        begin = time.perf_counter()
        lowered = lower()  # in the caller's thread: tracing is not safe in two
        Programs.compile_seconds += time.perf_counter() - begin

        def build() -> Callable[..., Any]:
            level = _LEVELS.get(name)
            options = None if level is None else {"xla_backend_optimization_level": level}
            program = lowered.compile(options)
            if path:
                disk_cache.save(path, program)
            return program

        return _COMPILERS.submit(build)

    def _finished(self, name: str) -> Callable[..., Any]:
        begin = time.perf_counter()
        program = self._programs[name].result()
        if program is None:  # what was kept does not load
            self._programs[name] = self._anew[name]()
            program = self._programs[name].result()
        Programs.compile_seconds += time.perf_counter() - begin
        return program


def in_chunks(function: Callable[[Any], Any], values: Any, size: int = CHUNK) -> Any:
    """Call a program of fixed batch size over any number of draws, in threads.

    Args:
        function: takes so many draws as `size`, and gives arrays with a row for each.
        values: array, or tree of arrays, with a row for each draw.
        size: of a batch.

    Returns:
        What the function gives, for all draws.
    """
    count = len(jax.tree.leaves(values)[0])

    def one(i: int) -> Any:
        index = np.minimum(np.arange(i, i + size), count - 1)  # the last batch repeats its end
        out = function(jax.tree.map(lambda v: v[index], values))
        return jax.tree.map(lambda v: np.asarray(v)[: count - i], out)

    if count <= size:
        return one(0)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return jax.tree.map(
            lambda *parts_: np.concatenate(parts_), *pool.map(one, range(0, count, size))
        )


# a kernel lets a process have some 65 000 memory maps, and those of a structure take 5000
@lru_cache(maxsize=8)
def programs_for(structure: Structure) -> Programs:
    """The programs of a structure, made once a session."""
    known = programs_for.cache_info()
    if known.currsize == known.maxsize:
        gc.collect()  # those no longer kept hold on to themselves
    return Programs(Target(structure))
