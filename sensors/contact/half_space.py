"""The elastic half-space by Love's influence coefficients; an oracle, 38-65 % wrong on thin pads.

Source: A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929); in the form of Johnson, "Contact Mechanics" (1985), eq. 3.25.
"""

from __future__ import annotations

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.spectral import SpectralCompliance


def love_coefficients(grid: Grid, modulus_pa: float) -> NDArray[np.float64]:
    """Displacement at the centre of each cell offset under unit pressure on one cell, m/Pa, shape (2n, 2n).

    Offsets are in FFT order (0, 1, .., n, -n + 1, .., -1); `modulus_pa` is E*.
    """
    size = 2 * grid.n
    offset = np.fft.fftfreq(size, 1 / size) * grid.pitch_m
    x, y = np.meshgrid(offset, offset)
    half = grid.pitch_m / 2
    total = np.zeros_like(x)
    for sx in (-1, 1):
        for sy in (-1, 1):
            a, b = x + sx * half, y + sy * half
            # a asinh(b/|a|) + b asinh(a/|b|): the corner potential of a uniformly loaded rectangle
            total += sx * sy * (a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b)))
    return total / (np.pi * modulus_pa)


class HalfSpaceCompliance(SpectralCompliance):
    """A half-space of modulus E* (pascals) under pressure that is uniform on each cell of `grid`."""

    def __init__(self, grid: Grid, modulus_pa: float, dtype: type[np.floating] = np.float64) -> None:
        coefficients = love_coefficients(grid, modulus_pa)
        symbol: NDArray[np.float64] = scipy.fft.rfft2(coefficients).real
        super().__init__(grid, symbol, dtype)
