"""Choice of the coordinates that a posterior is sampled in, and of their transform."""

from __future__ import annotations

from enum import Enum

from retrodict.inference.transforms.protocol import Transform
from retrodict.inference.transforms.rest_pose import RestPose
from retrodict.inference.transforms.standard import Standard
from retrodict.models.arrays import Structure, TransformName

_TRANSFORMS: dict[TransformName, Transform] = {
    "rest-pose": RestPose(),
    "standard": Standard(),
}


class Coordinates(Enum):
    """Coordinates that a posterior is sampled in; `inference.plan` says which method uses which."""

    PINNED = "rest poses where they cover the posterior; else deviates"
    DEVIATES = "standard normal deviates, a part about each mode"
    UNBENT = "deviates, for proposals that solve for what evidence pins"
    SOLVED_BACK = "rest poses, even where they do not cover the posterior"


def transform_of(structure: Structure) -> Transform:
    """The transform of a structure."""
    return _TRANSFORMS[structure.transform]
