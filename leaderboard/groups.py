"""Scores summed by group: all that intervals, comparisons and ranks need to know of a cell's predictions."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Groups:
    """Per-group sums of scores and sample counts, each of shape (groups,)."""

    total: FloatArray
    size: FloatArray

    @property
    def count(self) -> int:
        """Number of groups."""
        return len(self.size)

    @property
    def n(self) -> int:
        """Number of samples."""
        return round(float(self.size.sum()))

    @property
    def mean(self) -> float:
        """Mean over samples."""
        return float(self.total.sum() / self.size.sum())

    @property
    def means(self) -> FloatArray:
        """Mean of each group, (groups,)."""
        return self.total / self.size

    @property
    def standard_error(self) -> float:
        """Linearised standard error of the pooled mean; for equal groups, that of the mean of group means."""
        residual = self.total - self.mean * self.size
        count = self.count
        return sqrt(count / (count - 1) * float(residual @ residual)) / float(self.size.sum())

    def minus(self, other: Groups) -> Groups:
        """Return the differences to another method on the same samples; ValueError when the groups differ in size."""
        if self.size.shape != other.size.shape or not np.array_equal(self.size, other.size):
            raise ValueError(f"paired difference: expected the same groups, got {self.count} and {other.count}")
        return Groups(self.total - other.total, self.size)


def grouped(scores: FloatArray, groups: ArrayLike) -> Groups:
    """Return the sums of `scores` (n,) by their label in `groups` (n,), in the order of sorted labels."""
    labels: NDArray[Any] = np.asarray(groups)
    if labels.shape != scores.shape:
        raise ValueError(f"groups: expected one label a sample, {scores.shape}, got shape {labels.shape}")
    _, index = np.unique(labels, return_inverse=True)
    return Groups(_sum_by(index, scores), _sum_by(index, np.ones(len(scores))))


def _sum_by(index: NDArray[np.intp], values: FloatArray) -> FloatArray:
    return np.asarray(np.bincount(index, weights=values), dtype=np.float64)
