"""Hold-on: slip is declared after several consecutive periods at or above the threshold."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


class HoldOn:
    """Declare slip after `periods` samples in a row at or above beta, end it after `release` below it.

    The paper's rule ("consistently exceeds the specified threshold over a period of time") is `release=1`; a
    longer one bridges the moments at which the score drops to zero during slip.
    """

    def __init__(self, periods: int, release: int = 1) -> None:
        self.periods = check_periods(periods, "periods")
        self.release = check_periods(release, "release")
        self.reset()

    def reset(self) -> None:
        """Forget every sample: no slip."""
        self._above = self._below = 0
        self._slipping = False

    def update(self, exceeded: bool) -> bool:
        """Take whether the score reached beta at the next sample; return whether there is slip."""
        if exceeded:
            self._above, self._below = self._above + 1, 0
            self._slipping = self._slipping or self._above >= self.periods
        else:
            self._above, self._below = 0, self._below + 1
            self._slipping = self._slipping and self._below < self.release
        return self._slipping


def hold_on(exceeded: ArrayLike, periods: int, release: int = 1) -> NDArray[np.bool_]:
    """Apply `HoldOn` to a whole sequence; (T,) bool -> (T,) bool. Raises ValueError for periods below 1."""
    above = np.asarray(exceeded, dtype=np.bool_)
    if above.ndim != 1:
        raise ValueError(f"expected one flag per sample, shape (T,), got {above.shape}")
    begins = _run_length(above) >= check_periods(periods, "periods")
    ends = _run_length(np.logical_not(above)) >= check_periods(release, "release")
    at = np.arange(len(above))
    last_begin = np.maximum.accumulate(np.where(begins, at, -1))
    last_end = np.maximum.accumulate(np.where(ends, at, -1))
    slipping: NDArray[np.bool_] = last_begin > last_end
    return slipping


def check_periods(periods: int, name: str = "periods") -> int:
    """Return the number of consecutive samples, at least 1. Raises ValueError."""
    if isinstance(periods, bool) or not isinstance(periods, int | np.integer) or periods < 1:
        raise ValueError(f"expected {name} to be a whole number of samples of at least 1, got {periods!r}")
    return int(periods)


def _run_length(flags: NDArray[np.bool_]) -> NDArray[np.intp]:
    at = np.arange(len(flags))
    return at - np.maximum.accumulate(np.where(flags, -1, at))
