"""The contact along a path: solved at a few places and loads, interpolated in between.

Everything is kept per newton of load. Places are two grid cells apart, so that a path along the grid meets the same
discretisation at every place; taxel loads go by splines along the path, which keep their sum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from sensors.contact.skin import SkinCompliance
from sensors.contact.solver import ContactSolution
from sensors.fvsight import FVSightUnit
from sensors.slide.path import Path, gap_at
from sensors.slide.shapes import SlidingBody

Array = NDArray[np.float64]

CELL_M = 1.0e-3
"""Edge of a friction cell; a few thread crowns."""
_TURN_STEP = np.deg2rad(5.0)
_LEVELS = (0.05, 0.2, 0.5, 1.0)
_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Placed:
    """A body with its tilt (rad) on its path over one sensor."""

    unit: FVSightUnit
    body: SlidingBody
    tilt: tuple[float, float]
    path: Path

    def solve(self, travel: float, load_n: float, initial: NDArray[np.floating] | None = None) -> ContactSolution:
        """The contact after `travel` under `load_n`."""
        gap = gap_at(self.body, self.tilt, self.path, travel, self.unit.grid)
        return self.unit.solve(gap, load_n, initial, _TOLERANCE)


@dataclass(frozen=True)
class Cells:
    """Friction cells in the object's frame: places (n, 2; m) and areas (n,; m^2) of contact."""

    place: Array
    area: Array


@dataclass(frozen=True)
class Track:
    """Contact at places `travel` (k,) and `loads` (j,; N): shares of taxels (k, j, 16) and of cells (k, n) in the load.

    With frames, modes (k, j, m, m) of the surface that the camera sees, in metres per newton.
    """

    travel: Array
    loads: Array
    taxel_share: Array
    cells: Cells
    cell_share: Array
    surface_modes: NDArray[np.float32] | None

    def taxel_load(self, travel: Array, load: Array) -> Array:
        """True taxel loads (t, 16) in newtons of the smooth contact."""
        return self._between_loads(self._along(self.taxel_share, travel), load) * load[:, None]

    def cell_load(self, travel: Array, load: Array) -> Array:
        """Loads (t, n) in newtons of the friction cells; their distribution is that under the largest load."""
        lower, upper, part = self._bracket(self.travel, travel)
        share = self.cell_share[lower] * (1 - part)[:, None] + self.cell_share[upper] * part[:, None]
        return share * load[:, None]

    def modes(self, travel: float, load: float) -> NDArray[np.float32]:
        """Modes (m, m) in metres of the surface that the camera sees."""
        if self.surface_modes is None:
            raise ValueError("this track was solved without the modes of the surface")
        k0, k1, along = (part[0] for part in self._bracket(self.travel, np.array([travel])))
        j0, j1, up = (part[0] for part in self._bracket(self.loads, np.array([load])))
        modes = self.surface_modes
        lighter = modes[k0, j0] * np.float32(1 - along) + modes[k1, j0] * np.float32(along)
        heavier = modes[k0, j1] * np.float32(1 - along) + modes[k1, j1] * np.float32(along)
        return (lighter * np.float32(1 - up) + heavier * np.float32(up)) * np.float32(load)

    def _along(self, values: Array, travel: Array) -> Array:
        if len(self.travel) == 1:
            return np.broadcast_to(values[0], (len(travel), *values.shape[1:]))
        spline = make_interp_spline(self.travel, values, k=min(3, len(self.travel) - 1))
        return np.asarray(spline(np.clip(travel, self.travel[0], self.travel[-1])))

    def _between_loads(self, values: Array, load: Array) -> Array:
        lower, upper, part = self._bracket(self.loads, load)
        row = np.arange(len(load))
        return values[row, lower] * (1 - part)[:, None] + values[row, upper] * part[:, None]

    @staticmethod
    def _bracket(knots: Array, at: Array) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
        """Knots below and above each point and the part of the way between them; ends hold beyond."""
        upper = np.clip(np.searchsorted(knots, at), 0 if len(knots) == 1 else 1, len(knots) - 1)
        lower = np.maximum(upper - 1, 0)
        width = np.where(upper > lower, knots[upper] - knots[lower], 1.0)
        return lower, upper, np.clip((at - knots[lower]) / width, 0, 1)


