"""Writing files whole, and those of one result or study together: all are old or all are new."""

from __future__ import annotations

import os
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

_STAGING = ".retrodict-"
_FORGOTTEN = 3600.0  # s: nobody takes as long to write results


def write_whole(path: Path, content: bytes) -> Path:
    """Write a file through a temporary neighbour that takes its place at the end.

    Args:
        path: path of the file; its folder is made where missing.
        content: complete content of the file.

    Returns:
        The path.

    Raises:
        OSError: the file could not be written; an existing file is unchanged.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    return path


def write_together(directory: Path, contents: Mapping[str, bytes]) -> None:
    """Write files that belong together: once all are written, each takes its place.

    Args:
        directory: output directory, made where missing; other files in it are left alone.
        contents: content of each file by its path in the directory, in the order in which the files
            take their places.

    Raises:
        OSError: something could not be written; then nothing in the directory has changed.
    """
    made = not directory.exists()
    directory.mkdir(parents=True, exist_ok=True)
    for left in directory.glob(f"{_STAGING}*"):  # by a process that was killed
        with suppress(OSError):  # where another process clears it too
            if time.time() - left.stat().st_mtime > _FORGOTTEN:
                shutil.rmtree(left)
    try:
        staging = Path(tempfile.mkdtemp(prefix=_STAGING, dir=directory))
        try:
            for name, content in contents.items():
                write_whole(staging / name, content)
            with _signals_wait():
                for name in contents:
                    (directory / name).parent.mkdir(exist_ok=True)
                    os.replace(staging / name, directory / name)
        finally:
            shutil.rmtree(staging, ignore_errors=True)
    finally:
        if made:
            with suppress(OSError):  # where it is not empty
                directory.rmdir()


@contextmanager
def _signals_wait() -> Iterator[None]:
    """A context in which signals that end the process wait until it is left."""
    if threading.current_thread() is not threading.main_thread():  # no signal arrives there
        yield
        return
    arrived: list[int] = []
    names = ("SIGINT", "SIGTERM", "SIGHUP")  # not every system has SIGHUP
    ends = [getattr(signal, name) for name in names if hasattr(signal, name)]
    before = {number: signal.signal(number, lambda n, _: arrived.append(n)) for number in ends}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        for number in arrived:
            signal.raise_signal(number)
