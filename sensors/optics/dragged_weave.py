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
    def _weave(self) -> NDArray[np.float32]:
        fine = self.canvas.weave(self.x_m, self.y_m, self.rng, _FINE)
        group = _FINE // _KEPT
        shape = (fine.shape[0] // group, group, fine.shape[1] // group, group)
        return np.ascontiguousarray(fine.reshape(shape).mean(axis=(1, 3)), np.float32)

    @cached_property
    def _rest(self) -> NDArray[np.float32]:
        return self._averaged(self._weave)

    @cached_property
    def _points(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        rows, columns = self._weave.shape
        x, y = np.meshgrid(np.arange(columns, dtype=np.float32), np.arange(rows, dtype=np.float32))
        return x, y

    def ratio(self, shape: NDArray[np.float32], shift_m: tuple[float, float]) -> NDArray[np.float32]:
        """Brightness (rows, columns) over that at rest, each point having moved by `shape` (rows, columns) x shift."""
        import cv2

        points_per_m = _KEPT / (self.x_m[1] - self.x_m[0])
        columns, rows = self._points[0].shape[::-1]
        moved = cv2.resize(shape, (columns, rows), interpolation=cv2.INTER_LINEAR)
        x = self._points[0] - moved * np.float32(shift_m[0] * points_per_m)
        y = self._points[1] - moved * np.float32(shift_m[1] * points_per_m)
        cloth = cv2.remap(self._weave, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
        return np.asarray(self._averaged(cloth) / self._rest)

    @staticmethod
    def _averaged(weave: NDArray[np.float32]) -> NDArray[np.float32]:
        # two by two, written out: six times as fast as a mean over short axes, and the same bits
        upper, lower = weave[0::_KEPT], weave[1::_KEPT]
        total = (upper[:, 0::_KEPT] + upper[:, 1::_KEPT]) + (lower[:, 0::_KEPT] + lower[:, 1::_KEPT])
        return np.asarray(total / np.float32(_KEPT**2))