def lay_track(placed: Placed, travel: Array, load: Array, start: ContactSolution, frames: bool = False) -> Track:
    """Solve the contact where a motion `travel` (t,) under `load` (t,) comes by, from a first solution `start`."""
    places = _places(travel, placed)
    loads = _load_levels(load)
    unit = placed.unit
    shares = np.empty((len(places), len(loads), 16))
    modes = np.empty((len(places), len(loads), unit.grid.n, unit.grid.n), np.float32) if frames else None
    full: list[ContactSolution] = []
    pressure = start.pressure
    for k, place in enumerate(places):
        for j in reversed(range(len(loads))):
            contact = placed.solve(float(place), float(loads[j]), pressure)
            shares[k, j] = unit.taxel_load(contact.pressure) / contact.force_n
            if modes is not None:
                modes[k, j] = unit.observe(contact).surface_modes / contact.force_n
            if j == len(loads) - 1:
                full.append(contact)
                pressure = contact.pressure
    cells, cell_share = _friction_cells(placed.path, places, full)
    return Track(places, loads, shares, cells, cell_share, modes)


def traction_modes(unit: FVSightUnit, contact: ContactSolution) -> NDArray[np.floating]:
    """Sine modes of a traction on a hollow skin that is shared out like the pressure and adds up to one newton."""
    compliance = unit.compliance
    assert isinstance(compliance, SkinCompliance)
    return compliance.modes(contact.pressure) / contact.force_n


def _places(travel: Array, placed: Placed) -> Array:
    low, high = float(travel.min()), float(travel.max())
    if high - low < 1e-9:
        return np.array([low])
    step = _TURN_STEP if placed.path.turns else 2 * placed.unit.grid.pitch_m
    # one place beyond either end: the skin's own shear moves the pattern back and forth
    return low + step * np.arange(-1, np.ceil((high - low) / step) + 2)


def _load_levels(load: Array) -> Array:
    top = float(load.max())
    return np.array([top]) if load.min() > 0.85 * top else top * np.array(_LEVELS)


def _friction_cells(path: Path, places: Array, contacts: list[ContactSolution]) -> tuple[Cells, Array]:
    """Bin the fine pressure of each place into cells fixed to the object, by bilinear weights."""
    grid = contacts[0].grid
    x, y = grid.coordinates()
    touched = [contact.contact for contact in contacts]
    points = [
        np.stack(path.to_object(x[mask], y[mask], float(place)), axis=-1) / CELL_M
        for mask, place in zip(touched, places, strict=True)
    ]
    low = np.floor(np.min([p.min(axis=0) for p in points], axis=0)).astype(int)
    shape = tuple(np.ceil(np.max([p.max(axis=0) for p in points], axis=0)).astype(int) - low + 2)
    load = np.zeros((len(places), *shape))
    area = np.zeros_like(load)
    for k, (mask, at, contact) in enumerate(zip(touched, points, contacts, strict=True)):
        corner = np.floor(at).astype(int)
        part = at - corner
        share = contact.pressure[mask].astype(np.float64)
        share /= share.sum()
        for dx, dy in ((0, 0), (0, 1), (1, 0), (1, 1)):
            weight = np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1])
            index = (k, corner[:, 0] + dx - low[0], corner[:, 1] + dy - low[1])
            np.add.at(load, index, weight * share)
            np.add.at(area, index, weight * grid.cell_area_m2)
    used = load.max(axis=0) > 1e-4
    place = (np.argwhere(used) + low) * CELL_M
    kept = load[:, used]
    kept /= kept.sum(axis=1, keepdims=True)
    return Cells(place.astype(np.float64), area.max(axis=0)[used]), kept
