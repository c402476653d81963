"""In-plane compliance of a bonded layer and of a half-space: surface shift per shear traction.

A plane wave of traction along its wave vector moves the surface along it, one across moves it across (H = k h,
C = cosh H, S = sinh H, kappa = 3 - 4 nu, G the shear modulus):

    along  = (2 / (E* k)) [kappa S C + H] / [H^2 + 4 (1 - nu)^2 + kappa S^2]
    across = tanh H / (G k)

k -> 0 gives h / G for both, k -> inf the half-space's 2 / (E* k) and 1 / (G k). Goodman's approximation: shear is taken
not to move the surface up or down (exact for nu = 1/2 on a half-space), so a given pressure stays as it is. The tests
rebuild both symbols by a matrix exponential. Source for the half-space: V. Cerruti, in the form of Johnson, "Contact
Mechanics" (1985), eq. 3.75.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerMaterial
from sensors.contact.spectral import padded_wave_numbers

Floats = NDArray[np.floating]

_LARGE = 20.0
"""kh beyond which the layer is a half-space to double precision (e^-40)."""

_BOUND_STEPS = 4


class TangentialCompliance(Protocol):
    """A linear, symmetric, positive map from shear traction (2, n, n) to in-plane shift of the touched surface."""

    grid: Grid
    dtype: np.dtype[np.floating]

    def displacement(self, traction: Floats) -> Floats:
        """In-plane displacement (x, y) of the surface (m) under `traction` (Pa), both (2, n, n)."""
        ...

    def window(self, rows: slice, columns: slice) -> TangentialWindow:
        """The same compliance restricted to a rectangle."""
        ...


def in_plane_symbols(material: LayerMaterial, k: NDArray[np.float64]) -> tuple[Floats, Floats]:
    """Displacement per traction (m/Pa) along and across the wave vector, at |k| >= 0 (rad/m); each of `k`'s shape."""
    nu, h = material.poisson_ratio, material.thickness_m
    shear = material.youngs_modulus_pa / (2 * (1 + nu))
    kh = np.asarray(k, np.float64) * h
    safe = np.where(kh > 0, kh, 1.0)
    small = np.minimum(kh, _LARGE)
    kappa = 3 - 4 * nu
    stretch = np.where(kh > 0, np.sinh(2 * small) / (2 * np.where(small > 0, small, 1.0)), 1.0)
    layer = 2 * h / material.modulus_pa * (kappa * stretch + 1) / _denominator(small, nu)
    along = np.where(kh >= _LARGE, 2 * h / (material.modulus_pa * safe), layer)
    across = h / shear * np.where(kh > 0, np.tanh(kh) / safe, 1.0)
    return along, across


def coupling_symbol(material: LayerMaterial, k: NDArray[np.float64]) -> Floats:
    """In-plane shift along the wave vector per pressure (m/Pa), of `k`'s shape; Goodman's approximation leaves it out.

    Under p cos kx the surface shifts by coupling p sin kx; by reciprocity q sin kx lowers it by coupling q cos kx.
    (1 / (2 G k)) [H^2 - (1 - 2 nu) kappa S^2] / D, D the denominator above; -(1 - 2 nu) / (2 G k) for short waves.
    """
    nu, h = material.poisson_ratio, material.thickness_m
    kh = np.asarray(k, np.float64) * h
    small = np.minimum(kh, _LARGE)
    pull = (1 - 2 * nu) * (3 - 4 * nu)
    safe = np.where(small > 0, small, 1.0)
    layer = small * (1 - pull * (np.sinh(small) / safe) ** 2) / _denominator(small, nu)
    with np.errstate(divide="ignore"):
        deep = -(1 - 2 * nu) / np.where(kh > 0, kh, 1.0)
    shear = material.youngs_modulus_pa / (2 * (1 + nu))
    return h / (2 * shear) * np.where(kh >= _LARGE, deep, np.where(kh > 0, layer, 0.0))


