"""The reduced pad as a rung of the ladder: trained for the class of indenter that it is opened for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar

from sensors.contact.grid import Grid
from sensors.contact.ladder.indenters import indenter
from sensors.contact.ladder.interface import OpenRung, Pad, Response
from sensors.contact.ladder.solid import fitted_mesh
from sensors.contact.neohookean.pad import NeoHookeanPad
from sensors.contact.neohookean.solution import PadSolution
from sensors.contact.neohookean.surface import Surface
from sensors.contact.neohookean_reduced.face import face_on_grid
from sensors.contact.neohookean_reduced.pad import ReducedPad
from sensors.contact.neohookean_reduced.train import MODES, SNAPSHOTS, train_reduced


@dataclass(frozen=True)
class NeoHookeanReducedRung:
    """`cells` from the centre to a side, `layers` through the thickness; responses on a grid of `n` cells.

    Opening it trains it (20 presses of the full model) on the representative of the class, down to `depth_ratio`
    thicknesses; any other surface, place or depth is refused with a ValueError.
    """

    name: str
    cells: int
    layers: int
    n: int = 128
    depth_ratio: float = 0.3
    snapshots: int = SNAPSHOTS
    modes: int = MODES
    replays: ClassVar[bool] = True
    fitted: ClassVar[bool] = False

    def open(self, pad: Pad, indenter_class: str) -> OpenRung:
        """Train for `pad` and the class."""
        thickness = pad.material.thickness_m
        surface = indenter(indenter_class, thickness)
        full = NeoHookeanPad(fitted_mesh(pad, surface, self.cells, self.layers), pad.material)
        deepest = self.depth_ratio * thickness
        trained = train_reduced(full, surface, deepest, snapshots=self.snapshots, modes=self.modes)
        return OpenReduced(trained, Grid(self.n, pad.side_m))


@dataclass(frozen=True)
class OpenReduced:
    """A trained pad that answers on `grid`."""

    pad: ReducedPad
    grid: Grid

    def press_depths(self, surface: Surface, depths_m: Iterable[float]) -> Iterator[Response]:
        """See `OpenRung`; in any order."""
        for solution in self.pad.press_depths(surface, depths_m):
            yield self._response(solution)

    def press_loads(self, surface: Surface, loads_n: Iterable[float]) -> Iterator[Response]:
        """See `OpenRung`; in any order."""
        for solution in self.pad.press_loads(surface, loads_n):
            yield self._response(solution)

    def _response(self, solution: PadSolution) -> Response:
        down, pressure = face_on_grid(solution, self.grid)
        return Response(self.grid, down, pressure, solution.force_n, solution.indentation_m)
