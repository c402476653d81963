"""The baseline: how much the forces move at all."""

from __future__ import annotations

import numpy as np

from slip.detector import DifferenceDetector, Stream
from slip.samples import Floats
from slip.windows import pad_front, window_sum


class Energy(DifferenceDetector):
    """Mean |d| over the taxels and the last `window` differences, in newtons per sample.

    See `DifferenceDetector` for the parameters.
    """

    def _start(self, taxels: int) -> Stream:
        return WindowTotal(self.window, float(self.window * taxels))

    def _score_differences(self, differences: Floats) -> Floats:
        moved = np.abs(differences).sum(axis=1)
        return window_sum(pad_front(moved, self.window - 1), self.window) / float(self.window * differences.shape[1])


class WindowTotal:
    """Sum of |d| over the last `window` differences over a divisor, added up anew at each one: no drift."""

    def __init__(self, window: int, divisor: float) -> None:
        self._ring = np.zeros(window)
        self._divisor = divisor
        self._slot = 0

    def push(self, difference: Floats) -> float:
        """Take the next difference (taxels,); return the mean."""
        return self.add(float(np.abs(difference).sum()))

    def add(self, value: float) -> float:
        """Take the next value as it stands; return the window's total over the divisor."""
        self._ring[self._slot] = value
        self._slot = (self._slot + 1) % len(self._ring)
        return float(self._ring.sum()) / self._divisor
