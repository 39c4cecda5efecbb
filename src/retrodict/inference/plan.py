"""Plan of how to draw from a posterior: methods in the order of trying, and their coordinates.

Chains need flat coordinates, which rest poses are of a sharp crash whose approach is unknown. Importance
sampling does without them on nearly every scene, in deviates that need one compiled program, and draws
each of several modes by itself. Tempering takes longest.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from retrodict.inference.errors import Unanswerable
from retrodict.inference.samplers import METHODS
from retrodict.inference.transforms.choice import Coordinates
from retrodict.models import RUNGS
from retrodict.options import RunOptions
from retrodict.scene.records import Scene

WORTH_MORE = 100  # draws a chain: who asks for fewer wants a quick look, not more of it


@dataclass(frozen=True)
class Way:
    """A method in coordinates.

    Args:
        method: a name in METHODS.
        coordinates: coordinates in which it draws.
    """

    method: str
    coordinates: Coordinates


_DEVIATES, _PINNED = Coordinates.DEVIATES, Coordinates.PINNED


def ways(method: str, scene: Scene) -> tuple[Way, ...]:
    """Ways to draw from a posterior, beginning with the method that is asked for.

    Args:
        method: a name in METHODS.
        scene: scene to be reconstructed.
    """
    if METHODS[method].solves_back:
        return (Way(method, Coordinates.SOLVED_BACK),)
    known = {
        "nuts": (
            Way("nuts", _for_chains(scene)), Way("importance", _DEVIATES), Way("smc", _DEVIATES)
        ),
        "importance": (
            Way("importance", _DEVIATES), Way("importance", _PINNED), Way("smc", _DEVIATES)
        ),
        "smc": (Way("smc", _DEVIATES),),
    }  # fmt: skip
    return known.get(method, (Way(method, _PINNED),))


def _for_chains(scene: Scene) -> Coordinates:
    """Coordinates in which chains mix.

    Rest poses are, where they alone tell how a vehicle came: on the paper's scene NUTS steps 0.58 far
    there and 0.05 in deviates, in which its chains get nowhere (measured). Where it is known how all
    came, the little that their speeds leave open bends in rest poses and is nearly normal in deviates:
    of ten scenes of users that would have had rest poses, two failed there and none in deviates, which
    took as long or less (measured).

    Args:
        scene: scene to be reconstructed.
    """
    known = all(own.direction and own.yaw_rate for own in scene.approach.values())
    return _DEVIATES if known else _PINNED


def suited(scene: Scene) -> str:
    """The method for a scene whose user names none: run-outs of wheels that roll have no cheap slopes.

    Args:
        scene: scene to be reconstructed.
    """
    return "importance" if scene.rolling else "nuts"


def kept_warm(scene: Scene, model: str) -> Coordinates:
    """Coordinates that can be taken along as a scene's numbers change.

    Rest poses move with what is measured, but pin no vehicle whose rolling is integrated.

    Args:
        scene: scene to be reconstructed.
        model: a name in `retrodict.models.RUNGS`.
    """
    return _DEVIATES if RUNGS[model].of_scene(scene)[0].paced else _PINNED


def planned(scene: Scene, options: RunOptions, resume: Path | None = None) -> tuple[Way, ...]:
    """The `ways` of a run, once its options are seen to be possible.

    Args:
        scene: scene to be reconstructed.
        options: options of the run.
        resume: file of interrupted chains that are to go on; None where there is none.

    Raises:
        ValueError: no rung or method has that name, or the method has no chains to go on with.
        Unanswerable: the rung is no model of an impact with a barrier, or needs what is not written.
    """
    for what, name, known in (
        ("model", options.model, RUNGS), ("method", options.method, METHODS)
    ):  # fmt: skip
        if name not in known:
            raise ValueError(f"{what} is one of {', '.join(known)}; not {name!r}")
    if resume is not None and not METHODS[options.method].resumes:
        able = ", ".join(name for name, method in METHODS.items() if method.resumes)
        raise ValueError(
            f"{resume}: the method {options.method} has no chains to go on with: give the method that "
            f"was interrupted ({able}), or start anew"
        )
    if scene.extra and METHODS[options.method].solves_back:
        raise ValueError(
            f"the method {options.method} has no likelihood to which a term of your own could be added; "
            "write nuts, importance, smc or laplace"
        )
    if unfit := RUNGS[options.model].lacks(scene):
        raise Unanswerable(f"the model {options.model} {unfit}")
    return ways(options.method, scene)


def is_quick(options: RunOptions) -> bool:
    """Whether a quick look is asked for, which no other method follows where it falls short."""
    return options.draws is not None and options.draws < WORTH_MORE
