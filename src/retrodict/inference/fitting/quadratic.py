"""Least squares of quadratics whose arguments saturate, as in `parameters.Quadratic`."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve

from retrodict.inference.threads import one_blas_thread
from retrodict.inference.transforms.parameters import Quadratic, saturated

_RIDGE = 1e-8  # ridge penalty: some inputs (a zone that no vehicle reaches) have no effect

Terms = Float[np.ndarray, "rows terms"]


def terms(x: Float[np.ndarray, "rows k"]) -> Terms:
    """Columns of the least squares: 1, x, and the products of the saturated x."""
    s = saturated(x, np)
    rows, columns = np.triu_indices(x.shape[1])
    return np.concatenate([np.ones((len(x), 1)), x, s[:, rows] * s[:, columns]], axis=1)


def least_squares(
    A: Terms, y: Float[np.ndarray, "rows values"], weight: Float[np.ndarray, " rows"]
) -> Float[np.ndarray, "terms values"]:
    """Coefficients of the weighted least squares.

    Solves the normal equations, which takes a fifth of the time of an SVD (measured); this loses half of
    the digits, and coordinates need few.
    """
    keep = weight > 0
    A, y = A[keep] * weight[keep, None], y[keep] * weight[keep, None]
    with one_blas_thread():  # BLAS threads and the compiler's would wait for each other for seconds
        return solve(A.T @ A + _RIDGE * np.eye(A.shape[1]), A.T @ y, assume_a="pos")


def as_quadratic(coefficients: Float[np.ndarray, "terms values"], k: int) -> Quadratic:
    """The quadratic of k arguments that has these coefficients of `terms`."""
    quadratic = np.zeros((coefficients.shape[1], k, k))
    rows, columns = np.triu_indices(k)
    quadratic[:, rows, columns] = coefficients[1 + k :].T
    quadratic = (quadratic + quadratic.swapaxes(1, 2)) / 2
    return Quadratic(coefficients[0], coefficients[1 : 1 + k].T, quadratic)
