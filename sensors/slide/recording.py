"""The arrays of one trial of a slip scene, with their units and clocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

STICK, PARTIAL, GROSS = 0, 1, 2
"""Values of `SlideRecording.state`: no contact or all of it sticks, part of it slips, (nearly) all of it slips."""


@dataclass(frozen=True)
class SlideRecording:
    """One trial: taxel forces and, on request, frames on one clock, with what the contact truly did.

    force_series   (t, 16) float32, read-back newtons at `rate_hz`; sample i is at i / rate_hz
    state          (t,) uint8, STICK, PARTIAL or GROSS, from the friction model
    onset_sample   first sample of gross slip; None where there is none
    frames         (f, h, w, 3) uint8 RGB or None, taken at `frame_time_s` (f,) on the clock of the force
    labels         id, object, kind, trial, unit, session, speed_mm_s, rotation_deg_s, load_n, direction_deg, seed
    truth          optional per sample: taxel_load (t, 16; N), shear_force (t, 2; N), slip_distance (t,; m),
                   slip_share (t,; of the load), stick_ratio (t,; of the area in contact), skin_shift (t, 2; m),
                   pose (t, 3; m, m, rad)
    """

    force_series: NDArray[np.float32]
    rate_hz: float
    state: NDArray[np.uint8]
    onset_sample: int | None
    labels: Mapping[str, Any]
    frames: NDArray[np.uint8] | None = None
    frame_time_s: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    truth: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    @property
    def force_time_s(self) -> NDArray[np.float64]:
        """Clock of `force_series`, seconds, (t,)."""
        return np.arange(len(self.force_series)) / self.rate_hz
