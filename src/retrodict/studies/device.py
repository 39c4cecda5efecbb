"""Which device JAX computes on."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import jax

DEVICES = ("cpu", "gpu")


class NoDevice(ValueError):
    """A device that JAX does not find; the message says what to do."""


def choose(device: str) -> None:
    """Have this process compute on a device.

    Args:
        device: a name in `DEVICES`; with "cpu" the environment variable JAX_PLATFORMS takes precedence.

    Raises:
        ValueError: there is no such device.
        NoDevice: JAX finds none.
    """
    if device not in DEVICES:
        raise ValueError(f"device is one of {', '.join(DEVICES)}; not {device!r}")
    if device == "cpu":
        if "JAX_PLATFORMS" not in os.environ:
            jax.config.update("jax_platforms", "cpu")
        return
    # several workers share a device: none takes all of its memory
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    try:
        jax.config.update("jax_default_device", jax.devices("gpu")[0])
    except RuntimeError:
        raise NoDevice(
            "JAX finds no GPU here: install jax[cuda13] or jax[rocm7] on a machine that has one, or "
            "choose cpu"
        ) from None


@contextmanager
def processor() -> Iterator[None]:
    """A context in which a process that computes on a GPU computes on the processor."""
    before = jax.config.jax_default_device
    jax.config.update("jax_default_device", jax.devices("cpu")[0])
    try:
        yield
    finally:
        jax.config.update("jax_default_device", before)
