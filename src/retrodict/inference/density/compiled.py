"""The compiled programs of a rung and a scene's structure; numbers come in as arguments.

Two scenes of one structure share them, and the user's cache directory keeps them between runs, so
that only the first run of a structure pays for compilation.
"""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from threading import Lock, RLock
from typing import Any

import jax
import numpy as np
from jaxlib.mlir.passmanager import PassManager

from retrodict.inference.density import disk_cache
from retrodict.inference.density.kernels import CHUNK, Kernel
from retrodict.inference.density.log_density import Target
from retrodict.inference.threads import cores
from retrodict.models.arrays import Structure
from retrodict.models.standard_normal import TRACING

# XLA compiles outside Python's lock, so two programs compile at once
_COMPILERS = ThreadPoolExecutor(2, thread_name_prefix="compile")
# kept programs load one after another: two at once took 65 MB more at the peak (measured)
_LOADER = ThreadPoolExecutor(1, thread_name_prefix="load")


class Stopwatch:
    """Total of seconds, to which several threads may add."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._one_adds = Lock()

    @contextmanager
    def running(self) -> Iterator[None]:
        """A context whose duration is added to the total."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            with self._one_adds:
                self.seconds += time.perf_counter() - begin


COMPILATION = Stopwatch()
"""Tracing, and waiting for the compiler: of the process, as compiled programs are."""


class Programs:
    """The compiled kernels of a target, each made once.

    Args:
        target: posterior whose functions are compiled.
    """

    def __init__(self, target: Target) -> None:
        self.target = target
        self.structure = target.structure
        self._programs: dict[str, Future[Any]] = {}
        self._anew: dict[str, Callable[[], Future[Any]]] = {}
        # draws are evaluated in threads: one traces, or waits for a compiler, and the others for it
        self._one_prepares = RLock()

    def __call__[**P, R](self, kernel: Kernel[P, R], *arguments: P.args, **_: P.kwargs) -> R:
        """Run a kernel."""
        with self._one_prepares:
            self.expect(kernel, *arguments)
            program = self._finished(kernel.name)
        return program(*arguments)

    def function[**P, R](self, kernel: Kernel[P, R]) -> Callable[P, R]:
        """A kernel's function, not compiled."""
        return partial(kernel.function, self.target)

    def expect(self, kernel: Kernel[..., Any], *arguments: Any) -> None:
        """Have a kernel loaded, or compiled in the background, for arguments of these shapes.

        An argument may be a function that returns the value, called only if the program is not on disk.
        """
        with self._one_prepares:
            if kernel.name in self._programs:
                return
            # what the user's own code does, no digest of a structure tells
            of_python = self.structure.of_python
            path = None if of_python else disk_cache.path_of(self.structure, kernel.name)
            compile_ = partial(self._compile, kernel, arguments, path)
            # unlike Path.exists, this raises nothing where nothing may be read
            if path and os.path.exists(path):
                self._programs[kernel.name] = _LOADER.submit(disk_cache.load, path)
                self._anew[kernel.name] = compile_
            else:
                self._programs[kernel.name] = compile_()

    def unload(self) -> None:
        """Give back the memory of all kernels; one that is run again is loaded again."""
        with self._one_prepares:
            self._programs.clear()
            self._anew.clear()

    def _compile(
        self, kernel: Kernel[..., Any], arguments: tuple[Any, ...], path: Path | None
    ) -> Future[Any]:
        """Trace a kernel here, which is not safe in two threads, and compile it in the background."""
        with COMPILATION.running(), TRACING:
            made = [a() if callable(a) else a for a in arguments]
            lowered = jax.jit(self.function(kernel)).lower(*made)
            # names of operations are a fifth of what a kept program holds, and of its loading
            module = lowered.compiler_ir()
            assert module is not None
            with module.context:
                PassManager.parse("builtin.module(strip-debuginfo)").run(module.operation)

        def build() -> Callable[..., Any]:
            level = kernel.level
            options = None if level is None else {"xla_backend_optimization_level": level}
            program = lowered.compile(options)
            if path:
                disk_cache.save(path, program)
            return program

        return _COMPILERS.submit(build)

    def _finished(self, name: str) -> Callable[..., Any]:
        with COMPILATION.running():
            program = self._programs[name].result()
        if program is None:  # the program on disk does not load
            self._programs[name] = self._anew[name]()
            return self._finished(name)
        return program


def in_chunks(function: Callable[[Any], Any], values: Any, size: int = CHUNK) -> Any:
    """Call a program of fixed batch size over any number of draws, in threads.

    Args:
        function: program of `size` draws that returns arrays with a row for each.
        values: array, or tree of arrays, with a row for each draw.
        size: number of draws in a batch.

    Returns:
        The results of the function, with a row for each draw.
    """
    count = len(jax.tree.leaves(values)[0])

    def one(i: int) -> Any:
        index = np.minimum(np.arange(i, i + size), count - 1)  # the last batch repeats its end
        out = function(jax.tree.map(lambda v: v[index], values))
        return jax.tree.map(lambda v: np.asarray(v)[: count - i], out)

    if count <= size:
        return one(0)
    begins = range(0, count, size)
    if cores() == 1:
        chunks = [one(i) for i in begins]
    else:
        with ThreadPoolExecutor(cores()) as pool:
            chunks = list(pool.map(one, begins))
    return jax.tree.map(lambda *parts_: np.concatenate(parts_), *chunks)


def programs_for(structure: Structure) -> Programs:
    """The programs of a structure; a process keeps those of the 8 structures last used."""
    return _programs_on(disk_cache.platform_here(), structure)


# Linux allows a process some 65 000 memory maps, and the programs of a structure take 5000
@lru_cache(maxsize=8)
def _programs_on(platform: str, structure: Structure) -> Programs:
    known = _programs_on.cache_info()
    if known.currsize == known.maxsize:
        gc.collect()  # evicted programs are in reference cycles
    return Programs(Target(structure))
