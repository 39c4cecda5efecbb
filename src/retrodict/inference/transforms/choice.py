"""Which transform a structure is sampled by: the one place that asks."""

from __future__ import annotations

from retrodict.inference.transforms.offset import Offset
from retrodict.inference.transforms.protocol import Transform
from retrodict.inference.transforms.rest_pose import RestPose
from retrodict.inference.transforms.standard import Standard
from retrodict.models.arrays import Structure, TransformName

_TRANSFORMS: dict[TransformName, Transform] = {
    "rest-pose": RestPose(),
    "standard": Standard(),
    "offset": Offset(),
}


def transform_of(structure: Structure) -> Transform:
    """The transform of a structure."""
    return _TRANSFORMS[structure.transform]
