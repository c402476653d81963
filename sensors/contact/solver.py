"""Frictionless unilateral contact by a projected, preconditioned conjugate gradient.

Find p >= 0 with u(p) + gap - d >= 0 and p (u(p) + gap - d) = 0, for a given indentation d or a given load.
The active set grows and shrinks as in I. A. Polonsky, L. M. Keer, Wear 231 (1999) 206-219; the direction on the active
set is preconditioned by the inverse symbol, and under load control it is projected so that it carries no net load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.operator import Compliance, Window, WindowedCompliance

NO_SURFACE = np.inf
"""Gap of a cell over which there is no object."""

_ENTRY_PRESSURE = 1e-3
"""Pressure, as a fraction of the peak, with which a penetrating cell enters the active set; larger steps cycle."""


_PLAIN = (1e-9, 1e15)
"""Peaks of a first guess (Pa) whose squares float32 holds; what lies outside is scaled, for its shape alone counts."""

_DEEPEST = 0.5
"""Penetration of a loaded cell, as a fraction of the indentation, that no answer holds, whatever it carries."""


class ConvergenceError(RuntimeError):
    """The contact solver met neither its tolerance nor a reason to stop."""


@dataclass(frozen=True)
class ContactSolution:
    """Pressure (n, n) in Pa, load (N), indentation of the rigid surface (m), iterations and final residual."""

    grid: Grid
    pressure: NDArray[np.floating]
    force_n: float
    indentation_m: float
    iterations: int
    residual: float

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Cells that carry pressure, (n, n)."""
        return np.asarray(self.pressure > 0)


def solve_load(
    compliance: Compliance,
    gap: NDArray[np.floating],
    force_n: float,
    *,
    initial: NDArray[np.floating] | None = None,
    tolerance: float = 1e-4,
    max_iterations: int = 400,
) -> ContactSolution:
    """Press a rigid surface with a given force.

    `gap` (n, n) is the distance in metres of the undeformed pad from the surface at first touch (`NO_SURFACE` where
    there is none); `initial` an (n, n) pressure to start from. The residual is sum |g p| / (sum p * d): complementarity
    violation relative to the work of the load. Raises ValueError for bad input or a load without a surface to carry
    it, ConvergenceError when `max_iterations` do not suffice.
    """
    gap = check_load(compliance, gap, force_n)
    check_initial(compliance, initial)
    if force_n == 0:
        return _no_contact(compliance, gap, 0.0)
    problem = _Problem(compliance, gap, finite_window(gap), force_n / compliance.grid.cell_area_m2, None)
    return problem.solve(initial, tolerance, max_iterations)


def solve_indentation(
    compliance: Compliance,
    gap: NDArray[np.floating],
    indentation_m: float,
    *,
    initial: NDArray[np.floating] | None = None,
    tolerance: float = 1e-4,
    max_iterations: int = 400,
) -> ContactSolution:
    """Press a rigid surface by a given depth; zero or negative depth gives zero pressure. See `solve_load`."""
    gap = _checked(compliance, gap)
    check_initial(compliance, initial)
    if not np.isfinite(indentation_m):
        raise ValueError(f"indentation_m must be finite, got {indentation_m}")
    reached = gap < indentation_m
    if not reached.any():
        return _no_contact(compliance, gap, indentation_m)
    problem = _Problem(compliance, gap, _bounding_window(reached), None, indentation_m)
    return problem.solve(initial, tolerance, max_iterations)


def check_load(compliance: Compliance, gap: NDArray[np.floating], force_n: float) -> NDArray[np.floating]:
    """`gap` in the compliance's precision; ValueError as `solve_load` says."""
    gap = _checked(compliance, gap)
    if not force_n >= 0 or not np.isfinite(force_n):
        raise ValueError(f"force_n must be finite and >= 0, got {force_n}")
    if force_n > 0 and not np.isfinite(gap).any():
        raise ValueError("a load needs a surface to carry it, but the gap is infinite everywhere")
    sum_p, held = force_n / compliance.grid.cell_area_m2, np.finfo(compliance.dtype)
    if force_n > 0 and not float(held.tiny) * gap.size < sum_p < float(held.max) / gap.size:
        raise ValueError(f"force_n {force_n:g} is beyond what {compliance.dtype} holds as a pressure")
    return gap


