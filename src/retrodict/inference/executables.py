"""Compiled programs kept on disk whole, so that a later process neither traces nor compiles them.

JAX's own cache spares the compiler only, and tracing takes seconds too.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import platform
import shutil
import tempfile
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
import platformdirs
from jax.experimental.serialize_executable import deserialize_and_load, serialize

from retrodict import models

_GENERATIONS = 3  # of folders kept: one for each state of the code and machine that was used


def path_of(*what: object) -> Path | None:
    """Where the program that this describes is kept; None where JAX is told to keep nothing."""
    if not jax.config.jax_enable_compilation_cache:
        return None
    name = hashlib.sha256(repr(what).encode()).hexdigest()[:32]
    return _folder() / f"{name}.bin"


def load(path: Path) -> Any:
    """The program kept there, ready to be called; None where there is none, or none that loads."""
    try:
        # trusted input: whoever can write it can run code, so it is the user's own, never a scene's
        return deserialize_and_load(*pickle.loads(path.read_bytes()))
    except Exception:  # whatever is wrong with a cache, the mend is to compile again
        return None


def save(path: Path, program: jax.stages.Compiled) -> None:
    """Keep a program; where that cannot be, the next process will compile it again."""
    # calling LAPACK crashes in a process that has not compiled a call of it
    if "lapack" in (program.as_text() or ""):
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(pickle.dumps(serialize(program)))
        os.replace(file.name, path)
    except Exception:  # a full disk, a program that cannot be serialised
        return
    generations = sorted(path.parent.parent.iterdir(), key=lambda p: p.stat().st_mtime)
    for old in generations[:-_GENERATIONS]:
        shutil.rmtree(old, ignore_errors=True)


@lru_cache(maxsize=1)
def _folder() -> Path:
    """Of the programs that this code makes on this machine with these libraries."""
    state = hashlib.sha256()
    for root in (Path(__file__).parents[1], Path(models.__file__).parent):
        for source in sorted(root.rglob("*.py")):
            state.update(source.read_bytes())
    libraries = [version(name) for name in ("jax", "jaxlib", "numpyro")]
    for fact in (*libraries, platform.python_version(), _processor(), os.environ.get("XLA_FLAGS")):
        state.update(repr(fact).encode())
    return Path(platformdirs.user_cache_dir("retrodict")) / "programs" / state.hexdigest()[:16]


def _processor() -> str:
    """What tells processors apart that cannot run each other's programs."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return next((line for line in lines if line.startswith(("flags", "Features"))), "")
