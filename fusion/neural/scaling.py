"""Centre and spread of each modality, learnt on the training rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from fusion.neural.layout import FloatArray, Part


@dataclass(frozen=True, eq=False)
class Scale:
    """mean and spread, both of a modality's shape; a spread is never 0."""

    mean: FloatArray
    spread: FloatArray

    @classmethod
    def of(cls, part: Part, values: FloatArray) -> Self:
        """From training values (n, *shape).

        The mean is each column's own. The spread is a column's own in a vector, a colour's in an image and
        one for a whole series, so that neighbouring pixels, steps and taxels keep their proportions.
        """
        mean = values.mean(axis=0)
        axes = {"vector": (0,), "series": (0, 1, 2), "image": (0, 2, 3)}[part.kind]
        spread = np.sqrt(((values - mean) ** 2).mean(axis=axes, keepdims=True))[0]
        rounding = 10 * np.finfo(np.float64).eps * np.abs(values).max()
        return cls(mean, np.broadcast_to(np.where(spread > rounding, spread, 1.0), part.shape).copy())

    def apply(self, values: FloatArray) -> FloatArray:
        """Scaled values (n, *shape)."""
        return (values - self.mean) / self.spread
