"""The cloth seen through the same pixels after the skin has been dragged along in its plane."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sensors.optics.canvas import Canvas

_FINE = 4
_KEPT = 2
"""Points kept across a pixel; cubic interpolation between them is off by a twentieth of what the drag changes."""


@dataclass(frozen=True)
class DraggedWeave:
    """A cloth over pixels centred on `x_m`, `y_m`; `rng` stands where the cloth's threads are drawn."""

    canvas: Canvas
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    rng: np.random.Generator

    @cached_property
    def _means(self) -> NDArray[np.float32]:
        """Means of two by two kept points that start at each of them, and one before the first row and column."""
        import cv2

        fine = self.canvas.weave(self.x_m, self.y_m, self.rng, _FINE)
        group = _FINE // _KEPT
        shape = (fine.shape[0] // group, group, fine.shape[1] // group, group)
        kept = fine.reshape(shape).mean(axis=(1, 3)).astype(np.float32)
        kept = cv2.copyMakeBorder(kept, 1, 1, 1, 1, cv2.BORDER_REFLECT)
        pairs = kept[:-1] + kept[1:]
        return np.ascontiguousarray((pairs[:, :-1] + pairs[:, 1:]) / np.float32(_KEPT**2))

    @cached_property
    def _rest(self) -> NDArray[np.float32]:
        return np.ascontiguousarray(self._means[1::_KEPT, 1::_KEPT])

    @cached_property
    def _points(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        rows, columns = self._rest.shape
        x, y = np.meshgrid(*(1 + _KEPT * np.arange(n, dtype=np.float32) for n in (columns, rows)))
        return x, y

    def ratio(self, shape: NDArray[np.float32], shift_m: tuple[float, float]) -> NDArray[np.float32]:
        """Brightness (rows, columns) over that at rest, each point having moved by `shape` (rows, columns) x shift.

        A pixel moves as one: the mean over a pixel is taken first and then looked up where the pixel came from.
        """
        points_per_m = _KEPT / (self.x_m[1] - self.x_m[0])
        across, down = (shape * np.float32(part * points_per_m) for part in shift_m)
        return self._looked_up(across, down)

    def ratio_each(self, moved_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """The same where each point has moved by its own (x, y): `moved_m` (2, rows, columns)."""
        points = moved_m * np.float32(_KEPT / (self.x_m[1] - self.x_m[0]))
        return self._looked_up(points[0], points[1])

    def _looked_up(self, across: NDArray[np.float32], down: NDArray[np.float32]) -> NDArray[np.float32]:
        """The cloth over itself at rest, moved by kept points (rows, columns)."""
        import cv2

        x, y = self._points[0] - across, self._points[1] - down
        # reflected about the row before the first, the means are those of the reflected cloth
        cloth = cv2.remap(self._means, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT_101)
        return np.asarray(cloth / self._rest)
