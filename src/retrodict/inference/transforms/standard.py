"""The transform of standard normal deviates of all unknowns: it covers all that a model allows.

The deviates are bent so that the posterior is flat about a mode: evidence pins a few directions of the
deviates to a thin sheet, which curves with the other directions. A quadratic approximation of the sheet
is subtracted, by a shear that preserves volume.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Array, Float

from retrodict.inference.transforms.parameters import (
    Flattening,
    Q,
    Quadratic,
    TransformParameters,
    plain,
)
from retrodict.inference.transforms.protocol import Located, Transform
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


class Standard(Transform):
    """Standard normal deviates are coordinates; q is v of a `Flattening`."""

    def length(self, structure: Structure) -> int:
        """Number of entries of q."""
        return structure.deviates

    def example(self, structure: Structure) -> TransformParameters:
        """Parameters of the right shapes and no meaning."""
        n = self.length(structure)
        flat = unbent(np.zeros(n), np.eye(n), pinned_of(structure))
        return plain(np.zeros(n), np.eye(n))._replace(flattening=flat)

    def from_q(
        self,
        structure: Structure,
        data: Data,
        parameters: TransformParameters,
        q: Q,
        log_det: Float[Array, ""],
    ) -> Located:
        """No unknowns, because the model derives them; the log determinant; the deviates."""
        assert parameters.flattening is not None, "parameters of deviates have one"
        deviates = parameters.flattening.deviates(q)
        return {}, log_det + parameters.flattening.log_volume, deviates


def pinned_of(structure: Structure) -> int:
    """Number of directions of the deviates that evidence pins at most."""
    return min(len(structure.evidence) + len(structure.own), structure.deviates)
