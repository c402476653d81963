"""Hertz's closed forms for a rigid sphere on an elastic half-space; an oracle for tests.

Source: K. L. Johnson, "Contact Mechanics" (1985), section 4.2. E* = E / (1 - nu^2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


def plane_strain_modulus(youngs_modulus_pa: float, poisson_ratio: float) -> float:
    """E* = E / (1 - nu^2) in pascals."""
    return youngs_modulus_pa / (1 - poisson_ratio**2)


@dataclass(frozen=True)
class HertzSphere:
    """A rigid sphere of `radius_m` pressed `indentation_m` into a half-space of modulus E* (pascals)."""

    radius_m: float
    indentation_m: float
    modulus_pa: float

    @property
    def contact_radius_m(self) -> float:
        """a = sqrt(R d)."""
        return math.sqrt(self.radius_m * self.indentation_m)

    @property
    def force_n(self) -> float:
        """F = 4/3 E* sqrt(R) d^(3/2)."""
        return 4 / 3 * self.modulus_pa * math.sqrt(self.radius_m) * self.indentation_m**1.5

    @property
    def peak_pressure_pa(self) -> float:
        """p0 = 2 E* a / (pi R)."""
        return 2 * self.modulus_pa * self.contact_radius_m / (math.pi * self.radius_m)

    def pressure(self, r_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """p(r) = p0 sqrt(1 - r^2 / a^2) inside the contact, zero outside; same shape as `r_m`, pascals."""
        inside = np.maximum(1 - (r_m / self.contact_radius_m) ** 2, 0)
        return self.peak_pressure_pa * np.sqrt(inside)


def flat_punch_force(radius_m: float, indentation_m: float, modulus_pa: float) -> float:
    """Force in newtons of a flat circular punch on a half-space: F = 2 E* a d (Johnson, eq. 3.36)."""
    return 2 * modulus_pa * radius_m * indentation_m
