"""What a compliance must offer so that the contact solver can use it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid

Window = tuple[slice, slice]


class WindowedCompliance(Protocol):
    """A compliance that sees pressure and displacement inside one rectangle of the grid only."""

    def displacement(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Surface displacement (m, into the pad) under `pressure` (Pa); both of the window's shape."""
        ...

    def precondition(self, residual: NDArray[np.floating]) -> NDArray[np.floating]:
        """Approximate inverse: pressure-like field (any scale) for a displacement-like `residual`."""
        ...


class Compliance(Protocol):
    """A linear, symmetric, positive map from pressure to the displacement of the touched surface."""

    grid: Grid
    dtype: np.dtype[np.floating]

    def window(self, rows: slice, columns: slice) -> WindowedCompliance:
        """The same compliance restricted to a rectangle, which is what makes a small contact cheap."""
        ...
