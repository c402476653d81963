"""The paired arrays of one trial, with their units and clocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Recording:
    """One press: a frame, a rest frame and the taxels' forces, from one pressure field.

    image, image_rest   (H, W, 3) uint8 RGB, at the hold and before contact
    force_series        (T, taxels) float32, read-back newtons at `rate_hz` over approach, hold and release
    force               (taxels,) float32, mean of `force_series` over the hold
    taxel_load          (taxels,) float32, true newtons on each taxel at the hold, before the electronics
    hold                [first, last) sample of the hold
    image_time_s        time of the frame on the clock of the force (sample i is at i / rate_hz)
    total_force_n       load of the press; indentation_mm: depth of the object into the sensor at that load
    labels              id, object, label, press, unit, session, round, seed, pose_x_mm, pose_y_mm, pose_deg
    truth               optional fields on the contact grid: displacement (m), pressure (Pa), contact (bool)
    """

    image: NDArray[np.uint8]
    image_rest: NDArray[np.uint8]
    force_series: NDArray[np.float32]
    rate_hz: float
    force: NDArray[np.float32]
    taxel_load: NDArray[np.float32]
    total_force_n: float
    indentation_mm: float
    hold: tuple[int, int]
    image_time_s: float
    labels: Mapping[str, Any]
    truth: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    @property
    def force_time_s(self) -> NDArray[np.float64]:
        """Clock of `force_series`, seconds, (T,)."""
        return np.arange(len(self.force_series)) / self.rate_hz
