"""The square, cell-centred grid that every contact field lives on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.floating]


@dataclass(frozen=True)
class Grid:
    """A square of `size_m` metres cut into `n` x `n` cells, centred on the origin.

    Arrays on it are indexed [row = y, column = x]; cell i has its centre at (i + 1/2) size / n - size / 2.
    """

    n: int
    size_m: float

    def __post_init__(self) -> None:
        if not (isinstance(self.n, int | np.integer) and self.n >= 2 and 0 < self.size_m < np.inf):
            raise ValueError(
                f"a grid needs a whole n >= 2 and a finite positive size, got n={self.n}, size_m={self.size_m}"
            )

    @property
    def pitch_m(self) -> float:
        """Edge of a cell in metres."""
        return self.size_m / self.n

    @property
    def cell_area_m2(self) -> float:
        """Area of a cell in square metres."""
        return self.pitch_m**2

    def coarser(self) -> Grid:
        """The same square in half as many cells along a side."""
        if self.n % 2:
            raise ValueError(f"a grid of {self.n} cells along a side has no half")
        return Grid(self.n // 2, self.size_m)

    def axis(self) -> NDArray[np.float64]:
        """Cell centres along one axis in metres, shape (n,)."""
        return (np.arange(self.n, dtype=np.float64) + 0.5) * self.pitch_m - self.size_m / 2

    def coordinates(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Cell centres (x, y) in metres, each of shape (n, n)."""
        axis = self.axis()
        x, y = np.meshgrid(axis, axis)
        return x, y