def check_initial(compliance: Compliance, initial: NDArray[np.floating] | None) -> None:
    """ValueError unless `initial` is None or finite pressures (n, n)."""
    n = compliance.grid.n
    if initial is None:
        return
    if initial.shape != (n, n):
        raise ValueError(f"initial must have the grid's shape ({n}, {n}), got {initial.shape}")
    if not (np.abs(initial) <= float(np.finfo(compliance.dtype).max)).all():
        raise ValueError("initial holds pressures that are not finite; leave it out to start from none")


def _checked(compliance: Compliance, gap: NDArray[np.floating]) -> NDArray[np.floating]:
    n = compliance.grid.n
    if gap.shape != (n, n):
        raise ValueError(f"gap must have the grid's shape ({n}, {n}), got {gap.shape}")
    if not (gap > -np.inf).all():
        raise ValueError("gap holds NaN or -inf; use NO_SURFACE (inf) where there is no object")
    return np.asarray(gap, compliance.dtype)


def _no_contact(compliance: Compliance, gap: NDArray[np.floating], indentation_m: float) -> ContactSolution:
    return ContactSolution(compliance.grid, np.zeros_like(gap), 0.0, indentation_m, 0, 0.0)


def _bounding_window(mask: NDArray[np.bool_]) -> Window:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def finite_window(gap: NDArray[np.floating]) -> Window:
    """Smallest rectangle that holds every cell with an object over it."""
    return _bounding_window(np.isfinite(gap))


