"""Real presses of a ball into a gel sensor: what a calibration is fitted on and scored against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CROP_RADII = 2.2
"""Half-side of the square around a contact that is fitted and scored, in contact radii."""


@dataclass(frozen=True)
class BallPress:
    """One press: its number, frame (rows, columns, 3) uint8 RGB, contact centre and radius in pixels."""

    number: int
    frame: NDArray[np.uint8]
    center_x_px: float
    center_y_px: float
    contact_radius_px: float

    def crop(self) -> tuple[slice, slice]:
        """Rows and columns of the contact crop, clipped to the frame."""
        half = CROP_RADII * self.contact_radius_px
        rows, columns = self.frame.shape[:2]
        return _clipped(self.center_y_px, half, rows), _clipped(self.center_x_px, half, columns)


@dataclass(frozen=True)
class BallPresses:
    """Presses of one sensor with its untouched frame, the ball's radius and the size of a pixel."""

    rest: NDArray[np.uint8]
    presses: tuple[BallPress, ...]
    ball_radius_mm: float
    pixel_mm: float

    def fitted(self) -> tuple[BallPress, ...]:
        """Those that a calibration may see: numbers divisible by 4."""
        return tuple(press for press in self.presses if press.number % 4 == 0)

    def held_out(self) -> tuple[BallPress, ...]:
        """Those that score it: the other even numbers. Odd numbers are for neither."""
        return tuple(press for press in self.presses if press.number % 4 == 2)


def interval_of_mean(values: Sequence[float], level: float = 0.95) -> tuple[float, float]:
    """Student's interval of a mean over independent presses; (nan, nan) for fewer than two."""
    from scipy.stats import t

    if len(values) < 2:
        return float("nan"), float("nan")
    half = t.ppf((1 + level) / 2, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values))
    return float(np.mean(values) - half), float(np.mean(values) + half)


def _clipped(center: float, half: float, extent: int) -> slice:
    return slice(max(0, round(center - half)), min(extent, round(center + half) + 1))
