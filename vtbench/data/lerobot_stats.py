"""Statistics of features, gathered episode by episode, in the form that LeRobot normalises with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Tally:
    """Sums over values (n, ...) of one feature; adding two gives the tally of both.

    Attributes:
        frames: number of frames they come from.
        n: number of values that went into each sum.
        total: sum of the values.
        squares: sum of their squares.
        low: least value.
        high: greatest value.
    """

    frames: int
    n: int
    total: NDArray[np.float64]
    squares: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @classmethod
    def of(cls, values: NDArray[Any]) -> Self:
        """Tally of a feature's values, one row a frame."""
        x = np.asarray(values, np.float64).reshape(len(values), -1)
        return cls(len(x), len(x), x.sum(0), (x * x).sum(0), x.min(0), x.max(0))

    @classmethod
    def of_images(cls, images: NDArray[np.uint8]) -> Self:
        """Tally of frames (n, height, width, 3), a value for each colour, 255 counted as 1; shapes (3, 1, 1)."""
        axes = (0, 1, 2)
        x = images.astype(np.float64) / 255.0
        sums = (x.sum(axes), (x * x).sum(axes), x.min(axes), x.max(axes))
        total, squares, low, high = (one.reshape(3, 1, 1) for one in sums)
        return cls(len(images), x[..., 0].size, total, squares, low, high)

    def __add__(self, other: Tally) -> Tally:
        return Tally(
            self.frames + other.frames,
            self.n + other.n,
            self.total + other.total,
            self.squares + other.squares,
            np.minimum(self.low, other.low),
            np.maximum(self.high, other.high),
        )

    def stats(self) -> dict[str, list[Any]]:
        """`min`, `max`, `mean`, `std` (of the population) and `count` (frames) as nested lists."""
        mean = self.total / self.n
        std = np.sqrt(np.maximum(self.squares / self.n - mean**2, 0.0))
        return {
            "min": self.low.tolist(),
            "max": self.high.tolist(),
            "mean": mean.tolist(),
            "std": std.tolist(),
            "count": [self.frames],
        }
