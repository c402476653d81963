"""The rungs that know only the pad's top: independent springs, and the linear bonded layer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.ladder.indenters import indenter
from sensors.contact.ladder.interface import OpenRung, Pad, Response
from sensors.contact.layer import LayerCompliance
from sensors.contact.neohookean.surface import Surface
from sensors.contact.solver import ContactSolution, solve_indentation, solve_load
from sensors.contact.thickness import refuse_depth, refuse_through
from sensors.contact.winkler import WinklerBed, fit_winkler

WINKLER_FIT = (0.05, 0.1, 0.2, 0.3)
"""Depths over the thickness at which the springs are fitted to the layer."""


@dataclass(frozen=True)
class LayerRung:
    """The linear layer on a grid of `n` cells a side."""

    name: str
    n: int
    dtype: type[np.floating]
    replays: ClassVar[bool] = False
    fitted: ClassVar[bool] = False

    def open(self, pad: Pad, indenter_class: str) -> OpenRung:
        """Prepare the operator for `pad`; the class of indenter does not matter to it."""
        return OpenLayer(LayerCompliance(Grid(self.n, pad.side_m), pad.material, self.dtype))


@dataclass(frozen=True)
class OpenLayer:
    """A layer's operator, ready to press."""

    compliance: LayerCompliance

    def press_depths(self, surface: Surface, depths_m: Iterable[float]) -> Iterator[Response]:
        """See `OpenRung`."""
        gap, pressure = _gap(surface, self.compliance.grid), None
        for depth in depths_m:
            refuse_depth(depth, self.compliance.material.thickness_m)
            solution = solve_indentation(self.compliance, gap, depth, initial=pressure)
            pressure = solution.pressure
            yield self._response(solution)

    def press_loads(self, surface: Surface, loads_n: Iterable[float]) -> Iterator[Response]:
        """See `OpenRung`."""
        gap, pressure = _gap(surface, self.compliance.grid), None
        for load in loads_n:
            solution = solve_load(self.compliance, gap, load, initial=pressure)
            refuse_through(solution, self.compliance.material.thickness_m)
            pressure = solution.pressure
            yield self._response(solution)

    def _response(self, solution: ContactSolution) -> Response:
        shape = self.compliance.displacement(solution.pressure)
        return Response(solution.grid, shape, solution.pressure, solution.force_n, solution.indentation_m)


@dataclass(frozen=True)
class WinklerRung:
    """Springs on a grid of `n` cells a side, fitted to the layer for the pad and the class of indenter."""

    name: str
    n: int
    replays: ClassVar[bool] = False
    fitted: ClassVar[bool] = True

    def open(self, pad: Pad, indenter_class: str) -> OpenRung:
        """Fit the springs; ValueError for a class without a representative."""
        return OpenWinkler(_fitted(pad, indenter_class, self.n), pad.material.thickness_m)


@lru_cache(maxsize=64)
def _fitted(pad: Pad, indenter_class: str, n: int) -> WinklerBed:
    thickness = pad.material.thickness_m
    grid = Grid(n, pad.side_m)
    depths = [ratio * thickness for ratio in WINKLER_FIT]
    return fit_winkler(pad.material, grid, _gap(indenter(indenter_class, thickness), grid), depths)


@dataclass(frozen=True)
class OpenWinkler:
    """Springs of known stiffness in the place of a pad of `thickness_m`, ready to press."""

    bed: WinklerBed
    thickness_m: float

    def press_depths(self, surface: Surface, depths_m: Iterable[float]) -> Iterator[Response]:
        """See `OpenRung`."""
        gap = _gap(surface, self.bed.grid)
        for depth in depths_m:
            refuse_depth(depth, self.thickness_m)
            yield self._response(self.bed.solve_indentation(gap, depth))

    def press_loads(self, surface: Surface, loads_n: Iterable[float]) -> Iterator[Response]:
        """See `OpenRung`."""
        gap = _gap(surface, self.bed.grid)
        for load in loads_n:
            solution = self.bed.solve_load(gap, load)
            refuse_through(solution, self.thickness_m)
            yield self._response(solution)

    def _response(self, solution: ContactSolution) -> Response:
        shape = self.bed.displacement(solution)
        return Response(solution.grid, shape, solution.pressure, solution.force_n, solution.indentation_m)


def _gap(surface: Surface, grid: Grid) -> NDArray[np.float64]:
    return surface.jet(*grid.coordinates()).gap
