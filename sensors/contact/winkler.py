"""The `winkler` rung: a bed of independent springs, p = k d, with k fitted to the bonded layer.

One k serves one thickness and one class of indenter; its force is good near the depths of the fit and its surface
follows the indenter only where it touches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.solver import ContactSolution, solve_indentation

Floats = NDArray[np.floating]


@dataclass(frozen=True)
class WinklerBed:
    """Springs of `stiffness_pa_per_m` (Pa of pressure per metre) under the cells of `grid`."""

    grid: Grid
    stiffness_pa_per_m: float

    def __post_init__(self) -> None:
        if not 0 < self.stiffness_pa_per_m < np.inf:
            raise ValueError(f"a Winkler bed needs a positive, finite stiffness, got {self.stiffness_pa_per_m} Pa/m")

    def solve_indentation(self, gap: Floats, indentation_m: float) -> ContactSolution:
        """Press a surface with the given `gap` (n, n; inf where there is none) to a depth; no tension."""
        _check_gap(self.grid, gap)
        if not np.isfinite(indentation_m):
            raise ValueError(f"indentation_m must be finite, got {indentation_m}")
        pressure = self.stiffness_pa_per_m * np.maximum(indentation_m - gap, 0)
        force = float(pressure.sum()) * self.grid.cell_area_m2
        return ContactSolution(self.grid, pressure, force, indentation_m, 0, 0.0)

    def solve_load(self, gap: Floats, force_n: float) -> ContactSolution:
        """Press with a given force, exactly: force over depth is piecewise linear between the sorted gaps."""
        _check_gap(self.grid, gap)
        if not (np.isfinite(force_n) and force_n >= 0):
            raise ValueError(f"force_n must be finite and >= 0, got {force_n}")
        if force_n == 0:
            return self.solve_indentation(gap, 0.0)
        ordered = np.sort(gap[np.isfinite(gap)])
        if ordered.size == 0:
            raise ValueError("a load needs a surface to carry it, but the gap is infinite everywhere")
        wanted = force_n / (self.stiffness_pa_per_m * self.grid.cell_area_m2)
        count = np.arange(1, ordered.size + 1)
        # total squeeze just as each further cell comes into contact
        reached = count * ordered - np.cumsum(ordered)
        last = int(np.searchsorted(reached, wanted, side="right"))
        depth = (wanted + ordered[:last].sum()) / last
        return self.solve_indentation(gap, float(depth))

    def displacement(self, solution: ContactSolution) -> Floats:
        """Depth (m) of the surface below its rest, (n, n): zero outside the contact."""
        return solution.pressure / self.stiffness_pa_per_m


def fit_winkler(
    material: LayerMaterial, grid: Grid, gap: Floats, depths_m: Sequence[float], *, tolerance: float = 1e-4
) -> WinklerBed:
    """The bed on `grid` whose forces are nearest to the bonded layer's over `depths_m` (least relative squares).

    `gap` (n, n) is of one indenter of the class to be served. Raises ValueError unless some depth is positive and
    touches.
    """
    _check_gap(grid, gap)
    layer = LayerCompliance(grid, material)
    unit = WinklerBed(grid, 1.0)
    ratios, pressure = [], None
    for depth in sorted(depths_m):
        solution = solve_indentation(layer, gap, depth, initial=pressure, tolerance=tolerance)
        if solution.force_n > 0:
            pressure = solution.pressure
            ratios.append(unit.solve_indentation(gap, depth).force_n / solution.force_n)
    if not ratios:
        raise ValueError(f"a fit needs a depth at which the indenter touches, got depths_m={list(depths_m)}")
    # min over k of sum (k r - 1)^2
    return WinklerBed(grid, float(np.sum(ratios) / np.sum(np.square(ratios))))


def _check_gap(grid: Grid, gap: Floats) -> None:
    if gap.shape != (grid.n, grid.n):
        raise ValueError(f"gap must have the grid's shape ({grid.n}, {grid.n}), got {gap.shape}")
    if not (gap > -np.inf).all():
        raise ValueError("gap holds NaN or -inf; use inf where there is no object")
