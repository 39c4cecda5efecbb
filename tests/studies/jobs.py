"""Jobs that tests have workers do: a worker imports them from here."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import psutil

from retrodict.inference import threads


def squared(number: int) -> int:
    return number**2


def deadly(number: int) -> int:
    """Ends its process at 3."""
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def deadly_once(file: Path) -> int:
    """Ends its process the first time."""
    if not file.exists():
        file.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


def refusing(number: int) -> int:
    raise ZeroDivisionError(f"of {number}")


def listening(_: int) -> set[str]:
    """The addresses at which a worker, or the process that began it, listens."""
    own = psutil.Process()
    every = [*own.net_connections(), *own.parent().net_connections()]
    return {c.laddr.ip for c in every if c.status == psutil.CONN_LISTEN}


def cores(_: int) -> int:
    return threads.cores()
