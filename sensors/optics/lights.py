"""Red, green and blue light beads along the rim of the housing, and what they shed on a point of the skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LedRing:
    """One arc of beads per colour: azimuth of its middle (deg), power; ring radius and height above the skin (m).

    `crosstalk` is the share of each colour that the camera's other two channels see.
    """

    azimuths_deg: tuple[float, float, float] = (90.0, 210.0, 330.0)
    power: tuple[float, float, float] = (1.0, 1.0, 1.0)
    radius_m: float = 0.050
    height_m: float = 0.030
    arc_deg: float = 100.0
    beads: int = 7
    crosstalk: float = 0.08

    def mixing(self) -> NDArray[np.float64]:
        """(channels, colours) matrix of what each camera channel sees of each arc."""
        mixing = np.full((3, 3), self.crosstalk)
        np.fill_diagonal(mixing, 1 - 2 * self.crosstalk)
        return mixing * np.asarray(self.power)

    def irradiance(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float32]:
        """Irradiance vectors E, shape (3 channels, 3 components, *x.shape): a facet of normal n receives n . E.

        Inverse-square falloff from each bead; a flat facet at the centre receives 1 from each arc. The height of the
        surface (millimetres) is neglected beside the distance to the beads (centimetres).
        """
        arcs = np.stack([self._arc(azimuth, x, y) for azimuth in self.azimuths_deg])
        return np.einsum("cl,lk...->ck...", self.mixing(), arcs).astype(np.float32)

    def _arc(self, azimuth_deg: float, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        total = np.zeros((3, *x.shape))
        half = self.arc_deg / 2
        for bead in np.deg2rad(azimuth_deg + np.linspace(-half, half, self.beads)):
            towards = np.stack(
                (
                    self.radius_m * np.cos(bead) - x,
                    self.radius_m * np.sin(bead) - y,
                    np.full_like(x, self.height_m),
                )
            )
            total += towards / (towards**2).sum(axis=0) ** 1.5
        centre = np.hypot(self.radius_m, self.height_m)
        return total * (centre**3 / (self.height_m * self.beads))
