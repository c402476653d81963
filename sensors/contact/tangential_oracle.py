"""Cattaneo's and Mindlin's closed forms for a sphere that is pressed and then pulled sideways; an oracle for tests.

A rigid sphere on a half-space; Goodman's decoupling. Exact for nu = 0, where the slip is along the pull; else the slip
across it is neglected. Source: Johnson, "Contact Mechanics" (1985), sections 7.2 and 7.4; reversal by R. D. Mindlin,
H. Deresiewicz, J. Appl. Mech. 20 (1953).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.hertz import HertzSphere

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CattaneoMindlin:
    """The pressed `sphere` on a half-space of `shear_modulus_pa` and `poisson_ratio`, with a friction coefficient."""

    sphere: HertzSphere
    shear_modulus_pa: float
    poisson_ratio: float
    friction: float

    @property
    def limit_n(self) -> float:
        """mu P, the force at which the sphere slides."""
        return self.friction * self.sphere.force_n

    def stick_radius(self, force_n: float) -> float:
        """c = a (1 - Q / (mu P))^(1/3) in metres."""
        return float(self.sphere.contact_radius_m * np.cbrt(1 - force_n / self.limit_n))

    def traction(self, r_m: Floats, force_n: float) -> Floats:
        """q(r) in Pa under a monotonic pull; same shape as `r_m`."""
        a, c = self.sphere.contact_radius_m, self.stick_radius(force_n)
        full = np.sqrt(np.maximum(1 - (r_m / a) ** 2, 0))
        inner = np.sqrt(np.maximum(c**2 - r_m**2, 0)) / a
        return self.friction * self.sphere.peak_pressure_pa * (full - inner)

    def shift(self, force_n: float) -> float:
        """Shift in metres under a monotonic pull: 3 mu P (2 - nu) / (16 a G) [1 - (1 - Q / (mu P))^(2/3)]."""
        a, c = self.sphere.contact_radius_m, self.stick_radius(force_n)
        slack = 3 * self.limit_n * (2 - self.poisson_ratio) / (16 * a * self.shear_modulus_pa)
        return slack * (1 - (c / a) ** 2)

    def shift_after_reversal(self, peak_n: float, force_n: float) -> float:
        """Shift on the way back from `peak_n` to `force_n`, -peak <= force <= peak."""
        return self.shift(peak_n) - 2 * self.shift((peak_n - force_n) / 2)

    def traction_after_reversal(self, r_m: Floats, peak_n: float, force_n: float) -> Floats:
        """q(r) on the way back, in Pa."""
        return self.traction(r_m, peak_n) - 2 * self.traction(r_m, (peak_n - force_n) / 2)

    def loop_work(self, peak_n: float) -> float:
        """Friction work (J) of one closed loop between +-`peak_n`."""
        a, ratio = self.sphere.contact_radius_m, 1 - peak_n / self.limit_n
        unit = 9 * (2 - self.poisson_ratio) * self.limit_n**2 / (10 * a * self.shear_modulus_pa)
        return unit * (1 - ratio ** (5 / 3) - 5 * (1 - ratio) / 6 * (1 + ratio ** (2 / 3)))
