"""Libraries that only an extra needs."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class MissingLibrary(ImportError):
    """A library of an extra is not installed; the message says how to install it."""


def imported(module: str, what: str, extra: str = "documents") -> Any:
    """A module of an extra.

    Args:
        module: its name.
        what: needs it, in words.
        extra: that brings it.

    Returns:
        The module.

    Raises:
        MissingLibrary: it is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise MissingLibrary(
            f"{what} needs the package {module}: install it with pip install 'retrodict[{extra}]'"
        ) from None