def _denominator(kh: NDArray[np.float64], nu: float) -> NDArray[np.float64]:
    return kh**2 + 4 * (1 - nu) ** 2 + (3 - 4 * nu) * np.sinh(kh) ** 2


class SpectralTangential:
    """Convolution on a domain padded to twice the grid; `symbols` are its (xx, xy, yy) parts, (3, 2n, n + 1)."""

    def __init__(self, grid: Grid, symbols: NDArray[np.float64], dtype: type[np.floating] = np.float64) -> None:
        self.grid = grid
        self.dtype = np.dtype(dtype)
        size = (2 * grid.n, 2 * grid.n)
        self._symbols = symbols.astype(self.dtype)
        self._kernels: Floats = scipy.fft.irfft2(symbols, size).astype(self.dtype)

    def displacement(self, traction: Floats) -> Floats:
        """See `TangentialCompliance`."""
        n = self.grid.n
        return _convolve(np.asarray(traction, self.dtype), self._symbols, (2 * n, 2 * n))

    def window(self, rows: slice, columns: slice) -> TangentialWindow:
        """See `TangentialCompliance`."""
        return TangentialWindow((rows.stop - rows.start, columns.stop - columns.start), self._kernels)


class TangentialWindow:
    """Influence coefficients (3, N, N) cut to the offsets that occur inside a window."""

    def __init__(self, shape: tuple[int, int], kernels: Floats) -> None:
        full = kernels.shape[1]
        self._size = (_fast(shape[0], full), _fast(shape[1], full))
        index = [np.fft.fftfreq(size, 1 / size).astype(int) for size in self._size]
        cut = kernels[:, index[0][:, None], index[1]]
        self._symbols = scipy.fft.rfft2(cut)
        self._sizes = scipy.fft.rfft2(np.abs(cut))

    def displacement(self, traction: Floats) -> Floats:
        """In-plane displacement (m) inside the window under `traction` (Pa) inside the window."""
        return _convolve(traction, self._symbols, self._size)

    def largest(self, loaded: NDArray[np.bool_]) -> float:
        """An upper bound of the largest eigenvalue (m/Pa) for tractions on the `loaded` cells.

        Collatz and Wielandt: max |C| w / w bounds it for any positive w; repeated application makes w tight.
        """
        w = np.broadcast_to(loaded, (2, *loaded.shape)).astype(self._sizes.real.dtype)
        bound = np.inf
        for _ in range(_BOUND_STEPS):
            image = _convolve(w, self._sizes, self._size) * loaded
            bound = min(bound, float((image[:, loaded] / w[:, loaded]).max()))
            w = np.maximum(image / image.max(), 1e-3) * loaded
        return bound


def _fast(extent: int, full: int) -> int:
    return int(min(scipy.fft.next_fast_len(2 * extent, real=True), full))


def _convolve(traction: Floats, symbols: NDArray[np.inexact], size: tuple[int, int]) -> Floats:
    x, y = scipy.fft.rfft2(traction, size)
    xx, xy, yy = symbols
    out: Floats = scipy.fft.irfft2(np.stack([xx * x + xy * y, xy * x + yy * y]), size)
    return out[:, : traction.shape[1], : traction.shape[2]]


