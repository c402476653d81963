"""Measures what a contact grid costs and how far it is from a fine one, over the household objects."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors import objects
from sensors.contact.skin import sine_basis
from sensors.fvsight import FVSightParameters, FVSightUnit
from sensors.grids.table import GridRow, GridTable
from sensors.optics.camera import REGION_PIXELS
from sensors.press import presented_gap

PADS: dict[str, FVSightParameters] = {
    "skin": FVSightParameters(),
    "pad on a plate": FVSightParameters(support="plate", film_thickness_mm=4.0, film_modulus_mpa=0.3),
}
_NAMING = {
    "skin": ("support", "region_mm", "tension_n_per_m", "film_thickness_mm", "film_modulus_mpa", "film_poisson"),
    "pad on a plate": ("support", "region_mm", "film_thickness_mm", "film_modulus_mpa", "film_poisson"),
}
GRIDS, REFERENCE, FINER = (64, 128, 256), 256, 512
SPRING_GRIDS = (64, 128)
"""Finer ones cost what the layer does on these."""
LOADS_N = (1.5, 5.0)
_POSES = ((0.0, 0.0, 0.0), (2.1, -1.3, 37.0))
"""Places of each object (mm, mm, deg): along the grid, and turned and off the grid."""
_SPECIMEN_M = 0.056
_TIGHT = 1e-5


@dataclass(frozen=True)
class _Seen:
    taxels: NDArray[np.float64]
    surface: NDArray[np.floating]
    frame: NDArray[np.floating]
    cost_ms: float
    depth_ratio: float


def measure_grids(
    names: Sequence[str] = (), report: Callable[[str], None] = lambda line: None, pads: Sequence[str] = tuple(PADS)
) -> GridTable:
    """Errors and costs of the grids for the pads, over the objects `names` (all where empty), two poses and two loads.

    The reference is solved to a tolerance of 1e-5; its own change is seen in the last pose under the largest load.
    About four minutes of one core for all; `report` gets a line per row. Classes of objects are their families. A film
    on a plate is measured with springs in its place, too.
    """
    changes: list[GridRow] = []
    rows: list[GridRow] = []
    for pad in pads:
        wanted = [(n, "elastic") for n in (*GRIDS, FINER)]
        if PADS[pad].support == "plate":
            wanted += [(n, "springs") for n in SPRING_GRIDS]
        units = {(n, contact): FVSightUnit(_pad(pad, n, contact), 0) for n, contact in wanted}
        exactly = units[REFERENCE, "elastic"], units[FINER, "elastic"]
        del units[FINER, "elastic"]
        found: dict[tuple[str, int, str], list[tuple[float, ...]]] = {}
        for name in names or objects.names():
            family = objects.get(name).family
            for pose in _POSES:
                for load in LOADS_N:
                    exact = _see(exactly[0], name, pose, load, _TIGHT)
                    if (pose, load) == (_POSES[-1], LOADS_N[-1]):
                        finer = _see(exactly[1], name, pose, load, _TIGHT)
                        found.setdefault((family, 0, "elastic"), []).append(_errors(exact, finer, load))
                    for (n, contact), unit in units.items():
                        seen = _see(unit, name, pose, load, None)
                        found.setdefault((family, n, contact), []).append(_errors(seen, exact, load))
        for (family, n, contact), values in found.items():
            (changes if n == 0 else rows).append(_row(pad, family, n or REFERENCE, contact, values))
            report(str((rows if n else changes)[-1]))
    parameters = {pad: {key: getattr(PADS[pad], key) for key in _NAMING[pad]} for pad in pads}
    words = f"{REFERENCE}x{REFERENCE} solved to {_TIGHT:g}; its own change is to {FINER}x{FINER}"
    return GridTable(parameters, LOADS_N, words, _machine(), tuple(changes), tuple(rows))


def _pad(pad: str, n: int, contact: str) -> FVSightParameters:
    return PADS[pad].model_copy(update={"grid": n, "contact": contact})


def _see(
    unit: FVSightUnit, name: str, pose: tuple[float, float, float], load_n: float, tolerance: float | None
) -> _Seen:
    gap = presented_gap(name, unit, pose, _SPECIMEN_M)
    unit.camera.clean(None)  # the camera is built once
    start = time.process_time()
    press = unit.press(gap, load_n) if tolerance is None else unit.press(gap, load_n, tolerance=tolerance)
    frame = unit.camera.clean(press.surface_modes)
    cost_ms = 1e3 * (time.process_time() - start)
    basis = _pixels(unit.grid.n)
    thickness = unit.skin.film.thickness_m
    depth_ratio = press.contact.indentation_m / thickness if unit.parameters.support == "plate" else 0.0
    return _Seen(press.taxel_load, basis @ press.surface_modes @ basis.T, frame, cost_ms, depth_ratio)


def _pixels(n: int) -> NDArray[np.float64]:
    return sine_basis((np.arange(REGION_PIXELS) + 0.5) / REGION_PIXELS, n)


def _errors(seen: _Seen, exact: _Seen, load_n: float) -> tuple[float, ...]:
    def rms(field: NDArray[Any]) -> float:
        return float(np.sqrt(np.mean(np.square(field, dtype=np.float64))))

    force = float(np.abs(seen.taxels - exact.taxels).max()) / load_n
    displacement = rms(seen.surface - exact.surface) / rms(exact.surface)
    return force, displacement, rms(seen.frame - exact.frame), seen.cost_ms, seen.depth_ratio


def _row(pad: str, family: str, grid: int, contact: str, values: list[tuple[float, ...]]) -> GridRow:
    *columns, cost, depth = np.array(values).T
    force, displacement, frame, deepest = (round(float(column.max()), 5) for column in (*columns, depth))
    cost_ms = round(float(np.median(cost)), 3)
    return GridRow(pad, family, grid, force, displacement, frame, cost_ms, contact, deepest)


def _machine() -> str:
    return f"{platform.machine()}, one thread, Python {platform.python_version()}, NumPy {np.__version__}"
