"""The hyperelastic rung, with a mesh fitted to the surface that presses it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from sensors.contact.grid import Grid
from sensors.contact.ladder.interface import OpenRung, Pad, Response
from sensors.contact.neohookean.mesh import PadMesh, graded_pad
from sensors.contact.neohookean.pad import NeoHookeanPad
from sensors.contact.neohookean.solution import PadSolution
from sensors.contact.neohookean.surface import Surface

_REACH = 0.3
"""Depth over the thickness for which the fine part of the mesh is laid out."""

_MARGIN = 1.2
"""Fine part over the extent of the surface below that depth."""

_NARROWEST = 0.5
"""Least half width of the fine part, in thicknesses."""


@dataclass(frozen=True)
class NeoHookeanRung:
    """`cells` from the centre to a side, `layers` through the thickness; responses on a grid of `n` cells."""

    name: str
    cells: int
    layers: int
    n: int = 128
    replays: ClassVar[bool] = False
    fitted: ClassVar[bool] = False

    def open(self, pad: Pad, indenter_class: str) -> OpenRung:
        """Prepare for `pad`; the mesh waits for the surface."""
        return OpenNeoHookean(pad, self.cells, self.layers, self.n)


@dataclass(frozen=True)
class OpenNeoHookean:
    """A hyperelastic pad; a surface with two planes of symmetry is solved on a quarter of it."""

    pad: Pad
    cells: int
    layers: int
    n: int

    def press_depths(self, surface: Surface, depths_m: Iterable[float]) -> Iterator[Response]:
        """See `OpenRung`."""
        for solution in self._solid(surface).press_depths(surface, depths_m):
            yield self._response(solution)

    def press_loads(self, surface: Surface, loads_n: Iterable[float]) -> Iterator[Response]:
        """See `OpenRung`."""
        for solution in self._solid(surface).press_loads(surface, loads_n):
            yield self._response(solution)

    def _solid(self, surface: Surface) -> NeoHookeanPad:
        return NeoHookeanPad(fitted_mesh(self.pad, surface, self.cells, self.layers), self.pad.material)

    def _response(self, solution: PadSolution) -> Response:
        grid = Grid(self.n, self.pad.side_m)
        shape = solution.depression(grid)
        return Response(grid, shape, contact_pressure(solution, grid), solution.force_n, solution.indentation_m)


def fitted_mesh(pad: Pad, surface: Surface, cells: int, layers: int) -> PadMesh:
    """A graded mesh, fine where `surface` reaches below 0.3 thicknesses, along x and y separately."""
    thickness, half = pad.material.thickness_m, pad.side_m / 2
    probe = Grid(128, pad.side_m)
    x, y = probe.coordinates()
    below = surface.jet(x, y).gap < _REACH * thickness
    core = [
        float(np.clip(_MARGIN * np.abs(axis[below]).max(initial=0.0), _NARROWEST * thickness, half)) for axis in (x, y)
    ]
    return graded_pad(pad.side_m, thickness, (core[0], core[1]), cells, layers, quarter=surface.quarter)


def contact_pressure(solution: PadSolution, grid: Grid) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Pressure (Pa) at the cells of `grid`, (n, n), between the deformed nodes; its sum carries the load."""
    positions, _ = solution.face()
    nodal = np.tile(solution.pressure, solution.mesh.copies)
    positions, index = np.unique(positions, axis=0, return_index=True)
    field = np.maximum(LinearNDInterpolator(positions, nodal[index], fill_value=0.0)(*grid.coordinates()), 0)
    total = float(field.sum()) * grid.cell_area_m2
    return field * (solution.force_n / total) if total > 0 else field
