"""No impact: one vehicle that skids or runs out from a speed that is asked for."""

from __future__ import annotations

from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description
from retrodict.models.impact import Impact, Separation


def forward_model(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """The vehicle goes on as it came; its speed is a measured input, or has a prior."""
    del data
    motion = parts.approach_of_a(x)
    if "heading" not in structure.rests:
        motion = motion[:2]
    parts.record_velocities(motion, 1)
    return motion


IMPACT = Impact(
    description=Description(
        name="alone",
        title="one vehicle that struck nothing",
        equations=("a skid up to a known speed: v0² = v² + 2 g f n s, n the braking efficiency",),
        assumptions=("nothing but the road acts on the vehicle",),
        left_out=("air drag; braking before the marks begin",),
    ),
    forward_model=forward_model,
    answers=("speed_a",),
    levels=(),
    unknowns=None,
    priors=("speed_a", "omega_a"),
    nesting=frozenset(),
    kind="alone",
)
