"""Partial slip under a given pressure: stick where |q| < mu p, slip along the traction where |q| = mu p.

With the slip s0 that earlier steps left, find q that minimises 1/2 q.C q - (shift - s0).q over the discs |q| <= mu p of
the cells: sticking cells follow the indenter, slipping ones lag behind along their traction. A step is implicit, so a
path of steps (each given the one `before`) carries the history: unloading, reversal, a pressure that grows or falls.
The pressure is not moved by the shear (Goodman), and shifts count from the frictionless press.

The minimum is found by accelerated projected gradients with restart (Y. Nesterov, 1983; B. O'Donoghue, E. Candes,
Found. Comput. Math. 15 (2015)); under load control the projection keeps the sum of the tractions as well.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sensors.contact.grid import Grid
from sensors.contact.skin import loaded_window
from sensors.contact.solver import ConvergenceError
from sensors.contact.tangential import Floats, TangentialCompliance
from sensors.contact.tangential_projection import onto_discs, onto_discs_with_sum

_STUCK = 1e-4
"""A cell slips when its traction is within this fraction of mu p."""


@dataclass(frozen=True)
class TangentialSolution:
    """A sheared contact.

    `traction` (2, n, n) in Pa along x and y, `limit` mu p (n, n) in Pa, `slip` (2, n, n) in metres by which the
    indenter has gone ahead of the surface, `shift_m` (2,) of the indenter, `force_n` (2,) on the pad, iterations and
    residual.
    """

    grid: Grid
    traction: Floats
    limit: Floats
    slip: Floats
    shift_m: NDArray[np.float64]
    force_n: NDArray[np.float64]
    iterations: int
    residual: float

    @property
    def slipping(self) -> NDArray[np.bool_]:
        """Cells of the contact at the friction limit, (n, n)."""
        size = np.hypot(*self.traction)
        return np.asarray((self.limit > 0) & (size >= (1 - _STUCK) * self.limit))

    @property
    def sticking(self) -> NDArray[np.bool_]:
        """Cells of the contact below it, (n, n)."""
        return np.asarray((self.limit > 0) & ~self.slipping)


def solve_shift(
    compliance: TangentialCompliance,
    pressure: Floats,
    friction: float,
    shift_m: ArrayLike,
    *,
    before: TangentialSolution | None = None,
    tolerance: float = 1e-5,
    max_iterations: int = 3000,
) -> TangentialSolution:
    """Move the indenter sideways to `shift_m` (x, y), under a `pressure` (n, n) in Pa with coefficient `friction`.

    `before` is the step that this one follows; without it the pad starts unsheared. The residual is the change of the
    tractions by one projected gradient step over their sum. Raises ValueError for bad input, ConvergenceError when
    `max_iterations` do not suffice.
    """
    problem = _Problem(compliance, pressure, friction, before)
    shift = _pair("shift_m", shift_m)
    wanted = problem.wanted(shift)

    def project(traction: Floats) -> Floats:
        return onto_discs(traction, problem.limit)

    found, iterations, residual = problem.minimise(wanted, project, tolerance, max_iterations)
    return problem.solution(found, shift, iterations, residual)


def solve_tangential_load(
    compliance: TangentialCompliance,
    pressure: Floats,
    friction: float,
    force_n: ArrayLike,
    *,
    before: TangentialSolution | None = None,
    tolerance: float = 1e-5,
    max_iterations: int = 3000,
) -> TangentialSolution:
    """Pull the indenter sideways with `force_n` (x, y); see `solve_shift`.

    Raises ValueError for a force that is not below friction times the load of `pressure`: the contact would slide off
    with no shift that carries it.
    """
    problem = _Problem(compliance, pressure, friction, before)
    force = _pair("force_n", force_n)
    area = compliance.grid.cell_area_m2
    most = float(problem.limit.sum(dtype=np.float64)) * area
    size = float(np.hypot(*force))
    if size > 0 and size >= most:
        raise ValueError(
            f"the contact slides: friction carries less than {most:.6g} N, asked for {size:.6g} N; "
            "press harder, or prescribe the shift with solve_shift"
        )
    multiplier = np.zeros(2)

    def project(traction: Floats) -> Floats:
        nonlocal multiplier
        out, multiplier = onto_discs_with_sum(traction, problem.limit, force / area, multiplier)
        return out

    found, iterations, residual = problem.minimise(problem.wanted(np.zeros(2)), project, tolerance, max_iterations)
    # at the minimum q = P(q - (C q + s0) / L + multiplier): the multiplier is the shift over L
    return problem.solution(found, multiplier * problem.largest, iterations, residual)


class _Problem:
    """One step inside the rectangle that the pressure covers."""

    def __init__(
        self, compliance: TangentialCompliance, pressure: Floats, friction: float, before: TangentialSolution | None
    ) -> None:
        _check(compliance.grid, pressure, friction, before)
        self.compliance = compliance
        self.whole_limit = np.asarray(friction * pressure, compliance.dtype)
        self.at = loaded_window(self.whole_limit)
        self.limit = self.whole_limit[self.at]
        self.local = compliance.window(*self.at)
        shape = (2, *pressure.shape)
        self.before_slip = np.zeros(shape, compliance.dtype) if before is None else before.slip
        start = np.zeros(shape, compliance.dtype) if before is None else before.traction
        self.start = np.asarray(start[:, *self.at], compliance.dtype)
        self.largest = self.local.largest(self.limit > 0) if self.limit.any() else 1.0

    def wanted(self, shift: NDArray[np.float64]) -> Floats:
        """Displacement that a surface without further slip would have, inside the window."""
        out: Floats = (shift[:, None, None] - self.before_slip[:, *self.at]).astype(self.compliance.dtype)
        return out

    def minimise(
        self, wanted: Floats, project: Callable[[Floats], Floats], tolerance: float, max_iterations: int
    ) -> tuple[Floats, int, float]:
        """Tractions inside the window, iterations and residual."""
        step = self.limit.dtype.type(1 / self.largest)
        current = ahead = project(self.start)
        momentum = 1.0
        residual = np.inf
        for iteration in range(1, max_iterations + 1):
            new = project(ahead - step * (self.local.displacement(ahead) - wanted))
            total = float(np.abs(new).sum())
            residual = float(np.abs(new - ahead).sum()) / total if total > 0 else 0.0
            if residual <= tolerance:
                return new, iteration, residual
            if float(((ahead - new) * (new - current)).sum()) > 0:
                momentum = 1.0
            following = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
            ahead = new + new.dtype.type((momentum - 1) / following) * (new - current)
            current, momentum = new, following
        raise ConvergenceError(
            f"partial slip did not converge: residual {residual:.2e} > {tolerance:.0e} after {max_iterations} "
            "iterations; loosen the tolerance or use float64"
        )

    def solution(
        self, found: Floats, shift: NDArray[np.float64], iterations: int, residual: float
    ) -> TangentialSolution:
        """Put the window back and bring the slip up to date."""
        traction = np.zeros_like(self.before_slip, dtype=self.compliance.dtype)
        traction[:, *self.at] = found
        lag = shift[:, None, None] - self.compliance.displacement(traction)
        sticking = (self.whole_limit > 0) & (np.hypot(*traction) < (1 - _STUCK) * self.whole_limit)
        # where nothing presses the surfaces part freely: a cell that comes into contact later starts unsheared
        slip = np.where(sticking, self.before_slip, lag).astype(self.compliance.dtype)
        force = traction.sum(axis=(1, 2), dtype=np.float64) * self.compliance.grid.cell_area_m2
        return TangentialSolution(
            self.compliance.grid, traction, self.whole_limit, slip, shift, force, iterations, residual
        )


def _pair(name: str, value: ArrayLike) -> NDArray[np.float64]:
    out = np.asarray(value, np.float64)
    if out.shape != (2,) or not np.isfinite(out).all():
        raise ValueError(f"{name} must be two finite numbers (x, y), got {value!r}")
    return out


def _check(grid: Grid, pressure: Floats, friction: float, before: TangentialSolution | None) -> None:
    if pressure.shape != (grid.n, grid.n):
        raise ValueError(f"pressure must have the grid's shape ({grid.n}, {grid.n}), got {pressure.shape}")
    if not np.isfinite(pressure).all() or (pressure < 0).any():
        raise ValueError("pressure must be finite and nowhere negative")
    if not (np.isfinite(friction) and friction >= 0):
        raise ValueError(f"friction must be finite and >= 0, got {friction}")
    if before is not None and before.grid != grid:
        raise ValueError(f"the step before lies on another grid ({before.grid}) than this one ({grid})")
