"""NUTS, the default and the reference: chains that help themselves once where they diverge."""

from __future__ import annotations

from dataclasses import replace

from retrodict.inference.errors import Interrupted
from retrodict.inference.methods import chains, checkpoint
from retrodict.inference.methods.chains import Chains, sample
from retrodict.inference.methods.draws import Draws, Task
from retrodict.inference.posterior import Posterior
from retrodict.models.arrays import Structure

_FIRST_TRY = 0.65  # target acceptance: fewer, longer steps bring more effective draws a second
# Of the run that follows one with divergences. No more: the gradient steers only near enough, so that
# acceptance stays at 0.9 however short the steps, and steps that aim for it collapse (measured).
_SECOND_TRY = 0.8
_CURVED = 0.8  # of a posterior that rest poses do not pin: shorter steps are slow and mend little
_PILOT = 200  # draws of each chain by which such a posterior is whitened, or responses are fitted
_MENDABLE = 0.05  # share of divergent draws up to which shorter steps may help


def draw(task: Task) -> Draws:
    """Draw by NUTS.

    Raises:
        Interrupted: stopped before any draws were kept.
    """
    original, structure = task.posterior, task.posterior.programs.structure
    first, second = targets(structure)
    if structure.unpinned or structure.responding:
        pilot = sample(replace(task, draws=_PILOT, resume=None), first)
        if not pilot.complete:
            raise Interrupted("stopped before any draws were kept")
        w = pilot.w.reshape(-1, original.size)
        better = original.about(w) if structure.unpinned else original.responding_by(w)
        task = replace(task, posterior=better)
    found, target_accept = sample(task, first), first
    notes: tuple[str, ...] = ()
    divergences = int(found.stats["diverging"].sum()) if found.stats else 0
    few = 0 < divergences <= _MENDABLE * found.w.shape[0] * found.w.shape[1]
    if found.complete and few and second > first:
        notes = (
            f"a first run had {divergences} divergent transitions; the run told of here took shorter "
            f"steps (target acceptance {second}) and twice the warm-up",
        )
        task = replace(task, warmup=2 * task.warmup, resume=None)
        target_accept = second
        found = sample(task, target_accept)
    if found.w.shape[1] < 4:
        raise Interrupted("stopped before any draws were kept")
    drawn = _told(found, task, original, target_accept, notes)

    def more() -> Draws:
        longer = replace(task, draws=2 * task.draws, resume=None)
        return _told(sample(longer, target_accept, found), longer, original, target_accept, notes)

    return replace(drawn, more=more)


def targets(structure: Structure) -> tuple[float, float]:
    """Acceptance that a first run aims for, and one after divergences: the same where none helps."""
    return (_CURVED, _CURVED) if structure.unpinned else (_FIRST_TRY, _SECOND_TRY)


def _told(
    found: Chains, task: Task, original: Posterior, target_accept: float, notes: tuple[str, ...]
) -> Draws:
    first = target_accept == targets(task.posterior.programs.structure)[0] and not found.complete
    unfinished = checkpoint.packed(found, chains.settings(task)) if first else None
    w = found.w
    if original.programs.structure.unpinned:
        w = task.posterior.seen_from(original, w.reshape(-1, original.size)).reshape(w.shape)
    return Draws(w, found.stats, found.complete, notes, unfinished=unfinished)
