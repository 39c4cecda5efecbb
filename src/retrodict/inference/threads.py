"""Numbers of threads: programs take every core, and linear algebra beside them one thread.

BLAS's own threads wait for more work by spinning, some hundredths of a second after each product. Two
reconstructions in two threads took 2.1 times the time of one after the other by that, and 1.3 to 2 with
this; with OPENBLAS_NUM_THREADS=1 in the environment, by which these threads are never made, 0.8.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any

import scipy.linalg.blas  # noqa: F401  it has a BLAS of its own, to be found loaded
from threadpoolctl import ThreadpoolController

_controller = cache(ThreadpoolController)  # looking for the libraries takes 5 ms
_changes = Lock()
_inside: list[Any] = []  # what restores BLAS, once for each caller within: the last one uses it


def cores() -> int:
    """Number of cores that XLA takes for its own threads: NPROC in the environment, or all."""
    return int(os.environ.get("NPROC") or os.cpu_count() or 1)


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """A context in which BLAS has one thread; callers may overlap."""
    with _changes:
        _inside.append(_inside[0] if _inside else _controller().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _changes:
            limit = _inside.pop()
            if not _inside:
                limit.restore_original_limits()
