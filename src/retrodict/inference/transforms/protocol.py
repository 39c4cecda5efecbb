"""Interface of a transform: a bijection from sampled coordinates w to the unknowns of a model."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from jaxtyping import Array, Float

from retrodict.inference.transforms.parameters import Q, TransformParameters, plain, unwhitened
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure

Located = tuple[parts.Values, Float[Array, ""], Q]
"""A value for each of the model's sample sites, the log determinant so far, and q."""


class Transform(ABC):
    """A bijection w -> q -> unknowns; a structure says which one, and parameters hold its numbers."""

    @abstractmethod
    def length(self, structure: Structure) -> int:
        """Number of entries of q."""

    def size(self, structure: Structure) -> int:
        """Number of sampled coordinates, the entries of w: `length` less the number of held levels."""
        return self.length(structure)

    def example(self, structure: Structure) -> TransformParameters:
        """Parameters of the right shapes and no meaning, to compile programs for."""
        n = self.length(structure)
        return plain(np.zeros(n), np.eye(n))

    def surrogates(self, structure: Structure) -> tuple[str, ...]:
        """Names of the run-out predictions that have a surrogate, in order."""
        return ()

    @abstractmethod
    def from_q(
        self,
        structure: Structure,
        data: Data,
        parameters: TransformParameters,
        q: Q,
        log_det: Float[Array, ""],
    ) -> Located:
        """The part of `forward_and_log_det` that begins at q; `log_det` is log |d q / d w|."""

    def forward_and_log_det(
        self,
        structure: Structure,
        data: Data,
        parameters: TransformParameters,
        w: Float[Array, " w"],
    ) -> Located:
        """The unknowns at w, and log |d unknowns / d w|.

        Args:
            structure: static structure of the scene.
            data: numbers of the scene.
            parameters: the numbers of the bijection.
            w: a point of the sampled space, shape (w,).

        Returns:
            A value for each of the model's sample sites, the log determinant, and q.
        """
        return self.from_q(structure, data, parameters, *unwhitened(parameters, w))