class _Problem:
    """One contact problem inside the window that can carry pressure; `load` is sum p, or None under depth control."""

    def __init__(
        self,
        compliance: Compliance,
        gap: NDArray[np.floating],
        window: Window,
        load: float | None,
        depth: float | None,
    ) -> None:
        self.compliance = compliance
        self.shape = gap.shape
        self.window = window
        self.local: WindowedCompliance = compliance.window(*window)
        self.gap = gap[window]
        self.surface = np.isfinite(self.gap)
        self.gap = np.where(self.surface, self.gap, self.gap.dtype.type(1.0))
        self.load = load
        self.depth = depth
        self._one: tuple[NDArray[np.bool_], NDArray[np.floating]] | None = None

    def solve(self, initial: NDArray[np.floating] | None, tolerance: float, max_iterations: int) -> ContactSolution:
        """Preconditioned first; if the active set cycles, again without the preconditioner."""
        first = min(80, max_iterations)
        result = self._iterate(self._start(initial), tolerance, first, preconditioned=True)
        if result.residual <= tolerance:
            return result
        retry = self._iterate(self._cut(result.pressure), tolerance, max_iterations, preconditioned=False)
        if retry.residual <= tolerance:
            return retry
        raise ConvergenceError(
            f"contact did not converge: residual {retry.residual:.2e} > {tolerance:.0e} after "
            f"{first} + {max_iterations} iterations on {self.shape[0]}x{self.shape[1]} cells; "
            "loosen the tolerance, use float64 or a smoother surface"
        )

    def _cut(self, pressure: NDArray[np.floating]) -> NDArray[np.floating]:
        return np.asarray(pressure[self.window], self.compliance.dtype)

    def _start(self, initial: NDArray[np.floating] | None) -> NDArray[np.floating]:
        p: NDArray[np.floating] | None = None
        if initial is not None:
            p = np.maximum(self._cut(initial), 0) * self.surface
            peak = p.max()
            if peak > 0 and not _PLAIN[0] < peak < _PLAIN[1]:
                p = p / peak
        if p is None or not p.any():
            p = self._cold_start()
        if self.load is not None:
            return p * (self.load / p.sum())
        assert self.depth is not None
        wanted = (self.depth - self.gap) * self.surface
        work = float((p * wanted).sum())
        scale = work / float((p * self.local.displacement(p)).sum())
        return p * max(scale, 0.0)

    def _cold_start(self) -> NDArray[np.floating]:
        """Unit pressure on the cells that touch first."""
        gaps = self.gap[self.surface]
        nearest = np.partition(gaps, min(20, gaps.size - 1))[min(20, gaps.size - 1)]
        touching: NDArray[np.floating] = (self.surface & (self.gap <= nearest)).astype(self.gap.dtype)
        return touching

    def _iterate(
        self, p: NDArray[np.floating], tolerance: float, max_iterations: int, *, preconditioned: bool
    ) -> ContactSolution:
        local = self.local
        u = local.displacement(p)
        direction: NDArray[np.floating] | None = None
        previous_g, previous_gz = p, 0.0
        best = (np.inf, p, 0.0)
        for iteration in range(max_iterations + 1):
            active = p > 0
            d, g, z = self._residual(p, u, active, preconditioned)
            residual, gaining = self._progress(p, g, d, active, tolerance)
            if not gaining.any() and residual < best[0]:
                best = (residual, p, d)
                if residual <= tolerance:
                    break
            if iteration == max_iterations:
                break
            g_active = g * active
            gz = float((g_active * z).sum())
            if direction is None or previous_gz == 0:
                direction = z
            else:
                beta = (gz - float((previous_g * z).sum())) / previous_gz
                direction = (z + max(beta, 0.0) * direction) * active
            previous_g, previous_gz = g_active, gz
            response = local.displacement(direction)
            curvature = float((direction * response).sum())
            step = float((g_active * direction).sum()) / curvature if curvature > 0 else 0.0
            p = p - p.dtype.type(step) * direction
            leaving = p < 0
            if leaving.any() or gaining.any():
                p = np.maximum(p, 0)
                p = np.where(gaining, p.dtype.type(_ENTRY_PRESSURE * float(p.max())), p)
                direction = None
                if self.load is not None:
                    p *= p.dtype.type(self.load / p.sum())
                u = local.displacement(p)
            else:
                u = u - u.dtype.type(step) * response
        residual, p, d = best if np.isfinite(best[0]) else (np.inf, p, d)
        return self._solution(p, d, iteration, residual)

    def _residual(
        self,
        p: NDArray[np.floating],
        u: NDArray[np.floating],
        active: NDArray[np.bool_],
        preconditioned: bool,
    ) -> tuple[float, NDArray[np.floating], NDArray[np.floating]]:
        """Indentation d, gap violation g = u + gap - d, and the preconditioned g on the active set."""
        opening = u + self.gap
        masked = opening * active
        if self.depth is not None:
            g = opening - opening.dtype.type(self.depth)
            z = self.local.precondition(g * active) * active if preconditioned else g * active
            return self.depth, g, z
        if preconditioned:
            z_opening = self.local.precondition(masked) * active
            z_one = self._preconditioned_one(active)
        else:
            z_opening, z_one = masked, active.astype(opening.dtype)
        d = opening.dtype.type(z_opening.sum() / z_one.sum())
        return float(d), opening - d, z_opening - d * z_one

    def _preconditioned_one(self, active: NDArray[np.bool_]) -> NDArray[np.floating]:
        """The preconditioned indicator of the active set, which near the end stays the same."""
        if self._one is None or not np.array_equal(self._one[0], active):
            self._one = (active, self.local.precondition(active.astype(self.gap.dtype)) * active)
        return self._one[1]

    def _progress(
        self,
        p: NDArray[np.floating],
        g: NDArray[np.floating],
        d: float,
        active: NDArray[np.bool_],
        tolerance: float,
    ) -> tuple[float, NDArray[np.bool_]]:
        """Relative complementarity, and the cells outside the active set that penetrate."""
        scale = max(abs(d), float(np.finfo(g.dtype).tiny))
        gaining = self.surface & ~active & (g < -tolerance * scale)
        total = float(p.sum())
        if total <= 0:
            return (0.0 if not gaining.any() else np.inf), gaining
        # a cell that stands out weighs next to nothing while the load still lies on a wide face below it
        if (g[active] < -_DEEPEST * scale).any():
            return np.inf, gaining
        return float(np.abs(g * p).sum()) / (total * scale), gaining

    def _solution(self, p: NDArray[np.floating], d: float, iterations: int, residual: float) -> ContactSolution:
        pressure = np.zeros(self.shape, self.compliance.dtype)
        pressure[self.window] = p
        force = float(pressure.sum(dtype=np.float64)) * self.compliance.grid.cell_area_m2
        return ContactSolution(self.compliance.grid, pressure, force, float(d), iterations, residual)
