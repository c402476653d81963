"""An elastic layer bonded to a rigid base, pressed on its frictionless top.

Plane-wave solution of the layer (k = |wave vector|, H = k h, C = cosh H, S = sinh H):

    D    = H^2 + 4 (1 - nu)^2 C^2 - (1 - 2 nu)^2 S^2
    top  = (2 / (E* k)) [(3 - 4 nu) S C - H] / D      displacement per pressure
    base = 2 (1 - nu) [2 (1 - nu) C + H S] / D        normal stress at the base per pressure on top

Both follow from the Airy function with u = w = 0 at the base and no shear on top; `top` is the form given by
Johnson, "Contact Mechanics" (1985), section 5.8, for a bonded layer; the tests rebuild both by a matrix exponential.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.hertz import plane_strain_modulus
from sensors.contact.spectral import SpectralCompliance, padded_wave_numbers

_LARGE = 20.0
"""kh beyond which the layer is a half-space to double precision (e^-40)."""


@dataclass(frozen=True)
class LayerMaterial:
    """Thickness (m), Young's modulus (Pa) and Poisson's ratio of a bonded elastic layer."""

    thickness_m: float
    youngs_modulus_pa: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        if not (0 < self.thickness_m < np.inf and 0 < self.youngs_modulus_pa < np.inf):
            raise ValueError(
                "a layer needs a finite positive thickness and modulus, got "
                f"thickness_m={self.thickness_m}, youngs_modulus_pa={self.youngs_modulus_pa}"
            )
        if not 0 <= self.poisson_ratio <= 0.5:
            raise ValueError(f"poisson_ratio must lie in [0, 0.5], got {self.poisson_ratio}")

    @property
    def modulus_pa(self) -> float:
        """E* in pascals."""
        return plane_strain_modulus(self.youngs_modulus_pa, self.poisson_ratio)

    def surface_compliance(self, k: NDArray[np.float64]) -> NDArray[np.float64]:
        """Top displacement per top pressure (m/Pa) at wave number `k` >= 0 (rad/m), same shape as `k`."""
        nu, h = self.poisson_ratio, self.thickness_m
        kh = np.asarray(k, dtype=np.float64) * h
        small = np.minimum(kh, _LARGE)
        kappa = 3 - 4 * nu
        # (kappa S C - H) / H = kappa (sinh 2H - 2H) / 2H + (kappa - 1): no cancellation at small H
        numerator = kappa * _sinh_excess(2 * small) + (kappa - 1)
        denominator = _denominator(small, nu)
        finite = 2 * h / self.modulus_pa * numerator / denominator
        with np.errstate(divide="ignore"):
            deep = 2 / (self.modulus_pa * np.where(kh > 0, kh / h, 1))
        return np.where(kh >= _LARGE, deep, finite)

    def base_transfer(self, k: NDArray[np.float64]) -> NDArray[np.float64]:
        """Normal stress at the base per pressure on top (dimensionless), same shape as `k`."""
        nu = self.poisson_ratio
        kh = np.asarray(k, dtype=np.float64) * self.thickness_m
        small = np.minimum(kh, _LARGE)
        finite = 2 * (1 - nu) * (2 * (1 - nu) * np.cosh(small) + small * np.sinh(small)) / _denominator(small, nu)
        return np.where(kh >= _LARGE, finite * np.exp(-(kh - small)), finite)


def _sinh_excess(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """(sinh x - x) / x, by its series where the difference would cancel."""
    x2 = x * x
    series = x2 / 6 * (1 + x2 / 20 * (1 + x2 / 42 * (1 + x2 / 72 * (1 + x2 / 110 * (1 + x2 / 156)))))
    with np.errstate(invalid="ignore", divide="ignore"):
        direct = np.sinh(x) / np.where(x > 0, x, 1) - 1
    return np.where(x < 1, series, direct)


def _denominator(kh: NDArray[np.float64], nu: float) -> NDArray[np.float64]:
    # 4 (1 - nu)^2 C^2 - (1 - 2 nu)^2 S^2 = 4 (1 - nu)^2 + kappa S^2, a sum of positive terms
    return kh**2 + 4 * (1 - nu) ** 2 + (3 - 4 * nu) * np.sinh(kh) ** 2


class LayerCompliance(SpectralCompliance):
    """The `layer` rung: a bonded layer on `grid`, by FFT on a domain padded to twice the size.

    The pad's images in the periodic extension are a full grid width away; a bonded layer forgets within a few
    thicknesses, so the grid must be wider than the contact by that much.
    """

    def __init__(self, grid: Grid, material: LayerMaterial, dtype: type[np.floating] = np.float64) -> None:
        self.material = material
        super().__init__(grid, material.surface_compliance(padded_wave_numbers(grid)), dtype)
        self._base = material.base_transfer(padded_wave_numbers(grid)).astype(self.dtype)

    def coarser(self) -> LayerCompliance:
        """The same layer on a grid of half as many cells along a side."""
        return LayerCompliance(self.grid.coarser(), self.material, self.dtype.type)

    def base_pressure(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Normal stress that the base feels (Pa) under `pressure` on top, both (n, n); same sum."""
        return self.filter(pressure, self._base)
