"""How far the work is: bars in a terminal or a notebook, plain lines elsewhere.

Neither JAX nor rich is imported before a display asks for it, so that the first line does not wait.
"""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from functools import wraps
from html import escape
from math import inf
from threading import Event, Lock, Thread

Progress = Callable[[str, int, int], None]  # stage, done, total

_START = "starting"
_GRACE = 1.0  # s: a command that is refused sooner prints its reason alone
_BEAT = 0.25  # s between updates of a display
_MOST, _LEAST = 4.0, 1.0  # s between two lines: at most, and at least
_TIMED, _GAINED = 2.0, 0.2  # s, and share of a stage, from which the time left is estimated
_KEPT = 8  # bars of what is finished


def printable(text: str) -> str:
    """A text without characters that steer a terminal: names of files may have them."""
    return "".join(c if c.isprintable() or c in "\n\t" else f"\\x{ord(c):02x}" for c in text)


def silent(stage: str, done: int, total: int) -> None:
    """A progress callback that shows nothing."""


def prefixed(progress: Progress, name: str) -> Progress:
    """A callback for the stages of one part of the work, which names the part before each of them.

    Args:
        progress: callback, called with (stage, done, total).
        name: name of the part.

    Returns:
        The callback.
    """
    return lambda stage, done, total: progress(f"{name}: {stage}", done, total)


@dataclass(frozen=True, slots=True)
class Snapshot:
    """How far the work is at one moment.

    Args:
        stage: present stage of the work; parts and their stages are separated by ": ".
        share: share of the stage that is done, from 0 to 1.
        seconds: time since the work began, s.
        left: time that the stage will still take, s; None where it cannot be estimated.
    """

    stage: str
    share: float
    seconds: float
    left: float | None

    @property
    def line(self) -> str:
        """The snapshot as one line of text."""
        percent = f", {100 * self.share:.0f} %" if 0 < self.share < 1 else ""
        return f"retrodict: {duration(self.seconds)}: {self.stage}{percent}{self.ending}"

    @property
    def ending(self) -> str:
        """The time left in words; empty where it cannot be estimated."""
        return "" if self.left is None else f", about {duration(self.left)} left in this stage"


class Tracker:
    """Follows the stages of the work, and estimates how long the present one will still take.

    Args:
        clock: function that returns the time since any origin, s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._start = self._since = clock()
        self._stage, self._first, self._share = _START, 0.0, 0.0

    def record(self, stage: str, done: int, total: int) -> bool:
        """Take note of (stage, done, total).

        Returns:
            Whether a stage begins.
        """
        # names of folders are among them: no control character or escape sequence may get through
        stage = "".join(c if c.isprintable() else " " for c in stage)
        share = done / total if total > 0 else 0.0
        begins = stage != self._stage
        # It is timed from where something is done: before that it may have waited for a compiler.
        # Less than before: it is done once more.
        if begins or self._share == 0 or share < self._share:
            self._since, self._first = self._clock(), share
        self._stage, self._share = stage, share
        return begins

    def now(self) -> Snapshot:
        """How far the work is."""
        moment = self._clock()
        seconds, gained = moment - self._since, self._share - self._first
        left = None
        if seconds >= _TIMED and gained >= _GAINED and self._share < 1:
            left = (1 - self._share) / gained * seconds
        return Snapshot(self._stage, self._share, moment - self._start, left)


Show = Callable[[Snapshot], None]


@contextmanager
def reporting(*, quiet: bool = False) -> Iterator[Progress]:
    """A context that shows how far the work in it is, at least every five seconds.

    A thread repeats the present stage, so that a long call that reports nothing, a compilation for
    one, does not look as if it hung. In a terminal there are bars, in a notebook there is a bar in
    the cell's output, elsewhere lines; but for notebooks, all on standard error.

    Args:
        quiet: whether nothing is shown.

    Yields:
        The callback, which any thread may call with (stage, done, total).
    """
    if quiet:
        yield silent
        return
    tracker, lock, ended = Tracker(), Lock(), Event()
    with _display() as show:

        def update() -> None:
            with lock:
                now = tracker.now()
                if now.stage == _START and now.seconds < _GRACE:
                    return
                with suppress(OSError, ValueError):  # the reader is gone, or the stream is closed
                    show(now)

        def progress(stage: str, done: int, total: int) -> None:
            with lock:
                begins = tracker.record(stage, done, total)
            if begins:
                update()

        def repeat() -> None:
            while not ended.wait(_BEAT):
                update()

        thread = Thread(target=repeat, name="progress", daemon=True)
        thread.start()
        try:
            yield progress
        finally:
            ended.set()
            thread.join()
        update()


def shown_in_notebooks[**P, R](function: Callable[P, R]) -> Callable[P, R]:
    """The function, which in a notebook shows its progress where it is given no other `progress`.

    Args:
        function: function with the keyword `progress`.
    """

    @wraps(function)
    def showing(*args: P.args, **kwargs: P.kwargs) -> R:
        if kwargs.get("progress") is not None or not in_notebook():
            return function(*args, **kwargs)
        with reporting() as progress:
            kwargs["progress"] = progress
            return function(*args, **kwargs)

    return showing


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    from rich.console import Console

    return Console().is_jupyter


def duration(seconds: float) -> str:
    """Seconds in words, as "12 s" or "3 min 20 s"."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def _display() -> AbstractContextManager[Show]:
    from rich.console import Console

    if in_notebook():
        return _in_cell()
    if sys.stderr.isatty() and not Console(stderr=True).is_dumb_terminal:
        return _bars()
    return _lines()


