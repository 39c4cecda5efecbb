"""As many integration steps of the run-outs as a scene's measurements can resolve, and no more."""

from __future__ import annotations

from collections.abc import Callable

from retrodict.models.arrays import Data, Structure, in_steps

RESOLVED = 0.05  # standard deviations of a rest pose: what the run-out's steps may be out by
MOST_STEPS = 768


def in_enough_steps[T](
    structure: Structure, data: Data, attempt: Callable[[Structure, Data], tuple[T, float, int]]
) -> T:
    """What an attempt makes of a scene in the steps that it takes.

    Args:
        structure: of the scene, in the fewest steps.
        data: its numbers.
        attempt: gives a result, by how many standard deviations finer steps would move it, and the
            number of steps that it took in the end.

    Returns:
        The first result that is RESOLVED, or that took MOST_STEPS.
    """
    while True:
        found, unresolved, steps = attempt(structure, data)
        if unresolved <= RESOLVED or steps >= MOST_STEPS:
            return found
        structure, data = in_steps(structure, data, 2 * steps)
