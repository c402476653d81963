"""Normal force of a soft taxel pad: a spring and damper that never pulls and does not jump at touch.

f_n = max(0, k_n d + s(d) k_d d'), with s a smooth step from 0 at touch to 1 at the fade depth: a plain spring-damper
would hit with the force k_d d' at the first contact.

Source: the soft contacts of S. Moisio, B. Leon, P. Korkealaakso, A. Morales, "Simulation of a tactile sensor using soft
contacts for robot grasping applications"; the fade is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class PadSpring:
    """Spring k_n (N/m), damper k_d (N s/m) and the depth (m) over which the damper fades in."""

    stiffness: float
    damping: float
    fade_m: float

    def __post_init__(self) -> None:
        if not (0 < self.stiffness < np.inf and 0 <= self.damping < np.inf and 0 < self.fade_m < np.inf):
            raise ValueError(
                "a pad needs stiffness > 0, damping >= 0 and fade_m > 0, got "
                f"stiffness={self.stiffness}, damping={self.damping}, fade_m={self.fade_m}"
            )

    def force(self, depth: NDArray[np.float64], depth_rate: NDArray[np.float64]) -> NDArray[np.float64]:
        """Normal force (N) at penetration `depth` (m, negative outside) that changes at `depth_rate` (m/s)."""
        inside = np.clip(np.asarray(depth, dtype=np.float64) / self.fade_m, 0, 1)
        fade = inside * inside * (3 - 2 * inside)
        return np.maximum(0, self.stiffness * np.maximum(depth, 0) + self.damping * fade * depth_rate)
