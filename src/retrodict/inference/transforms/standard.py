"""The transform of standard normal deviates of all unknowns: it covers all that a model allows.

The deviates are bent so that the posterior is flat about a mode: evidence pins a few directions of the
deviates to a thin sheet, which curves with the other directions. A quadratic approximation of the sheet
is subtracted, by a shear that preserves volume.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Float

from retrodict.inference.transforms.parameters import Affine, Flattening, Located, Quadratic
from retrodict.models.arrays import Data, Structure


def unbent(peak: Float[np.ndarray, " n"], axes: Float[np.ndarray, "n n"], items: int) -> Flattening:
    """A flattening without a shear.

    Args:
        peak: deviates at v = 0, shape (n,).
        axes: derivatives of the deviates by v, shape (n, n).
        items: number of entries of v that could be shifted.
    """
    n = peak.size
    bend = Quadratic(np.zeros(items), np.zeros((items, n)), np.zeros((items, n, n)))
    return Flattening(peak, axes, bend, np.array(np.linalg.slogdet(axes)[1]))


class Deviates(NamedTuple):
    """Standard normal deviates are coordinates: a chain of two bijections.

    Args:
        whitening: bijection w -> v.
        flattening: bijection of v to the deviates.
    """

    whitening: Affine
    flattening: Flattening

    @classmethod
    def unwhitened(cls, flattening: Flattening) -> Deviates:
        """The bijection w = v -> deviates."""
        n = flattening.peak.size
        return cls(Affine.about(np.zeros(n), np.eye(n)), flattening)

    @staticmethod
    def size_of(structure: Structure) -> int:
        """Number of entries of w."""
        return structure.deviates

    @classmethod
    def example(cls, structure: Structure) -> Deviates:
        """The prior's own deviates."""
        n = structure.deviates
        return cls.unwhitened(unbent(np.zeros(n), np.eye(n), pinned_of(structure)))

    @property
    def log_volume(self) -> float:
        """Log |d deviates / d w|, the same everywhere."""
        return float(self.whitening.log_volume) + float(self.flattening.log_volume)

    def transform_and_log_det(
        self, structure: Structure, data: Data, w: Float[Array, " w"]
    ) -> Located:
        """No unknowns, because the model derives them; the log determinant; the deviates."""
        v, log_det = self.whitening.transform_and_log_det(w)
        return {}, log_det + self.flattening.log_volume, self.flattening.deviates(v)

    def transform(self, w: Float[np.ndarray, "points n"]) -> Float[np.ndarray, "points n"]:
        """Deviates at points w, in NumPy."""
        return self.flattening.deviates(self.whitening.transform(w), np)

    def inverse(self, deviates: Float[np.ndarray, "points n"]) -> Float[np.ndarray, "points n"]:
        """Points w at deviates."""
        return self.whitening.inverse(self.flattening.inverse(deviates))


def pinned_of(structure: Structure) -> int:
    """Number of directions of the deviates that evidence pins at most."""
    return min(len(structure.evidence) + len(structure.own), structure.deviates)
