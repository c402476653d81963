"""Array types and the check that every public function makes of its matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def finite_matrix(values: ArrayLike, name: str) -> FloatArray:
    """`values` as a contiguous float64 matrix; ValueError when it is empty, no matrix, or not finite."""
    matrix = np.ascontiguousarray(values, dtype=np.float64)
    if matrix.ndim != 2 or matrix.shape[1] == 0:
        raise ValueError(f"{name} must be a matrix with at least one column, got shape {matrix.shape}.")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} holds values that are not finite (NaN or infinity); remove or fill them first.")
    return matrix


def frozen(values: ArrayLike, dtype: type = np.float64) -> NDArray[Any]:
    """`values` as the one kind of array that compiled loops read: contiguous, read-only, no subclass.

    Where it is that already nothing is copied; a model from a memory-mapped file needs no loops of its own.
    """
    if type(values) is np.ndarray and values.dtype == dtype:
        flags = values.flags
        if flags.c_contiguous and flags.aligned and not flags.writeable:
            return values
    array = np.require(values, dtype, ["C", "E"]).view()
    array.flags.writeable = False
    return array
