"""Crashes of many scenes in few calls: each scene is worked on in a thread of its own, and asks here.

A device takes nearly as long for 500 crashes as for 50 000. The search, the coordinates and the points
of one scene ask for some hundreds of crashes at a time, some tens of times. Here the requests of many
scenes wait for each other, and one call answers them: the algorithm is that of one scene, written once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextvars import ContextVar, copy_context
from dataclasses import dataclass, field
from functools import cache, partial
from threading import Condition, Event, Thread
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from retrodict.inference.density.compiled import Programs
from retrodict.inference.density.kernels import Kernel
from retrodict.inference.density.log_density import Target
from retrodict.models.arrays import Data, Structure, steps_of
from retrodict.models.standard_normal import TRACING

Crashes = tuple[np.ndarray, dict[str, np.ndarray]]
"""Log likelihoods of crashes, and their quantities by name."""

SCENES = 64  # different numbers of scenes that a call takes
_ANSWERED = 0.5  # share of the scenes under way whose requests a call waits for


@dataclass(frozen=True)
class Calls:
    """Sizes of the calls of a device, by default such that they fill a GPU, and how many were made.

    Args:
        rows: crashes of a call.
        block: crashes of a call that are computed side by side.
        made: number of calls so far, a single entry.
        crashes: number of crashes asked for so far, a single entry.
    """

    rows: int = 32_768
    block: int = 32_768
    made: list[int] = field(default_factory=lambda: [0])
    crashes: list[int] = field(default_factory=lambda: [0])


@dataclass
class _Request:
    """Crashes that a scene's thread waits for."""

    programs: Programs
    data: Data
    u: Float[np.ndarray, "crashes n"]
    names: frozenset[str] | None
    done: Event = field(default_factory=Event)
    found: Crashes | None = None
    error: BaseException | None = None


class Together:
    """Jobs that run in threads, and whose requests for crashes are answered together.

    Args:
        calls: sizes of the device's calls.
    """

    def __init__(self, calls: Calls) -> None:
        self._calls = calls
        self._changed = Condition()
        self._requests: list[_Request] = []
        self._under_way = 0
        self._ended = False
        # by identity, with what keeps it: many requests are of one scene
        self._vectors: dict[int, tuple[Data, np.ndarray]] = {}
        self._likes: dict[tuple[Structure, int], Data] = {}

    def results[T](self, jobs: Sequence[Callable[[], T]]) -> list[T]:
        """What each job returns, in order.

        Args:
            jobs: functions without arguments, which run at the same time.

        Raises:
            BaseException: what the first job that failed has raised; the others came to their ends.
        """
        found: list[Any] = [None] * len(jobs)
        failed: list[BaseException] = []
        threads = [
            Thread(target=copy_context().run, args=(self._work, job, found, i, failed), daemon=True)
            for i, job in enumerate(jobs)
        ]
        self._under_way = len(threads)
        for thread in threads:
            thread.start()
        try:
            for requests in self._waiting():
                self._answer(requests)
        finally:
            self._give_up()
        for thread in threads:
            thread.join()
        if failed:
            raise failed[0]
        return found

    def at(
        self,
        programs: Programs,
        data: Data,
        u: Float[np.ndarray, "crashes n"],
        names: frozenset[str] | None = None,
    ) -> Crashes:
        """Log likelihoods and quantities of crashes of a scene, from a call that answers others too.

        Args:
            programs: compiled programs of the scene's structure.
            data: numbers of the scene.
            u: deviates, shape (crashes, n).
            names: quantities that are needed; None for all.
        """
        request = _Request(programs, data, u, names)
        with self._changed:
            if self._ended:
                raise KeyboardInterrupt
            self._requests.append(request)
            self._changed.notify_all()
        request.done.wait()
        if request.error is not None:
            raise request.error
        assert request.found is not None, "a request is answered or fails"
        return request.found

    def _work(
        self, job: Callable[[], Any], found: list[Any], i: int, failed: list[BaseException]
    ) -> None:
        _ROOM.set(self)
        try:
            found[i] = job()
        except BaseException as error:
            failed.append(error)
        finally:
            with self._changed:
                self._under_way -= 1
                self._changed.notify_all()

    def _waiting(self) -> Iterator[list[_Request]]:
        """Requests as enough of the threads under way wait for them, until all threads have ended."""

        def ready() -> bool:
            return len(self._requests) >= max(1, _ANSWERED * self._under_way) or not self._under_way

        while True:
            with self._changed:
                self._changed.wait_for(ready)
                requests, self._requests = self._requests, []
            if not requests:
                return
            yield requests

    def _answer(self, requests: list[_Request]) -> None:
        alike: dict[tuple[Structure, int, frozenset[str] | None], list[_Request]] = {}
        for request in requests:
            structure = request.programs.structure
            key = structure, steps_of(structure, request.data), request.names
            alike.setdefault(key, []).append(request)
        for some in alike.values():
            try:
                for few in _of_few_scenes(some):
                    self._answer_alike(few)
            except BaseException as error:
                for request in some:
                    request.error = request.error or error
                    request.done.set()
                if not isinstance(error, Exception):
                    raise

    def _answer_alike(self, requests: list[_Request]) -> None:
        """Answer requests of one structure, number of steps and names, of at most `SCENES` data."""
        programs, data, names = requests[0].programs, requests[0].data, requests[0].names
        different = {id(request.data): request.data for request in requests}
        numbers = {key: i for i, key in enumerate(different)}
        vectors = np.stack([self._vector(each) for each in different.values()])
        vectors = vectors[np.minimum(np.arange(SCENES), len(vectors) - 1)]
        of = np.concatenate([np.full(len(r.u), numbers[id(r.data)]) for r in requests])
        u = np.concatenate([np.asarray(r.u, float) for r in requests])
        rows, kernel = self._calls.rows, _kernel(self._calls.rows, self._calls.block, names)
        on_device = jax.device_put(vectors), self._like(programs.structure, data)
        parts = []
        for begin in range(0, len(u), rows):
            missing = max(0, begin + rows - len(u))
            some = np.pad(of[begin : begin + rows], (0, missing), "edge")
            own = np.pad(u[begin : begin + rows], ((0, missing), (0, 0)), "edge")
            parts.append(programs(kernel, *on_device, some, own))
        self._calls.made[0] += len(parts)
        self._calls.crashes[0] += len(u)
        table = np.concatenate([np.asarray(part) for part in parts], axis=1)
        columns = _columns(programs, data, names)
        begin = 0
        for request in requests:
            count = len(request.u)
            own = table[:, begin : begin + count].copy()
            begin += count
            quantities = {
                name: own[where].T.reshape(count, *shape) for name, where, shape in columns
            }
            request.found = own[0], quantities
            request.done.set()

    def _vector(self, data: Data) -> Float[np.ndarray, " numbers"]:
        """The numbers of a scene in a row, but for the integration steps."""
        if id(data) not in self._vectors:
            leaves = jax.tree.leaves(_without_steps(data))
            self._vectors[id(data)] = data, np.concatenate([np.ravel(leaf) for leaf in leaves])
        return self._vectors[id(data)][1]

    def _like(self, structure: Structure, data: Data) -> Data:
        """Numbers on the device whose shapes and steps are those of all scenes alike."""
        key = structure, steps_of(structure, data)
        if key not in self._likes:
            self._likes[key] = jax.device_put(data)
        return self._likes[key]

    def _give_up(self) -> None:
        """Let no thread wait for ever."""
        with self._changed:
            requests, self._requests = self._requests, []
            self._ended = True
        for request in requests:
            request.error = KeyboardInterrupt()
            request.done.set()


