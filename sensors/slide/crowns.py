"""Thread crowns exchange load while the object's roughness rides over the weave.

Where the object slides, each crown meets new asperities: its load rises and falls with the distance slid, at the pitch
of the weave and at the shorter and longer wavelengths of the roughness, and its neighbours make up for it. Where it
sticks nothing changes. How much a crown's load varies belongs to the object's finish (`SlidingBody.crown_contrast`).
Linear elasticity would allow far more: asperities of 1 um at the weave's pitch press the film with E* k / 2 = 28 kPa,
beside mean pressures of 50 to 100 kPa.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_WEAVE_VARIANCE = 0.5
_ROUGH_WAVES = 10
_ROUGH_RANGE = (0.5, 6.0)
"""Wavelengths of the roughness, log-uniform, in thread pitches."""
_LEAST_LOAD = 0.05
"""A crown never lets go altogether."""


@dataclass(frozen=True)
class Crowns:
    """Wave vectors (w, 2; rad/m) that all cells share, phases (n, w) and relative amplitudes (n, w) of each cell."""

    waves: Array
    phase: Array
    amplitude: Array

    @classmethod
    def draw(cls, area: Array, contrast: float, thread_pitch_m: float, rng: np.random.Generator) -> Crowns:
        """Draw the surface under cells of `area` (n,); a cell of m crowns varies by contrast / sqrt(m)."""
        weave = 2 * np.pi / thread_pitch_m * np.eye(2)
        length = thread_pitch_m * _ROUGH_RANGE[0] * (_ROUGH_RANGE[1] / _ROUGH_RANGE[0]) ** rng.random(_ROUGH_WAVES)
        angle = rng.uniform(0, np.pi, _ROUGH_WAVES)
        rough = 2 * np.pi / length[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
        variance = np.concatenate(
            (np.full(2, _WEAVE_VARIANCE / 2), np.full(_ROUGH_WAVES, (1 - _WEAVE_VARIANCE) / _ROUGH_WAVES))
        )
        crowns = np.maximum(area / thread_pitch_m**2, 1)
        waves = np.concatenate((weave, rough))
        phase = rng.uniform(0, 2 * np.pi, (len(area), len(waves)))
        return cls(waves, phase, contrast / np.sqrt(crowns)[:, None] * np.sqrt(2 * variance))

    def exchange(self, load: Array, slip: Array) -> Array:
        """Loads (n,) of the cells after each has slid by `slip` (n, 2; m); the sum of `load` (n,) is kept."""
        relative = (self.amplitude * np.cos(slip @ self.waves.T + self.phase)).sum(axis=1)
        changed = load * np.maximum(1 + relative, _LEAST_LOAD)
        total = changed.sum()
        return changed * (load.sum() / total) if total > 0 else changed
