"""What a transform is: a bijection from sampled coordinates w to the unknowns of a model."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from jaxtyping import Array, Float

from retrodict.inference.transforms.parameters import Q, TransformParameters
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure


class Transform(ABC):
    """A bijection w -> q -> unknowns; a structure says which one, and parameters hold its numbers.

    Args:
        exact_gradient: whether run-outs are differentiated, and none has a surrogate.
        refit_to_draws: whether whitening at the mode is not enough, and is done again by draws.
        by_regressions: whether rest poses are coordinates, so that run-outs are fitted first.
    """

    exact_gradient: ClassVar[bool]
    refit_to_draws: ClassVar[bool]
    by_regressions: ClassVar[bool]

    @abstractmethod
    def length(self, structure: Structure) -> int:
        """Number of entries of q."""

    @abstractmethod
    def size(self, structure: Structure) -> int:
        """Number of sampled coordinates, the entries of w."""

    @abstractmethod
    def example(self, structure: Structure) -> TransformParameters:
        """Parameters of the right shapes and no meaning, to compile programs for."""

    @abstractmethod
    def forward_and_log_det(
        self,
        structure: Structure,
        data: Data,
        parameters: TransformParameters,
        w: Float[Array, " w"],
    ) -> tuple[parts.Values, Float[Array, ""], Q]:
        """The unknowns at w, and log |d unknowns / d w|.

        Args:
            structure: of the scene.
            data: its numbers.
            parameters: the numbers of the bijection.
            w: a point of the sampled space, shape (w,).

        Returns:
            A value for each of the model's sample sites, the log determinant, and q.
        """