class LayerTangential(SpectralTangential):
    """A bonded layer on `grid` under shear; the partner of `LayerCompliance`.

    `cover_m_per_pa` is how far a cover on the layer, a cloth say, gives under each shear traction: local, in series.
    """

    def __init__(
        self,
        grid: Grid,
        material: LayerMaterial,
        dtype: type[np.floating] = np.float64,
        cover_m_per_pa: float = 0.0,
    ) -> None:
        if not (np.isfinite(cover_m_per_pa) and cover_m_per_pa >= 0):
            raise ValueError(f"cover_m_per_pa must be finite and >= 0, got {cover_m_per_pa}")
        self.material = material
        self.cover_m_per_pa = cover_m_per_pa
        k = padded_wave_numbers(grid)
        along, across = in_plane_symbols(material, k)
        size = 2 * grid.n
        kx = 2 * np.pi * np.fft.rfftfreq(size, grid.pitch_m)[None, :]
        ky = 2 * np.pi * np.fft.fftfreq(size, grid.pitch_m)[:, None]
        safe = np.where(k > 0, k, 1.0)
        cosine, sine = kx / safe, ky / safe
        mixed = (along - across) * cosine * sine
        # the sign of the highest wave number is not defined
        mixed[grid.n] = mixed[:, grid.n] = 0
        local = across + cover_m_per_pa
        symbols = np.stack([local + (along - across) * cosine**2, mixed, local + (along - across) * sine**2])
        super().__init__(grid, symbols, dtype)
        coupling = -1j * coupling_symbol(material, k) * np.stack([cosine, sine])
        coupling[:, grid.n] = coupling[:, :, grid.n] = 0
        self._coupling = coupling.astype(np.result_type(self.dtype, np.complex64))

    def face(self, traction: Floats) -> Floats:
        """In-plane displacement (x, y) of the layer's own face, below its cover (m), (2, n, n)."""
        return self.displacement(traction) - self.dtype.type(self.cover_m_per_pa) * np.asarray(traction, self.dtype)

    def under_pressure(self, pressure: Floats) -> Floats:
        """In-plane motion (x, y) of the surface (m) under a frictionless `pressure` (n, n) in Pa, (2, n, n)."""
        n = self.grid.n
        spectrum = scipy.fft.rfft2(np.asarray(pressure, self.dtype), (2 * n, 2 * n))
        out: Floats = scipy.fft.irfft2(self._coupling * spectrum, (2 * n, 2 * n))
        return out[:, :n, :n]

    def sinking(self, traction: Floats) -> Floats:
        """How far (m, into the pad) `traction` (2, n, n) lowers the surface, (n, n): what is taken as zero."""
        n = self.grid.n
        spectrum = scipy.fft.rfft2(np.asarray(traction, self.dtype), (2 * n, 2 * n))
        out: Floats = scipy.fft.irfft2((np.conj(self._coupling) * spectrum).sum(axis=0), (2 * n, 2 * n))
        return out[:n, :n]


class HalfSpaceTangential(SpectralTangential):
    """A half-space (E in Pa, nu) under traction that is uniform on each cell of `grid`; an oracle for tests."""

    def __init__(
        self, grid: Grid, youngs_modulus_pa: float, poisson_ratio: float, dtype: type[np.floating] = np.float64
    ) -> None:
        coefficients = cerruti_coefficients(grid, youngs_modulus_pa, poisson_ratio)
        super().__init__(grid, scipy.fft.rfft2(coefficients).real, dtype)


def cerruti_coefficients(grid: Grid, youngs_modulus_pa: float, poisson_ratio: float) -> NDArray[np.float64]:
    """Shift at each cell offset under unit traction on one cell, m/Pa: parts (xx, xy, yy), (3, 2n, 2n), FFT order."""
    size = 2 * grid.n
    offset = np.fft.fftfreq(size, 1 / size) * grid.pitch_m
    x, y = np.meshgrid(offset, offset)
    half, nu = grid.pitch_m / 2, poisson_ratio
    total = np.zeros((3, size, size))
    for sx in (-1, 1):
        for sy in (-1, 1):
            a, b = x + sx * half, y + sy * half
            # corner potentials of y^2 / r^3, x^2 / r^3 and x y / r^3
            over_x, over_y = a * np.arcsinh(b / np.abs(a)), b * np.arcsinh(a / np.abs(b))
            parts = np.stack([(1 - nu) * over_x + over_y, -nu * np.hypot(a, b), over_x + (1 - nu) * over_y])
            total += sx * sy * parts
    shear = youngs_modulus_pa / (2 * (1 + nu))
    return total / (2 * np.pi * shear)
