"""Libraries that only an extra needs, and one that a command without JAX is better without."""

from __future__ import annotations

import re
import sys
from importlib import import_module
from importlib.metadata import requires
from typing import Any


class MissingLibrary(ImportError):
    """A library of an extra is not installed; the message says how to install it."""


def imported(module: str, what: str, extra: str = "documents") -> Any:
    """A module of an extra.

    Args:
        module: name of the module.
        what: thing that needs the module, in words, such as "a PDF".
        extra: name of the extra that installs the module.

    Returns:
        The module.

    Raises:
        MissingLibrary: the module is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise MissingLibrary(
            f"{what} needs the package {module}: run pip install {' '.join(_packages(extra))} "
            "in the environment that retrodict runs in (uv pip install … in one that uv made)"
        ) from None


def _packages(extra: str) -> list[str]:
    """The packages of an extra, quoted for a shell: retrodict itself may be on no package index."""
    needed = (text.partition(";") for text in requires("retrodict") or ())
    mark = re.compile(rf"""extra == ['"]{extra}['"]""")
    return [f"'{package.strip()}'" for package, _, marker in needed if mark.search(marker)]


def arviz_without_jax() -> None:
    """Import ArviZ in a command that does not compute with JAX, and keep JAX from being loaded.

    ArviZ leaves stand-ins for jax and numpyro among the loaded modules. SciPy and matplotlib ask there
    whether an array is one of JAX's, and would load it: a third of what drawing takes, and 130 MB.
    """
    import arviz_stats  # noqa: F401

    if "jax._src" not in sys.modules:  # else it is in use
        for stand_in in ("jax", "numpyro"):
            sys.modules.pop(stand_in, None)
