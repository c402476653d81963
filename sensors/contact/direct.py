"""A small contact solved directly: dense influence coefficients of the loaded cells, and nothing else.

The skin of a tactile sensor touches an object in some tens or hundreds of the grid's cells. For a set A of loaded cells
the load control problem is linear, G_AA p + gap_A = d with sum p = P, and costs one Cholesky factorisation; cells that
would pull leave A, cells that penetrate enter it, until neither is left. That is exact to rounding, where an iteration
stops at its tolerance. The first guess of A comes from coarser grids.

Source: the active-set method of M. Hintermueller, K. Ito, K. Kunisch, SIAM J. Optim. 13 (2002) 865-888.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol

import numpy as np
import scipy.linalg.lapack
from numpy.typing import NDArray

from sensors.contact.levels import check_levels, coarsened
from sensors.contact.operator import Compliance, WindowedCompliance
from sensors.contact.solver import (
    ContactSolution,
    ConvergenceError,
    check_initial,
    check_load,
    finite_window,
    solve_load,
)

Floats = NDArray[np.floating]
Cells = tuple[NDArray[np.intp], ...]

MOST_CELLS, _ON_CELLS = 400, 128
"""Loaded cells beyond which the iteration of `solve_load` is the cheaper one on 128 x 128 cells, more on more."""
_LAST_RESORT_CELLS = 2500
"""Loaded cells, 50 MB of coefficients, that are still solved directly where the iteration does not converge."""
_MOST_ROUNDS = 40
_PENETRATION, _COARSE_PENETRATION = 1e-5, 1e-2
"""What may remain, relative to the indentation, of an answer and of a first guess; finer than 1e-5 float32 cannot."""
_FIRST_CELLS = 20
_LOAD_KEPT = 1e-4
"""How far, relative, rounding may take the load of an answer from what was asked: tiny loads drown in the gaps."""


class DenseCompliance(Compliance, Protocol):
    """A compliance that also gives its influence coefficients between chosen cells."""

    def influence(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.float64]:
        """Displacement (m) of each cell under unit pressure (Pa) on each: (cells, cells), symmetric."""
        ...


class _UndecidedError(Exception):
    """The active set grew too large, came out empty, went round in a circle or lost the load to rounding."""


def solve_load_direct(
    levels: Sequence[DenseCompliance],
    gap: Floats,
    force_n: float,
    *,
    initial: Floats | None = None,
    tolerance: float = 1e-4,
) -> ContactSolution:
    """`solve_load` on the finest of `levels`, coarsest first, each with twice the cells of a side of the one before.

    `gap` (n, n) and `initial` (n, n; its loaded cells are the first guess, and the coarser levels are not asked) are on
    the finest grid. Loaded cells meet the surface to rounding, and 1e-5 of the indentation is the most that any other
    cell penetrates; `iterations` counts the linear solves. A contact of more than `MOST_CELLS` cells, or one whose
    active set does not settle, is left to `solve_load` with `tolerance`; up to 2500 cells come back where that does not
    converge.
    Raises ValueError where the levels do not double, and what `solve_load` raises.
    """
    check_levels(levels)
    finest = levels[-1]
    gap = check_load(finest, gap, force_n)
    check_initial(finest, initial)
    if force_n == 0:
        return solve_load(finest, gap, force_n)
    guess = None if initial is None else (np.asarray(initial) > 0) & np.isfinite(gap)
    if guess is None or not guess.any():
        guess = _guess(levels[:-1], gap, force_n)
    with suppress(_UndecidedError):
        return _settle(finest, gap, force_n, guess, _PENETRATION, _most_cells(finest))
    try:
        return solve_load(finest, gap, force_n, initial=initial, tolerance=tolerance)
    except ConvergenceError:
        with suppress(_UndecidedError):
            return _settle(finest, gap, force_n, guess, _PENETRATION, _LAST_RESORT_CELLS)
        raise


def _most_cells(compliance: DenseCompliance) -> int:
    return MOST_CELLS * max(compliance.grid.n, _ON_CELLS) // _ON_CELLS


def _guess(levels: Sequence[DenseCompliance], gap: Floats, force_n: float) -> NDArray[np.bool_]:
    """Cells (n, n) that a coarser contact covers; those that touch first where there is no coarser grid."""
    surface = np.isfinite(gap)
    if levels:
        coarse_gap = coarsened(gap)
        start = _guess(levels[:-1], coarse_gap, force_n)
        try:
            contact = _settle(
                levels[-1], coarse_gap, force_n, start, _COARSE_PENETRATION, _most_cells(levels[-1])
            ).contact
        except _UndecidedError:
            contact = start
        fine: NDArray[np.bool_] = np.repeat(np.repeat(contact, 2, axis=0), 2, axis=1) & surface
        if fine.any():
            return fine
    heights = gap[surface]
    last = min(_FIRST_CELLS, heights.size) - 1
    near = np.partition(heights, last)[last]
    nearest = gap <= near
    # a spike on a flat face: the face is no guess, what stands out from it is
    return np.asarray(nearest if nearest.sum() <= MOST_CELLS or not (gap < near).any() else gap < near)


def _settle(
    compliance: DenseCompliance,
    gap: Floats,
    force_n: float,
    active: NDArray[np.bool_],
    penetration: float,
    most_cells: int,
) -> ContactSolution:
    """The contact from a first guess (n, n) of its cells; `_UndecidedError` where the guess does not lead there."""
    window = finite_window(gap)
    local: WindowedCompliance = compliance.window(*window)
    near = gap[window].astype(np.float64)
    sum_p = force_n / compliance.grid.cell_area_m2
    origin = (window[0].start, window[1].start)
    solves = 0
    cells = np.nonzero(active[window])
    for _ in range(_MOST_ROUNDS):
        cells, p, d, extra = _without_pull(compliance, near, cells, origin, sum_p, most_cells)
        solves += extra
        field = np.zeros(near.shape, compliance.dtype)
        field[cells] = p
        opening = local.displacement(field) + near - d
        entering = opening < -penetration * abs(d)
        entering[cells] = False
        if not entering.any():
            pressure = np.zeros_like(gap)
            pressure[window] = field
            residual = float(np.abs(opening[cells] * p).sum()) / (sum_p * max(abs(d), np.finfo(np.float64).tiny))
            carried = float(field.sum(dtype=np.float64)) * compliance.grid.cell_area_m2
            if not abs(carried - force_n) <= _LOAD_KEPT * force_n:
                raise _UndecidedError
            return ContactSolution(compliance.grid, pressure, carried, d, solves, residual)
        entering[cells] = True
        cells = np.nonzero(entering)
    raise _UndecidedError


def _without_pull(
    compliance: DenseCompliance,
    near: NDArray[np.float64],
    cells: Cells,
    origin: tuple[int, int],
    sum_p: float,
    most_cells: int,
) -> tuple[Cells, NDArray[np.float64], float, int]:
    """Pressure on `cells` of the window, those that would pull taken out; what is left, p, d and the solves it took."""
    for solves in range(1, _MOST_ROUNDS + 1):
        if not 0 < cells[0].size <= most_cells:
            raise _UndecidedError
        matrix = compliance.influence(cells[0] + origin[0], cells[1] + origin[1])
        gaps = near[cells]
        _, solved, info = scipy.linalg.lapack.dposv(
            matrix.T, np.stack((np.ones_like(gaps), gaps)).T, overwrite_a=True, overwrite_b=True
        )
        if info != 0:
            raise _UndecidedError
        d = float((sum_p + solved[:, 1].sum()) / solved[:, 0].sum())
        p = d * solved[:, 0] - solved[:, 1]
        pushing = p >= 0
        if pushing.all():
            return cells, p, d, solves
        cells = (cells[0][pushing], cells[1][pushing])
    raise _UndecidedError
