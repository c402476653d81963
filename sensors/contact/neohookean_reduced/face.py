"""The deformed top of a pad on a grid, without triangulating it: each cell is traced back to where it came from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.neohookean.solution import PadSolution

Floats = NDArray[np.float64]

_TRACES = 8


def face_on_grid(solution: PadSolution, grid: Grid) -> tuple[Floats, Floats]:
    """Depression (m) and pressure (Pa) of the deformed top at the cells of `grid`, both (n, n).

    Bilinear between the nodes of the undeformed lattice, at X with X + u(X) = x (found by iteration). The pressure is
    scaled so that its sum over the cells carries the load.
    """
    mesh = solution.mesh
    shape = mesh.points[:2]
    lattice = mesh.nodes[mesh.top].reshape(*shape, 3)
    fields = np.empty((4, *shape))
    fields[:3] = np.moveaxis(solution.displacement[mesh.top].reshape(*shape, 3), -1, 0)
    fields[3] = solution.pressure.reshape(shape)
    lines = lattice[:, 0, 0], lattice[0, :, 1]
    axis = grid.axis()
    if mesh.quarter:
        axis = axis[grid.n // 2 :]
    x, y = np.meshgrid(axis, axis)
    from_x, from_y = x, y
    for _ in range(_TRACES):
        u = _between(fields[:2], lines, from_x, from_y)
        from_x, from_y = x - u[0], y - u[1]
    down, pressure = _between(fields[2:], lines, from_x, from_y)
    if mesh.quarter:
        down, pressure = _mirrored(down, grid.n), _mirrored(pressure, grid.n)
    total = float(pressure.sum()) * grid.cell_area_m2
    return -down, pressure * (solution.force_n / total) if total > 0 else pressure


def _between(fields: Floats, lines: tuple[Floats, Floats], x: Floats, y: Floats) -> Floats:
    """Fields (f, nx, ny) over increasing lines at points of any shape, (f, ...); the outermost nodes go on."""
    (i, s), (j, t) = _place(lines[0], x), _place(lines[1], y)
    low = (1 - t) * fields[:, i, j] + t * fields[:, i, j + 1]
    high = (1 - t) * fields[:, i + 1, j] + t * fields[:, i + 1, j + 1]
    return (1 - s) * low + s * high


def _place(line: Floats, at: Floats) -> tuple[NDArray[np.int64], Floats]:
    index = np.clip(np.searchsorted(line, at, side="right") - 1, 0, len(line) - 2)
    share = (at - line[index]) / (line[index + 1] - line[index])
    return index, np.clip(share, 0.0, 1.0)


def _mirrored(quadrant: Floats, n: int) -> Floats:
    """The whole field of the quadrant x, y >= 0 of an n x n grid."""
    back = quadrant[n % 2 :]
    rows = np.concatenate([back[::-1], quadrant])
    return np.concatenate([rows[:, n % 2 :][:, ::-1], rows], axis=1)
