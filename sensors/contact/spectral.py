"""Convolution compliances on a zero-padded grid, and their exact restriction to a window."""

from __future__ import annotations

from functools import cached_property, lru_cache, partial

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.influence import translated

_MOST_WINDOWS = 4
"""Windows kept by their shape, the latest used: along a path most come back."""


def padded_wave_numbers(grid: Grid) -> NDArray[np.float64]:
    """|k| in rad/m of the real FFT on the domain of twice the grid's size, shape (2n, n + 1)."""
    size = 2 * grid.n
    kx = 2 * np.pi * np.fft.rfftfreq(size, grid.pitch_m)
    ky = 2 * np.pi * np.fft.fftfreq(size, grid.pitch_m)
    return np.hypot(ky[:, None], kx[None, :])


class SpectralCompliance:
    """Displacement = symbol x pressure in Fourier space, non-periodic by padding to twice the size.

    `symbol` has the shape of `padded_wave_numbers(grid)`, in metres per pascal. Its inverse, on the same padded
    domain and scaled to at most one, preconditions the solver (an unpadded inverse can cycle for ever).
    """

    def __init__(self, grid: Grid, symbol: NDArray[np.float64], dtype: type[np.floating] = np.float64) -> None:
        self.grid = grid
        self.dtype = np.dtype(dtype)
        floor = symbol[symbol > 0].min()
        self._symbol = symbol.astype(self.dtype)
        self._inverse = (floor / np.maximum(symbol, floor)).astype(self.dtype)
        size = (2 * grid.n, 2 * grid.n)
        self._kernel: NDArray[np.floating] = scipy.fft.irfft2(self._symbol, size)
        self._inverse_kernel: NDArray[np.floating] = scipy.fft.irfft2(self._inverse, size)
        made = partial(SpectralWindow, kernel=self._kernel, inverse_kernel=self._inverse_kernel)
        self._window = lru_cache(maxsize=_MOST_WINDOWS)(made)

    def filter(self, field: NDArray[np.floating], symbol: NDArray[np.floating]) -> NDArray[np.floating]:
        """Apply a symbol of the padded domain to an (n, n) field; returns (n, n)."""
        n = self.grid.n
        spectrum = scipy.fft.rfft2(np.asarray(field, self.dtype), (2 * n, 2 * n))
        filtered: NDArray[np.floating] = scipy.fft.irfft2(spectrum * symbol, (2 * n, 2 * n))
        return filtered[:n, :n]

    def displacement(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Displacement of the touched surface (m) under `pressure` (Pa), both (n, n)."""
        return self.filter(pressure, self._symbol)

    def influence(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.float64]:
        """Displacement (m) of each of the cells under unit pressure (Pa) on each: (cells, cells), symmetric."""
        return translated(self._influence_table, rows, columns)

    @cached_property
    def _influence_table(self) -> NDArray[np.float64]:
        n = self.grid.n
        return np.ascontiguousarray(self._kernel[:n, :n], np.float64)

    def window(self, rows: slice, columns: slice) -> SpectralWindow:
        """The compliance inside a rectangle: the same influence coefficients, on a smaller FFT."""
        shape = (rows.stop - rows.start, columns.stop - columns.start)
        return self._window(shape)


class SpectralWindow:
    """Influence coefficients of a `SpectralCompliance` cut to the offsets that occur inside a window."""

    def __init__(
        self, shape: tuple[int, int], kernel: NDArray[np.floating], inverse_kernel: NDArray[np.floating]
    ) -> None:
        self._shape = shape
        # at most 2 x shape - 1 offsets; never more than the padded grid itself
        self._size = tuple(
            min(scipy.fft.next_fast_len(2 * extent, real=True), full)
            for extent, full in zip(shape, kernel.shape, strict=True)
        )
        self._symbol = self._cut(kernel)
        self._inverse = self._cut(inverse_kernel)

    def _cut(self, kernel: NDArray[np.floating]) -> NDArray[np.complexfloating]:
        index = [np.fft.fftfreq(size, 1 / size).astype(int) for size in self._size]
        cut = kernel[np.ix_(index[0], index[1])]
        spectrum: NDArray[np.complexfloating] = scipy.fft.rfft2(cut)
        return spectrum

    def _apply(self, field: NDArray[np.floating], symbol: NDArray[np.complexfloating]) -> NDArray[np.floating]:
        spectrum = scipy.fft.rfft2(field, self._size)
        out: NDArray[np.floating] = scipy.fft.irfft2(spectrum * symbol, self._size)
        return out[: self._shape[0], : self._shape[1]]

    def displacement(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Displacement (m) inside the window under `pressure` (Pa) inside the window."""
        return self._apply(pressure, self._symbol)

    def precondition(self, residual: NDArray[np.floating]) -> NDArray[np.floating]:
        """The inverse symbol, cut to the window."""
        return self._apply(residual, self._inverse)
