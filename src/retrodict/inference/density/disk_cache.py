"""Compiled programs kept on disk whole, so that a later process neither traces nor compiles them.

JAX's own cache spares the compiler only, and tracing takes seconds too.

A file holds a pickle, which runs code as it loads. So only files are read that this user owns and nobody
else may write, and that begin with a digest of their place and content: a damaged or swapped program
could also give other numbers without a word. Whatever is wrong with a cache, the fix is to compile.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import pickle
import platform
import shutil
import stat
import tempfile
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
import platformdirs
from jax.experimental.serialize_executable import deserialize_and_load, serialize

from retrodict import models

_DIGEST = hashlib.sha256().digest_size
_GENERATIONS = 3  # number of folders kept, one for each recent state of the code and machine


def path_of(*what: object) -> Path | None:
    """Path of the program that `what` describes; None where JAX's compilation cache is switched off."""
    if not jax.config.jax_enable_compilation_cache:
        return None
    name = hashlib.sha256(repr(what).encode()).hexdigest()[:32]
    return _folder(platform_here()) / f"{name}.bin"


def load(path: Path) -> Any:
    """The program at a path, ready to be called; None where there is none that can be trusted."""
    try:
        with path.open("rb") as file:
            if not (_ours(os.fstat(file.fileno())) and _ours(path.parent.stat())):
                return None
            digest, content = file.read(_DIGEST), file.read()
        if digest != _digest(path, content):
            return None
        program = deserialize_and_load(*pickle.loads(content))
        _give_back_memory()
        return program
    except Exception:  # unpickling a file of another version may raise any
        return None


def save(path: Path, program: jax.stages.Compiled) -> None:
    """Write a program to disk; where that fails, the next process will compile it again."""
    # calling LAPACK crashes in a process that has not compiled a call of it
    if "lapack" in (program.as_text() or ""):
        return
    temporary = None
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        content = pickle.dumps(serialize(program))
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            temporary = Path(file.name)
            file.write(_digest(path, content) + content)
        os.replace(temporary, path)
        generations = sorted(path.parent.parent.iterdir(), key=lambda p: p.lstat().st_mtime)
        for old in generations[:-_GENERATIONS]:
            shutil.rmtree(old, ignore_errors=True)
    except Exception:  # a full disk, a program that cannot be serialised
        if temporary:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


def _give_back_memory() -> None:
    """Return memory that XLA freed after reading a program but glibc keeps: 200 MB of 1 GB, measured."""
    with suppress(AttributeError, OSError, TypeError):  # another C library
        ctypes.CDLL(None).malloc_trim(0)


def _digest(path: Path, content: bytes) -> bytes:
    """Digest of a program and the path that it is kept at."""
    place = f"{path.parent.name}/{path.name}/".encode()
    return hashlib.sha256(place + content).digest()


def _ours(facts: os.stat_result) -> bool:
    """Whether nobody but this user can have written to the file or folder."""
    if not hasattr(os, "getuid"):  # Windows keeps a user's cache from others by its folder
        return True
    others = stat.S_IWGRP | stat.S_IWOTH
    return facts.st_uid == os.getuid() and not facts.st_mode & others


def platform_here() -> str:
    """JAX's name of the platform that this process computes on."""
    device = jax.config.jax_default_device
    return jax.default_backend() if device is None else device.platform


@lru_cache(maxsize=2)
def _folder(on: str) -> Path:
    """Folder of the programs that this code makes on this machine's platform with these libraries."""
    state = hashlib.sha256()
    package = Path(__file__).parents[2]
    of_package = [package / part for part in ("mechanics", "scene", "inference")]
    for root in (*of_package, Path(models.__file__).parent):
        for source in sorted(root.rglob("*.py")):
            state.update(source.read_bytes())
    libraries = [version(name) for name in ("jax", "jaxlib", "numpyro")]
    machine = (on, _processor(), os.environ.get("XLA_FLAGS"))
    for fact in (*libraries, platform.python_version(), *machine):
        state.update(repr(fact).encode())
    return Path(platformdirs.user_cache_dir("retrodict")) / "programs" / state.hexdigest()[:16]


def _processor() -> str:
    """Text that distinguishes processors that cannot run each other's programs."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return next((line for line in lines if line.startswith(("flags", "Features"))), "")
