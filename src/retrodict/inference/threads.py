"""Linear algebra on one thread, beside programs that take every core.

BLAS's own threads wait for more work by spinning, some hundredths of a second after each product.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache

import scipy.linalg.blas  # noqa: F401  it has a BLAS of its own, to be found loaded
from threadpoolctl import ThreadpoolController

_controller = cache(ThreadpoolController)  # looking for the libraries takes 5 ms


def one_blas_thread() -> AbstractContextManager[object]:
    """A context in which BLAS has one thread."""
    limited: AbstractContextManager[object] = _controller().limit(limits=1, user_api="blas")
    return limited
