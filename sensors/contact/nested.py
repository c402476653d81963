"""A large contact solved on coarser grids first: where it touches and how hard is nearly known on the finest.

The coarsest contacts have few cells and are solved directly. The finest solve sees the coarse contact and a margin
only; what lies beyond is checked against penetration, and if it penetrates the whole surface is solved.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sensors.contact.direct import DenseCompliance, solve_load_direct
from sensors.contact.levels import check_levels, coarsened
from sensors.contact.solver import NO_SURFACE, ContactSolution, solve_load

Floats = NDArray[np.floating]

_COARSE_TOLERANCE = 1e-3
_DIRECT_SIDE = 16
"""Cells of a side up to which a dense solve is the cheaper one, whatever touches."""
_MARGIN = 2
"""Coarse cells kept around the coarse contact."""


class NestedCompliance(DenseCompliance, Protocol):
    """A compliance that also gives the displacement of the whole grid."""

    def displacement(self, pressure: Floats) -> Floats:
        """Displacement (n, n) in metres under a pressure (n, n) in pascals."""
        ...


def solve_load_nested(
    levels: Sequence[NestedCompliance], gap: Floats, force_n: float, *, tolerance: float = 1e-4
) -> ContactSolution:
    """`solve_load` on the finest of `levels`, coarsest first, each with twice the cells of a side of the one before.

    `gap` (n, n) is on the finest grid. Raises ValueError where the levels do not double, and as `solve_load` does.
    """
    check_levels(levels)
    if len(levels) == 1 or levels[-1].grid.n <= _DIRECT_SIDE:
        return solve_load_direct(levels, gap, force_n, tolerance=tolerance)
    coarse = solve_load_nested(levels[:-1], coarsened(gap), force_n, tolerance=max(tolerance, _COARSE_TOLERANCE))
    if not coarse.contact.any():
        return solve_load(levels[-1], gap, force_n, tolerance=tolerance)
    start = np.kron(coarse.pressure, np.ones((2, 2), coarse.pressure.dtype))
    near = _around(coarse.contact)
    solution = solve_load(levels[-1], np.where(near, gap, NO_SURFACE), force_n, initial=start, tolerance=tolerance)
    opening = levels[-1].displacement(solution.pressure) + gap - solution.indentation_m
    if (opening[~near] >= -tolerance * abs(solution.indentation_m)).all():
        return solution
    return solve_load(levels[-1], gap, force_n, initial=solution.pressure, tolerance=tolerance)


def _around(contact: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The rectangle of the coarse contact and its margin, on the finer grid."""
    near = np.zeros(tuple(2 * extent for extent in contact.shape), bool)
    spans = []
    for axis in (1, 0):
        hit = np.flatnonzero(contact.any(axis=axis))
        spans.append(slice(2 * max(int(hit[0]) - _MARGIN, 0), 2 * (int(hit[-1]) + 1 + _MARGIN)))
    near[spans[0], spans[1]] = True
    return near
