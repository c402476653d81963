"""High-band energy of the force differences: slip vibrates, load changes are slow."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from slip.detector import DifferenceDetector, Stream
from slip.differences import CommonMode
from slip.energy import WindowTotal
from slip.samples import Floats, Missing
from slip.windows import pad_front, window_sum

ROWS_AT_A_TIME = 4_096


class Spectral(DifferenceDetector):
    """Mean square over taxels and window of the differences above `cutoff_hz`, in N^2.

    A linear-phase FIR high-pass of `taps` (odd) coefficients at `rate_hz` does the splitting; it delays the score
    by (taps - 1) / 2 samples and forgets a spike after `taps` of them. See `DifferenceDetector` for the rest.
    """

    def __init__(
        self,
        window: int = 50,
        *,
        cutoff_hz: float = 150.0,
        rate_hz: float = 1000.0,
        taps: int = 31,
        common_mode: CommonMode = "keep",
        scale: ArrayLike | None = None,
        nan: Missing = "refuse",
    ) -> None:
        self.cutoff_hz, self.rate_hz = float(cutoff_hz), float(rate_hz)
        self.coefficients = high_pass(self.cutoff_hz, self.rate_hz, taps)
        super().__init__(window, common_mode=common_mode, scale=scale, nan=nan)

    @property
    def settling(self) -> int:
        """Samples after a start or a spike until the score depends on what came since only."""
        return self.window + len(self.coefficients)

    def _start(self, taxels: int) -> Stream:
        return _HighBand(self.coefficients, self.window, taxels)

    def _score_differences(self, differences: Floats) -> Floats:
        taps = len(self.coefficients)
        padded = pad_front(differences, taps - 1)
        energy = np.empty(len(differences))
        for first in range(0, len(differences), ROWS_AT_A_TIME):
            block = padded[first : first + ROWS_AT_A_TIME + taps - 1]
            rows = len(block) - taps + 1
            # Tap by tap in the stream's order: the two give the same bits.
            high = self.coefficients[0] * block[:rows]
            for tap in range(1, taps):
                high += self.coefficients[tap] * block[tap : tap + rows]
            energy[first : first + rows] = (high * high).sum(axis=1)
        return window_sum(pad_front(energy, self.window - 1), self.window) / float(self.window * differences.shape[1])


class _HighBand:
    def __init__(self, coefficients: Floats, window: int, taxels: int) -> None:
        self._coefficients = coefficients[:, None]
        self._recent = np.zeros((len(coefficients), taxels))
        self._total = WindowTotal(window, float(window * taxels))

    def push(self, difference: Floats) -> float:
        self._recent[:-1] = self._recent[1:]
        self._recent[-1] = difference
        high = np.add.reduce(self._coefficients * self._recent, axis=0)
        return self._total.add(float((high * high).sum()))


def high_pass(cutoff_hz: float, rate_hz: float, taps: int) -> Floats:
    """Windowed-sinc (Blackman) FIR high-pass, unit gain at half the rate, none at 0; (taps,).

    Raises ValueError for an even or too small number of taps or a cutoff outside (0, rate / 2).
    """
    if taps < 3 or taps % 2 == 0:
        raise ValueError(f"expected an odd number of taps of at least 3, got {taps}")
    if not 0.0 < cutoff_hz < rate_hz / 2.0:
        raise ValueError(f"expected a cutoff between 0 and {rate_hz / 2.0:g} Hz, half the rate, got {cutoff_hz:g}")
    at = np.arange(taps) - (taps - 1) / 2
    low = np.sinc(2.0 * cutoff_hz / rate_hz * at) * np.blackman(taps + 2)[1:-1]
    high = -low / low.sum()
    high[taps // 2] += 1.0
    alternating = np.where(np.arange(taps) % 2 == (taps // 2) % 2, 1.0, -1.0)
    gain: float = (high * alternating).sum()
    return high / gain
