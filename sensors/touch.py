"""What any simulated sensor gives when something is pressed on it: the least that all of them have in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Touch:
    """A press of a known load.

    carried_n      newtons that the sensor's contact carries along the load: its pressure or its taxels, summed
    force_series   (T, taxels) float32 in `force_unit` at `rate_hz`, or None for a sensor without taxels
    frame          (rows, columns, 3) uint8 RGB, or None for a sensor without a camera
    """

    carried_n: float
    force_series: NDArray[np.float32] | None = None
    rate_hz: float = 0.0
    force_unit: str = ""
    frame: NDArray[np.uint8] | None = None
