"""Libraries that only some documents need."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class MissingLibrary(ImportError):
    """A library of an extra is not installed; the message says how to install it."""


def imported(module: str, what: str) -> Any:
    """A module of the extra `documents`.

    Args:
        module: its name.
        what: is written with it, in words.

    Returns:
        The module.

    Raises:
        MissingLibrary: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise MissingLibrary(
            f"{what} needs the package {module}: install it with pip install 'retrodict[documents]'"
        ) from None
