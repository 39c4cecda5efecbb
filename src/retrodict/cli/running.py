"""What commands share: progress and interrupts, exit statuses, folders, and one line for an error."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import typer

from retrodict.progress import Progress, printable, reporting

if TYPE_CHECKING:
    from rich.console import Console

    from retrodict.scene import Scene

BAD_INPUT, DIFFERS, INTERRUPTED = 2, 3, 130  # exit statuses
LOADING, WRITING = "loading the libraries", "writing the results"  # stages


@contextmanager
def working(quiet: bool) -> Iterator[Progress]:
    """A context with a progress display, in which what stops the work is reported in one line."""
    # imports and tracing make much and drop little: fewer sweeps save a second of a first run
    gc.set_threshold(100_000)
    try:
        with reporting(quiet=quiet) as progress:
            yield progress
    except KeyboardInterrupt:
        fail("interrupted", INTERRUPTED)
    except RuntimeError as error:
        platforms = os.environ.get("JAX_PLATFORMS")
        if platforms is None or "backend" not in str(error):
            raise
        fail(f"JAX_PLATFORMS={platforms}: {error}".splitlines()[0] + "; unset it, or set it to cpu")


@contextmanager
def refusing(*errors: type[Exception], prefix: str = "", status: int = BAD_INPUT) -> Iterator[None]:
    """A context in which these errors end the command with a line: their message says what to do.

    Args:
        errors: errors of the input, or of what the command needs.
        prefix: text before the message.
        status: exit status.
    """
    try:
        yield
    except errors as error:
        fail(f"{prefix}{error}", status)


@contextmanager
def writing(place: Path, what: str = "results") -> Iterator[None]:
    """A context in which files are written; a full disk or a missing library ends the command.

    Args:
        place: file or folder that is written.
        what: name of what is written.
    """
    from retrodict.report.libraries import MissingLibrary

    with refusing(MissingLibrary, status=1):
        try:
            yield
        except OSError as error:
            fail(f"{place}: cannot write the {what}: {error}", 1)


def print_path(file: Path, console: Console) -> None:
    """Print the path of a result, so that it can be copied."""
    console.print(printable(str(file)), highlight=False, markup=False, soft_wrap=True)


def load_or_fail(path: Path) -> Scene:
    """The scene of a file; the command ends with a line where it cannot be read."""
    from retrodict.scene import SceneError, load_scene

    try:
        return load_scene(path)
    except SceneError as error:
        fail(str(error))


def require_rung(model: str, *, auto: bool) -> None:
    """End the command where no rung has this name; "auto" passes where `auto` is set."""
    from retrodict.models import RUNGS

    if model not in RUNGS and not (auto and model == "auto"):
        fail(f"--model {model}: choose {'auto or ' if auto else ''}one of {', '.join(RUNGS)}")


def output_folder(out: Path | None, name: str) -> Path:
    """The folder for the results; the command ends before the work where it cannot be one."""
    if out is None and name.strip(". ") == "":
        fail("cannot name the output folder after this scene file: choose one with --out")
    if out == Path():  # an empty option, rarely meant as the current folder
        fail("--out is empty, or the current folder: name a folder for the results")
    folder = Path("out") / name if out is None else out
    nearest = folder
    while not nearest.exists() and nearest != nearest.parent:
        nearest = nearest.parent
    if not nearest.is_dir():
        fail(f"--out {folder}: {nearest} is a file, not a folder; choose another folder")
    return folder


def fail(line: str, status: int = BAD_INPUT) -> NoReturn:
    """End the command with a line on standard error and this exit status."""
    print(printable(line), file=sys.stderr)  # not by typer, which would write across a bar
    raise typer.Exit(status)
