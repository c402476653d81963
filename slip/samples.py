"""What a force sample may be: finite, bounded, regular in time; a missing one is refused or skipped."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Missing = Literal["refuse", "skip"]

FORCE_LIMIT_N = 1e100  # squares of larger readings, summed over a window, would leave the range of a double
CLOCK_TOLERANCE = 0.01  # a step may differ from the first by this share of it


def as_sequence(force: ArrayLike, missing: Missing = "refuse") -> tuple[Floats, NDArray[np.bool_]]:
    """Check a force sequence (T, taxels) in newtons; return it as float64 with the mask (T,) of samples to keep.

    A sample with a NaN on any taxel is missing: refused, or with ``missing="skip"`` left out as if it had
    never been taken. Infinite readings are refused always. Raises ValueError.
    """
    values = np.asarray(force, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] == 0:
        raise ValueError(f"expected forces of shape (T, taxels), got {values.shape}: one row per sample")
    if _all_finite(values):
        return values, np.ones(len(values), dtype=np.bool_)
    kept: NDArray[np.bool_] = np.logical_not(np.isnan(values).any(axis=1))
    if missing == "refuse" and not kept.all():
        first = int(np.argmin(kept))
        raise ValueError(
            f"expected finite forces, got NaN in {int((~kept).sum())} of {len(kept)} samples, first at "
            f'sample {first}: mend the sequence or pass nan="skip"'
        )
    if not _all_finite(values[kept]):
        raise ValueError(f"expected forces within {FORCE_LIMIT_N:g} N, got infinite or larger readings")
    return values, kept


def as_sample(sample: ArrayLike, taxels: int | None, missing: Missing = "refuse") -> Floats | None:
    """Check one sample (taxels,) in newtons; None where it is missing and skipped. Raises ValueError."""
    values = np.array(sample, dtype=np.float64)
    if values.ndim != 1 or values.size == 0 or values.size != (taxels or values.size):
        raise ValueError(f"expected a sample of shape ({taxels or 'taxels'},), got {values.shape}")
    if _all_finite(values):
        return values
    if not np.isnan(values).any():
        raise ValueError(f"expected forces within {FORCE_LIMIT_N:g} N, got an infinite or larger reading")
    if missing == "refuse":
        raise ValueError('expected finite forces, got NaN: leave the sample out or pass nan="skip"')
    return None


def check_regular(time_s: ArrayLike, samples: int) -> None:
    """Refuse timestamps (T,) in seconds whose step varies by more than 1 % of the median one.

    Every detector here works on sample differences, so its score means nothing at a varying rate.
    """
    times = np.asarray(time_s, dtype=np.float64)
    if times.shape != (samples,):
        raise ValueError(f"expected {samples} timestamps, one per sample, got an array of shape {times.shape}")
    steps = np.diff(times)
    if len(steps) == 0:
        return
    step = float(np.median(steps))
    off = ~(np.abs(steps - step) <= CLOCK_TOLERANCE * abs(step))
    if not step > 0.0 or off.any():
        first = int(np.argmax(off)) + 1
        raise ValueError(
            f"expected regular sampling, got a step of {steps[first - 1]:g} s before sample {first} where the "
            f"usual one is {step:g} s: resample the sequence to a fixed rate"
        )


class SampleClock:
    """Refuse a stream whose step departs from its first one by more than 1 %."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._step: float | None = None

    def tick(self, time_s: float) -> None:
        """Take the next sample's time in seconds; raise ValueError where sampling is irregular."""
        if self._last is not None:
            step = time_s - self._last
            expected = step if self._step is None else self._step
            if not step > 0.0 or not abs(step - expected) <= CLOCK_TOLERANCE * expected:
                raise ValueError(
                    f"expected regular sampling, got a step of {step:g} s at {time_s:g} s where the first was "
                    f"{expected:g} s: resample the stream to a fixed rate, or reset the detector"
                )
            self._step = expected
        self._last = time_s


def _all_finite(values: Floats) -> bool:
    # Both bounds fail on NaN, and neither makes a copy.
    return bool(values.max(initial=0.0) <= FORCE_LIMIT_N and values.min(initial=0.0) >= -FORCE_LIMIT_N)
