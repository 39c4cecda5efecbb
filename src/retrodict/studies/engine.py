"""Runs a job on many items: one after the other, in processes of this machine, or on a cluster.

Processes and clusters are Dask's (`distributed`). A job, its items and its results are pickled, so a
script that starts processes does it under `if __name__ == "__main__":`.
"""

from __future__ import annotations

import logging
import os
import signal
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from distributed import Client

_DEATHS = 2  # worker deaths that a task may meet by chance, as from a neighbour's use of memory
_MEMORY = 2 * 2**30  # bytes that a worker takes with the programs of a scene's structure
# bytes that a worker may always take: not all need as much at once
_LIMIT = 4 * 2**30
_ANSWERS_WITHIN = 10  # s: timeout of the connection to a scheduler
_SETTINGS = {
    # a worker's memory is compiled programs, which cannot be spilled: one that was paused would wait
    # for ever
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.profile.enabled": False,
    # a worker is a core: where XLA takes all in each, a scene takes a third more of them (measured)
    "distributed.nanny.pre-spawn-environ.NPROC": 1,
    # else a worker that takes longer to be begun anew is given up
    "distributed.deploy.lost-worker-timeout": "1 h",
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
_LOGGERS = ("distributed", "tornado", "asyncio")


class WorkerDied(RuntimeError):
    """A job ended the process of every worker that ran it, as one that needs too much memory does."""


class NoScheduler(ConnectionError):
    """There is no scheduler at an address, or none that can be used; the message says so."""


def default_workers() -> int:
    """Number of workers: one for each core that has the memory; one where Dask is not installed."""
    if find_spec("distributed") is None:
        return 1
    from dask.system import CPU_COUNT
    from distributed.system import MEMORY_LIMIT

    return max(1, min(CPU_COUNT, MEMORY_LIMIT // _MEMORY))


@contextmanager
def engine(workers: int | None = None, scheduler: str | None = None) -> Iterator[Engine]:
    """A context in which jobs run on many items; workers of its own end with it.

    Args:
        workers: number of processes of this machine; 1 for this process alone, None for
            `default_workers`.
        scheduler: address of the scheduler of a running cluster to use instead, such as
            "tcp://127.0.0.1:8786".

    Yields:
        The engine.

    Raises:
        ImportError: Dask is not installed, and more than this process is asked for.
        NoScheduler: nothing answers at the address.
    """
    workers = workers or default_workers()
    if scheduler is None and workers == 1:
        yield Engine(None)
        return
    with ExitStack() as stack:
        stack.enter_context(_quiet())
        client = _connected(scheduler) if scheduler else stack.enter_context(_local(workers))
        stack.callback(client.close)
        yield Engine(client)


class Engine:
    """Runs jobs on many items.

    Args:
        client: Dask client of the scheduler; None for this process alone.
    """

    def __init__(self, client: Client | None) -> None:
        self._client = client

    def each[I, R](
        self,
        job: Callable[[I], R],
        items: Iterable[I],
        more: Callable[[I, R | WorkerDied], Iterable[I]] = lambda item, result: (),
    ) -> Iterator[tuple[I, R | WorkerDied]]:
        """Results of a job as they come, in no order.

        Args:
            job: function applied to each item; an exception that it raises ends the run.
            items: items to be worked on; those in front begin first.
            more: function that gives further items in the light of a result, before the result is
                handed on.

        Yields:
            Each item with its result; or with `WorkerDied`, where its job killed every worker.
        """
        if self._client is None:
            left = deque(items)
            while left:
                item = left.popleft()
                done = job(item)
                left.extend(more(item, done))
                yield item, done
            return
        from distributed import as_completed

        client, items_of = self._client, dict[Any, I]()

        def submitted(items: Iterable[I]) -> list[Any]:
            items = list(items)
            futures = [client.submit(job, item, pure=False) for item in items]
            items_of.update(zip(futures, items, strict=True))
            return futures

        suspects = deque[I]()
        coming = as_completed(submitted(items), loop=client.loop)
        while True:
            for future in coming:
                item = items_of.pop(future)
                result: R | WorkerDied = _result_of(future)
                if isinstance(result, WorkerDied):
                    suspects.append(item)
                    continue
                coming.update(submitted(more(item, result)))
                yield item, result
            if not suspects:
                return
            # it may have waited, each time, at the worker that another one ended: now it is alone
            item = suspects.popleft()
            result = _result_of(client.submit(job, item, pure=False))
            coming = as_completed(submitted(more(item, result)), loop=client.loop)
            yield item, result

    def results[I, R](
        self,
        job: Callable[[I], R],
        items: Iterable[I],
        more: Callable[[I, R | WorkerDied], Iterable[I]] = lambda item, result: (),
    ) -> Iterator[R]:
        """Results of `each` without their items, for jobs that should kill no worker.

        Raises:
            WorkerDied: a job killed its worker, again and again.
        """
        for _, result in self.each(job, items, more):
            if isinstance(result, WorkerDied):
                raise result
            yield result


def _result_of(future: Any) -> Any:
    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker:
        return WorkerDied("its worker process was killed, for example for lack of memory")
    except ImportError as error:
        raise NoScheduler(f"a worker lacks {error.name}: install the same on all of them") from None


def _connected(address: str) -> Client:
    from distributed import Client

    try:
        return Client(address, timeout=_ANSWERS_WITHIN, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        why = str(error).splitlines()[0] if isinstance(error, ValueError) else "nothing answers"
        raise NoScheduler(
            f"{address}: {why}; start `dask scheduler` and write the address that it prints"
        ) from None


@contextmanager
def _local(workers: int) -> Iterator[Client]:
    """A client of worker processes, which listen on the loopback address and to this process alone."""
    import dask
    from distributed import Client, LocalCluster
    from distributed.system import MEMORY_LIMIT

    environment = dict(os.environ)
    with ExitStack() as stack:
        # of what Dask sets for workers
        stack.callback(os.environ.update, environment)
        stack.callback(os.environ.clear)
        stack.enter_context(dask.config.set(_SETTINGS))
        with _no_interrupt():
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                memory_limit=min(MEMORY_LIMIT, max(_LIMIT, MEMORY_LIMIT // workers)),
                host="127.0.0.1",
                security=True,  # else any user of this machine could have it run code
                dashboard_address=None,
                silence_logs=logging.CRITICAL,
                scheduler_kwargs={
                    "allowed_failures": _DEATHS,
                    "dashboard": False,
                    "dashboard_address": "127.0.0.1:0",  # a port it has to have
                },
            )
            stack.enter_context(cluster)
            client = Client(cluster, set_as_default=False)
        yield client


@contextmanager
def _no_interrupt() -> Iterator[None]:
    """A context in which Ctrl-C waits; processes that are begun by threads of it never see it.

    A terminal sends it to workers too, and they would end with tracebacks.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # which lets signals through when it is begun
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _quiet() -> Iterator[None]:
    """A context in which Dask logs nothing: what matters is raised."""
    import distributed  # noqa: F401  which sets its loggers up

    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
