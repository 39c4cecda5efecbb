"""Coordinates that a posterior is sampled in, and the two transforms to a model's unknowns."""

from __future__ import annotations

from enum import Enum

from retrodict.inference.transforms.rest_pose import RestPose
from retrodict.inference.transforms.standard import Deviates
from retrodict.models.arrays import Structure

Transform = RestPose | Deviates
"""A bijection from sampled coordinates, in which a posterior is near a standard normal."""


class Coordinates(Enum):
    """Coordinates that a posterior is sampled in; `inference.plan` says which method uses which."""

    PINNED = "rest poses where they cover the posterior; else deviates"
    DEVIATES = "standard normal deviates, a part about each mode"
    UNBENT = "deviates, for proposals that solve for what evidence pins"
    SOLVED_BACK = "rest poses, even where they do not cover the posterior"


def size_of(structure: Structure) -> int:
    """Number of sampled coordinates of a structure."""
    kind = Deviates if structure.in_deviates else RestPose
    return kind.size_of(structure)
