"""Sliding sums and minima that never subtract, so that a spike leaves no rounding behind it."""

from __future__ import annotations

import numpy as np

from slip.samples import Floats


def check_window(window: int) -> int:
    """Return the window in samples; a score over differences needs at least 2. Raises ValueError."""
    if isinstance(window, bool) or not isinstance(window, int | np.integer) or window < 2:
        raise ValueError(f"expected a window of at least 2 samples, got {window!r}")
    return int(window)


def pad_front(values: Floats, count: int) -> Floats:
    """Put `count` zero rows before (T, ...): the array is taken to have rested before the first sample."""
    return np.concatenate([np.zeros((count, *values.shape[1:])), values])


def window_sum(values: Floats, window: int) -> Floats:
    """Sum over every run of `window` values along axis 0; (T + window - 1, ...) -> (T, ...).

    Sums of 1, 2, 4, ... values are doubled and joined by the binary digits of the window: about
    2 log2(window) passes, each sum made of its own window's values only, rounding of order log2(window).
    """
    length = len(values) - window + 1
    power, width, offset = values, 1, 0
    total: Floats | None = None
    while True:
        if window & width:
            part = power[offset : offset + length]
            total = part.copy() if total is None else np.add(total, part, out=total)
            offset += width
        if 2 * width > window:
            break
        power = power[: len(power) - width] + power[width:]
        width *= 2
    assert total is not None
    return total


def window_min(values: Floats, window: int) -> Floats:
    """Smallest of every run of `window` values along axis 0; (T + window - 1, ...) -> (T, ...)."""
    least, width = values, 1
    while width < window:
        step = min(width, window - width)
        least = np.minimum(least[: len(least) - step], least[step:])
        width += step
    return least.copy() if least is values else least
