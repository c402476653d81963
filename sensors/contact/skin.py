"""The skin of FVSight: a film of taxels on canvas, spanning a hollow housing on a square frame.

Two compliances in series. The skin as a whole is a plate under tension on a simply supported square frame,
D lap^2 w - N lap w = p, which the sine series diagonalises: 1 / (D k^4 + N k^2). On its face the film squeezes
locally like a thin bonded layer. The camera sees w; the taxels feel the film's base pressure.

Source: S. Timoshenko, S. Woinowsky-Krieger, "Theory of Plates and Shells" (1959), sections 28 and 92.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.influence import mirrored, sine_table
from sensors.contact.layer import LayerMaterial


@dataclass(frozen=True)
class SkinMaterial:
    """The film (thickness, modulus, Poisson's ratio) and the tension N (N/m) it is stretched with."""

    film: LayerMaterial
    tension_n_per_m: float

    def __post_init__(self) -> None:
        if not 0 < self.tension_n_per_m < np.inf:
            raise ValueError(f"a skin needs a finite positive tension_n_per_m, got {self.tension_n_per_m}")

    @property
    def bending_stiffness_nm(self) -> float:
        """D = E h^3 / (12 (1 - nu^2)) in newton metres."""
        film = self.film
        return film.youngs_modulus_pa * film.thickness_m**3 / (12 * (1 - film.poisson_ratio**2))

    def plate_compliance(self, k_squared: NDArray[np.float64]) -> NDArray[np.float64]:
        """w per pressure (m/Pa) at |k|^2 > 0 (rad^2/m^2)."""
        return 1 / (self.bending_stiffness_nm * k_squared**2 + self.tension_n_per_m * k_squared)

    def stretching_excess(self, deflection_m: float, radius_m: float) -> float:
        """Estimate of how much too far the linear skin sinks, relative, at a linear central deflection.

        (E h / N) (w / a)^2, a scale analysis of the tension that stretching adds; `disc_deflection` is the reference:
        for central patches of 3 to 12 mm on a 40 mm disc and up to 15 % it overestimates by a factor of 1.05 to 1.5.
        """
        stiffness = self.film.youngs_modulus_pa * self.film.thickness_m
        return stiffness / self.tension_n_per_m * (deflection_m / radius_m) ** 2


def sine_basis(position: NDArray[np.float64], n_modes: int) -> NDArray[np.float64]:
    """Sines that vanish on the frame, at `position` (fractions of the frame's side): (points, n_modes).

    At the cell centres of a grid of n_modes cells the columns are orthonormal (a DST-II); at any other points the same
    modes interpolate exactly.
    """
    return _normalised(np.sin(np.pi * position[:, None] * np.arange(1, n_modes + 1)))


def cosine_basis(position: NDArray[np.float64], n_modes: int, size_m: float) -> NDArray[np.float64]:
    """Derivatives of `sine_basis` along its axis, in 1/m: (points, n_modes)."""
    modes = np.arange(1, n_modes + 1)
    return _normalised(np.cos(np.pi * position[:, None] * modes) * (np.pi * modes / size_m))


def _normalised(basis: NDArray[np.float64]) -> NDArray[np.float64]:
    basis *= math.sqrt(2 / basis.shape[1])
    basis[:, -1] /= math.sqrt(2)
    return basis


class SkinCompliance:
    """The `skin` rung: plate under tension + film squeeze, diagonal in the sine series of the frame.

    Dense sine matrices beat FFTs here: a contact touches a small rectangle, and its rows of the basis are enough.
    """

    def __init__(self, grid: Grid, material: SkinMaterial, dtype: type[np.floating] = np.float64) -> None:
        self.grid = grid
        self.material = material
        self.dtype = np.dtype(dtype)
        k = np.pi * np.arange(1, grid.n + 1) / grid.size_m
        k_squared = k[:, None] ** 2 + k[None, :] ** 2
        plate = material.plate_compliance(k_squared)
        total = plate + material.film.surface_compliance(np.sqrt(k_squared))
        self._basis = sine_basis((np.arange(grid.n) + 0.5) / grid.n, grid.n).astype(self.dtype)
        self._plate = plate.astype(self.dtype)
        self._symbol = total
        self._total = total.astype(self.dtype)
        self._inverse = (total.min() / total).astype(self.dtype)
        self._base = material.film.base_transfer(np.sqrt(k_squared)).astype(self.dtype)

    def modes(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Sine coefficients of an (n, n) field, (n, n); only the loaded rows and columns are read."""
        rows, columns = loaded_window(pressure)
        return self._basis[rows].T @ np.asarray(pressure[rows, columns], self.dtype) @ self._basis[columns]

    def deflection_modes(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Sine coefficients of the inner face's deflection w (m), (n, n)."""
        return self.modes(pressure) * self._plate

    def displacement(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Displacement of the touched face (skin + film, m), (n, n)."""
        return self._basis @ (self.modes(pressure) * self._total) @ self._basis.T

    def deflection(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Deflection w (m) of the inner face that the camera sees, (n, n)."""
        return self._basis @ self.deflection_modes(pressure) @ self._basis.T

    def base_pressure(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Normal stress (Pa) that the film's base feels, where the taxels lie, (n, n)."""
        return self._basis @ (self.modes(pressure) * self._base) @ self._basis.T

    def influence(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.float64]:
        """Displacement (m) of each of the cells under unit pressure (Pa) on each: (cells, cells), symmetric."""
        return mirrored(self._influence_table, rows, columns)

    @cached_property
    def _influence_table(self) -> NDArray[np.float64]:
        return sine_table(self._symbol)

    def coarser(self) -> SkinCompliance:
        """The same skin on a grid of half as many cells along a side."""
        return SkinCompliance(self.grid.coarser(), self.material, self.dtype.type)

    def window(self, rows: slice, columns: slice) -> SkinWindow:
        """The compliance restricted to a rectangle of the grid."""
        return SkinWindow(self._basis[rows], self._basis[columns], self._total, self._inverse)


@dataclass(frozen=True)
class SkinWindow:
    """Rows of the sine basis that a contact needs."""

    rows: NDArray[np.floating]
    columns: NDArray[np.floating]
    symbol: NDArray[np.floating]
    inverse: NDArray[np.floating]

    def _apply(self, field: NDArray[np.floating], symbol: NDArray[np.floating]) -> NDArray[np.floating]:
        return self.rows @ ((self.rows.T @ field @ self.columns) * symbol) @ self.columns.T

    def displacement(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        """Displacement of the touched face (m) inside the window."""
        rows, columns = loaded_window(pressure)
        modes = self.rows[rows].T @ pressure[rows, columns] @ self.columns[columns]
        return self.rows @ (modes * self.symbol) @ self.columns.T

    def precondition(self, residual: NDArray[np.floating]) -> NDArray[np.floating]:
        """The inverse symbol between the window's rows and columns."""
        return self._apply(residual, self.inverse)


def loaded_window(pressure: NDArray[np.floating]) -> tuple[slice, slice]:
    """Smallest rectangle (rows, columns) that holds all non-zero cells; one cell where there are none."""
    loaded = pressure != 0
    spans = []
    for axis in (1, 0):
        hit = np.flatnonzero(loaded.any(axis=axis))
        spans.append(slice(int(hit[0]), int(hit[-1]) + 1) if hit.size else slice(0, 1))
    return spans[0], spans[1]
