"""Figures drawn in a process of their own, while this one does other work."""

from __future__ import annotations

import gc
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from subprocess import DEVNULL, PIPE, Popen
from typing import TYPE_CHECKING

from retrodict.scene.quantities import Units

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome


# the last figures are drawn here: by then this process has written all else, and it would only wait
_THERE, _HERE = slice(None, -2), slice(-2, None)


class DrawingProcess:
    """A process that imports at once what drawing needs, and draws on request.

    It ends when this process does. A thread would not do: Python runs one of them at a time.
    """

    def __init__(self) -> None:
        self._process = Popen(
            [sys.executable, "-P", "-m", __name__],  # -P: no import from the working directory
            stdin=PIPE,
            stdout=PIPE,
            stderr=DEVNULL,
            start_new_session=True,  # Ctrl-C ends the sampling; its draws are still to be drawn
        )

    def begin(
        self, findings: Findings, outcome: Outcome, units: Units
    ) -> Callable[[], dict[str, bytes]]:
        """Hand over what to draw, once.

        Args:
            findings: findings of the reconstruction.
            outcome: outcome of the reconstruction, with its draws.
            units: "si" or "us".

        Returns:
            A function that draws the last figures, waits for the others, and gives their images: PNG
            by name, in the order of the report. Where the process failed, it draws them all.
        """
        # none of this is drawn, and the process would import JAX to read models' descriptions
        found = replace(findings, description=None, ladder=None)  # type: ignore[arg-type]
        bare = replace(outcome, description=None, unfinished=None)  # type: ignore[arg-type]
        assert self._process.stdin is not None
        # if the process is gone already, so is its answer
        with suppress(OSError), self._process.stdin as to_it:
            pickle.dump((found, bare, units), to_it)

        def images() -> dict[str, bytes]:
            from retrodict.report.figures import registry as figures  # matplotlib is slow to import

            here = figures.images(findings, outcome, units, _HERE)
            assert self._process.stdout is not None
            try:
                with self._process, self._process.stdout as from_it:
                    return pickle.load(from_it) | here
            except (EOFError, pickle.UnpicklingError):
                return figures.images(findings, outcome, units, _THERE) | here

        return images


def _main() -> None:
    import retrodict.inference.outcome  # noqa: F401
    from retrodict.report.libraries import arviz_without_jax

    gc.set_threshold(100_000)  # as in the command
    arviz_without_jax()

    from retrodict.report.figures.registry import images

    findings, outcome, units = pickle.load(sys.stdin.buffer)
    pickle.dump(images(findings, outcome, units, _THERE), sys.stdout.buffer)


if __name__ == "__main__":
    _main()