@contextmanager
def _lines() -> Iterator[Show]:
    """Lines: one when a stage begins, but no more than one a second, and one every few seconds."""
    stage, shown = "", -inf

    def show(now: Snapshot) -> None:
        nonlocal stage, shown
        if now.seconds - shown >= (_MOST if now.stage == stage else _LEAST):
            print(now.line, file=sys.stderr, flush=True)
            stage, shown = now.stage, now.seconds

    yield show


@contextmanager
def _bars() -> Iterator[Show]:
    """A bar for each part of the work, the present one with its stage; none is left by an error."""
    from rich.console import Console
    from rich.live import Live
    from rich.progress_bar import ProgressBar
    from rich.table import Table
    from rich.text import Text

    finished: deque[tuple[str, float]] = deque(maxlen=_KEPT)  # parts, and the seconds they took
    part, since = "", 0.0
    # a command's results on standard output are not to be redirected
    live = Live(console=Console(stderr=True), auto_refresh=False, redirect_stdout=False)

    def show(now: Snapshot) -> None:
        nonlocal part, since
        name = now.stage.partition(": ")[0]
        if name != part:
            if part:
                finished.append((part, now.seconds - since))
            part, since = name, now.seconds
        table = Table.grid(padding=(0, 1))
        table.add_column(no_wrap=True, overflow="ellipsis")
        for ended, seconds in finished:
            table.add_row(Text(ended), ProgressBar(1, 1, width=20), Text(duration(seconds)))
        bar = ProgressBar(1, now.share, width=20, pulse=now.share == 0)
        seconds = now.seconds - since
        table.add_row(Text(now.stage), bar, Text(f"{duration(seconds)}{now.ending}"))
        live.start()
        live.update(table, refresh=True)

    try:
        yield show
    except BaseException:
        live.transient = True
        raise
    finally:
        live.stop()


@contextmanager
def _in_cell() -> Iterator[Show]:
    """A bar in the output of a notebook's cell, taken away at the end."""
    from IPython.display import display

    def bundle(text: str, html: str) -> dict[str, str]:
        return {"text/plain": text, "text/html": html}

    # here, not in the thread that updates it: that belongs to no cell
    handle = display(bundle("", ""), raw=True, display_id=True)

    def show(now: Snapshot) -> None:
        value = f' value="{now.share:.3f}"' if now.share else ""
        html = f"<progress{value}></progress> {escape(now.line)}"
        handle.update(bundle(now.line, html), raw=True)

    try:
        yield show
    finally:
        handle.update(bundle("", ""), raw=True)