_ROOM: ContextVar[Together | None] = ContextVar("together", default=None)


def room() -> Together | None:
    """Where this thread's scene asks for crashes together with others; None where it is alone."""
    return _ROOM.get()


def _of_few_scenes(requests: list[_Request]) -> Iterator[list[_Request]]:
    """The requests in groups of at most `SCENES` different data."""
    some: list[_Request] = []
    known: set[int] = set()
    for request in requests:
        if len(known | {id(request.data)}) > SCENES:
            yield some
            some, known = [], set()
        some.append(request)
        known.add(id(request.data))
    yield some


def _without_steps(data: Data) -> Data:
    return data._replace(steps=())  # type: ignore[arg-type]  # a tree without leaves there


def _data(vector: Float[Array, " numbers"], like: Data) -> Data:
    """A scene's numbers from their row; shapes and integration steps as of another."""
    leaves, tree = jax.tree.flatten(_without_steps(like))
    ends = np.cumsum([np.size(leaf) for leaf in leaves])
    own = [
        vector[end - np.size(leaf) : end].reshape(np.shape(leaf))
        for leaf, end in zip(leaves, ends, strict=True)
    ]
    return jax.tree.unflatten(tree, own)._replace(steps=like.steps)


def _crashes_of_many(
    target: Target,
    vectors: Float[Array, "scenes numbers"],
    like: Data,
    of: Int[Array, " crashes"],
    u: Float[Array, "crashes n"],
    *,
    block: int,
    names: frozenset[str] | None,
) -> Float[Array, "columns crashes"]:
    """Log likelihood and quantities of crashes of many scenes, a column for each, as of `_columns`."""

    def one(row: tuple[Array, Array]) -> Array:
        log_likelihood, quantities = target.crash(row[1], _data(vectors[row[0]], like))
        quantities = {k: v for k, v in quantities.items() if names is None or k in names}
        return jnp.concatenate([log_likelihood[None], *map(jnp.ravel, jax.tree.leaves(quantities))])

    return jax.lax.map(one, (of, u), batch_size=block).T


@cache
def _kernel(rows: int, block: int, names: frozenset[str] | None) -> Kernel[..., Array]:
    # a structure has one set of names that its residuals follow from
    kind = "crashes" if names is None else "residuals"
    name = f"{kind} of {SCENES} scenes, {rows} by {block}"
    return Kernel(name, partial(_crashes_of_many, block=block, names=names), 1)


def _columns(
    programs: Programs, data: Data, names: frozenset[str] | None
) -> list[tuple[str, slice, tuple[int, ...]]]:
    """Names, rows and shapes of the quantities in a column of `_crashes_of_many`."""
    known = _KNOWN_COLUMNS.setdefault(programs.structure, {})
    if names not in known:
        u = jax.ShapeDtypeStruct((programs.structure.deviates,), float)
        with TRACING:
            shapes = jax.eval_shape(programs.target.crash, u, data)[1]
        found, begin = [], 1
        for name in sorted(shapes):  # the order of a tree's leaves
            if names is None or name in names:
                size = int(np.prod(shapes[name].shape))
                found.append((name, slice(begin, begin + size), shapes[name].shape))
                begin += size
        known[names] = found
    return known[names]


Columns = list[tuple[str, slice, tuple[int, ...]]]
_KNOWN_COLUMNS: dict[Structure, dict[frozenset[str] | None, Columns]] = {}
