"""NUTS, the default and the reference: chains that help themselves once where they diverge."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from retrodict.inference.errors import Interrupted
from retrodict.inference.methods import chains, checkpoint
from retrodict.inference.methods.chains import Chains, sample
from retrodict.inference.methods.draws import Draws, Task

FIRST_TRY = 0.65  # target acceptance: fewer, longer steps bring more effective draws a second
# Of the run that follows one with divergences. No more: the gradient steers only near enough, so that
# acceptance stays at 0.9 however short the steps, and steps that aim for it collapse (measured).
_SECOND_TRY = 0.8
_MENDABLE = 0.05  # share of divergent draws up to which shorter steps may help


def draw(task: Task) -> Draws:
    """Draw by NUTS.

    Raises:
        Interrupted: stopped before any draws were kept.
    """
    found, target_accept = sample(task, FIRST_TRY), FIRST_TRY
    notes: tuple[str, ...] = ()
    divergences = int(found.stats["diverging"].sum()) if found.stats else 0
    if found.complete and 0 < divergences <= _MENDABLE * found.stats["diverging"].size:
        notes = (
            f"a first run had {divergences} divergent transitions; the run told of here took shorter "
            f"steps (target acceptance {_SECOND_TRY}) and twice the warm-up",
        )
        task = replace(task, warmup=2 * task.warmup, resume=None)
        target_accept = _SECOND_TRY
        found = sample(task, target_accept)
    if found.w.shape[1] < 4:
        raise Interrupted("stopped before any draws were kept")
    return _told(found, task, target_accept, notes)


def _told(found: Chains, task: Task, target_accept: float, notes: tuple[str, ...]) -> Draws:
    def more() -> Draws:
        longer = replace(task, draws=2 * task.draws, resume=None)
        return _told(sample(longer, target_accept, found), longer, target_accept, notes)

    first = target_accept == FIRST_TRY and not found.complete
    unfinished = partial(checkpoint.save, found, chains.settings(task)) if first else None
    return Draws(found.w, found.stats, found.complete, notes, unfinished=unfinished, more=more)
