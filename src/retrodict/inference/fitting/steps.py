"""Choice of the run-outs' integration steps: as many as a scene's measurements can resolve."""

from __future__ import annotations

from collections.abc import Callable

from retrodict.models.arrays import Data, Structure, in_steps

RESOLVED = 0.05  # largest acceptable integration error, standard deviations of a rest pose
MOST_STEPS = 768


def in_enough_steps[T](
    structure: Structure, data: Data, attempt: Callable[[Structure, Data], tuple[T, float, int]]
) -> T:
    """The result of an attempt with enough integration steps, doubled until they resolve the scene.

    Args:
        structure: static structure of the scene, with the fewest steps.
        data: numbers of the scene.
        attempt: function that returns a result, its change by finer steps in standard deviations, and
            the number of steps that it used in the end.

    Returns:
        The first result whose change is at most RESOLVED, or that used MOST_STEPS.
    """
    while True:
        found, unresolved, steps = attempt(structure, data)
        if unresolved <= RESOLVED or steps >= MOST_STEPS:
            return found
        structure, data = in_steps(structure, data, 2 * steps)
