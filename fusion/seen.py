"""Rows of which only some modalities are looked at: what the others hold, NaN or infinity, does not matter."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator
from sklearn.utils.validation import assert_all_finite, validate_data

from fusion.arrays import FloatArray


def seen_columns_only(
    estimator: BaseEstimator, X: ArrayLike, columns: Mapping[str, Any], used: Collection[str]
) -> FloatArray:
    """X (q, d) checked for a fitted estimator, 0 in the columns that only modalities not `used` have.

    `columns` maps each modality to its columns. ValueError for X of another width, or not finite where it is seen.
    """
    if all(name in used for name in columns):
        return np.asarray(validate_data(estimator, X, dtype=np.float64, reset=False))
    data = np.array(validate_data(estimator, X, dtype=np.float64, reset=False, ensure_all_finite=False))
    unseen = np.zeros(data.shape[1], dtype=bool)
    for seen in (False, True):
        for name, chosen in columns.items():
            if (name in used) == seen:
                unseen[chosen] = not seen
    data[:, unseen] = 0.0
    assert_all_finite(data, input_name="X")
    return data
