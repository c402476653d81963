"""Every contact model on every grid against what is known in closed form, and what a solve costs.

Hertz's sphere and the flat punch for the half-space (Johnson, "Contact Mechanics", 1985); the series of P. D. Garcia,
R. Garcia, Biophys. J. 114 (2018) 2923 for the bonded incompressible layer under a sphere; Navier's series for the skin
(S. Timoshenko, S. Woinowsky-Krieger, "Theory of Plates and Shells", 1959, section 28).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.half_space import HalfSpaceCompliance
from sensors.contact.hertz import HertzSphere, flat_punch_force
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.operator import Compliance
from sensors.contact.skin import SkinCompliance, SkinMaterial
from sensors.contact.solver import NO_SURFACE, ContactSolution, solve_indentation, solve_load
from sensors.contact.winkler import fit_winkler

GRIDS = (64, 128, 256)
PRECISIONS: tuple[type[np.floating], ...] = (np.float32, np.float64)
_TIMES = 7
_STEP = 0.95
"""A warm solve starts from the solution of this share of the depth or load, as along an indentation path."""

SPHERE = HertzSphere(10e-3, 0.1e-3, 1e6)
LAYER = LayerMaterial(2e-3, 1e6, 0.5)
LAYER_RADIUS_M = 10e-3
SKIN = SkinMaterial(LayerMaterial(1.5e-3, 5e6, 0.45), 600.0)
SKIN_SIDE_M = 0.08
_SKIN_BALL_M, _SKIN_LOAD_N = 20e-3, 5.0


@dataclass(frozen=True)
class OracleRow:
    """Relative `error` against a closed form, and CPU ms of a cold and a warm solve (medians; None: nothing solved)."""

    model: str
    grid: int
    precision: str
    oracle: str
    error: float
    cold_ms: float | None
    warm_ms: float | None


def score_closed_forms(grids: tuple[int, ...] = GRIDS) -> list[OracleRow]:
    """Rows of half-space, layer, springs and skin on `grids`, float32 and float64, at the solver's usual tolerance."""
    rows: list[OracleRow] = []
    for n in grids:
        rows.append(_springs(n))
        for precision in PRECISIONS:
            rows += [*_layer(n, precision), *_half_space(n, precision), *_skin(n, precision)]
    return sorted(rows, key=lambda row: (row.model, row.oracle, row.precision, row.grid))


def finite_thickness(x: float) -> float:
    """Force of a sphere on a bonded incompressible layer over Hertz's, at x = sqrt(R d) / h; good up to about 1."""
    return 1 + 1.133 * x + 1.497 * x**2 + 1.469 * x**3 + 0.755 * x**4


def _layer(n: int, precision: type[np.floating]) -> Iterator[OracleRow]:
    grid = Grid(n, 8 * LAYER.thickness_m)
    layer = LayerCompliance(grid, LAYER, precision)
    gap = _ball(grid, LAYER_RADIUS_M)
    for x in (0.2, 0.4):
        depth = _layer_depth(x)
        exact = HertzSphere(LAYER_RADIUS_M, depth, LAYER.modulus_pa).force_n * finite_thickness(x)
        solution, cold, warm = _to_depth(layer, gap, depth)
        yield _row("layer", n, precision, f"bonded sphere, a/h {x:g}", solution.force_n / exact - 1, cold, warm)


def _springs(n: int) -> OracleRow:
    grid, x = Grid(n, 8 * LAYER.thickness_m), 0.4
    gap = _ball(grid, LAYER_RADIUS_M)
    bed = fit_winkler(LAYER, grid, gap, [_layer_depth(at) for at in (0.2, 0.4, 0.6)])
    exact = HertzSphere(LAYER_RADIUS_M, _layer_depth(x), LAYER.modulus_pa).force_n * finite_thickness(x)
    solution, cost = _clocked(lambda: bed.solve_indentation(gap, _layer_depth(x)))
    return _row("winkler", n, np.float64, f"bonded sphere, a/h {x:g}", solution.force_n / exact - 1, cost, cost)


def _half_space(n: int, precision: type[np.floating]) -> Iterator[OracleRow]:
    grid = Grid(n, 3 * SPHERE.contact_radius_m)
    space = HalfSpaceCompliance(grid, SPHERE.modulus_pa, precision)
    solution, cold, warm = _to_depth(space, _ball(grid, SPHERE.radius_m), SPHERE.indentation_m)
    yield _row("half-space", n, precision, "Hertz, force", solution.force_n / SPHERE.force_n - 1, cold, warm)
    exact = SPHERE.pressure(np.hypot(*grid.coordinates()))
    field = float(np.linalg.norm(solution.pressure - exact) / np.linalg.norm(exact))
    yield _row("half-space", n, precision, "Hertz, pressure field", field, cold, warm)
    radius, depth = grid.size_m / 3, 1e-5
    gap = np.where(np.hypot(*grid.coordinates()) <= radius, 0.0, NO_SURFACE)
    solution, cold, warm = _to_depth(space, gap, depth)
    exact_n = flat_punch_force(radius, depth, SPHERE.modulus_pa)
    yield _row("half-space", n, precision, "flat punch, force", solution.force_n / exact_n - 1, cold, warm)


def _skin(n: int, precision: type[np.floating]) -> Iterator[OracleRow]:
    grid = Grid(n, SKIN_SIDE_M)
    skin = SkinCompliance(grid, SKIN, precision)
    at = int(0.55 * n)
    place = float(grid.axis()[at] + SKIN_SIDE_M / 2)
    even = float(skin.deflection(np.ones((n, n)))[at, at])
    odd = np.arange(1, 1999, 2)
    exact = _navier(place, odd, 16 / (np.pi**2 * odd[:, None] * odd))
    yield _row("skin", n, precision, "Navier, uniform load", even / exact - 1, None, None)
    gap = _ball(grid, _SKIN_BALL_M)
    start = solve_load(skin, gap, _STEP * _SKIN_LOAD_N).pressure
    solution, cold = _clocked(lambda: solve_load(skin, gap, _SKIN_LOAD_N))
    _, warm = _clocked(lambda: solve_load(skin, gap, _SKIN_LOAD_N, initial=start))
    # far from the ball the load is a point load
    far = int(0.2 * n)
    place = float(grid.axis()[far] + SKIN_SIDE_M / 2)
    modes = np.arange(1, 400)
    middle = np.sin(modes * np.pi / 2)
    exact = _navier(place, modes, 4 / SKIN_SIDE_M**2 * middle[:, None] * middle) * _SKIN_LOAD_N
    error = float(skin.deflection(solution.pressure)[far, far]) / exact - 1
    yield _row("skin", n, precision, "Navier, far from a ball", error, cold, warm)


def _navier(place: float, modes: NDArray[np.int_], load: NDArray[np.float64]) -> float:
    """Deflection at (place, place) from the corner under double-sine coefficients `load`."""
    wave = modes * np.pi / SKIN_SIDE_M
    amplitude = load * SKIN.plate_compliance(wave[:, None] ** 2 + wave**2)
    shape = np.sin(wave * place)
    return float(shape @ amplitude @ shape)


def _layer_depth(x: float) -> float:
    return (x * LAYER.thickness_m) ** 2 / LAYER_RADIUS_M


def _ball(grid: Grid, radius_m: float) -> NDArray[np.float64]:
    x, y = grid.coordinates()
    return (x**2 + y**2) / (2 * radius_m)


def _to_depth(compliance: Compliance, gap: NDArray[np.float64], depth_m: float) -> tuple[ContactSolution, float, float]:
    start = solve_indentation(compliance, gap, _STEP * depth_m).pressure
    solution, cold = _clocked(lambda: solve_indentation(compliance, gap, depth_m))
    _, warm = _clocked(lambda: solve_indentation(compliance, gap, depth_m, initial=start))
    return solution, cold, warm


def _clocked(solve: Callable[[], ContactSolution]) -> tuple[ContactSolution, float]:
    """The solution, and the median CPU ms after a first call."""
    solution, spent = solve(), []
    for _ in range(_TIMES):
        start = time.process_time()
        solve()
        spent.append(1e3 * (time.process_time() - start))
    return solution, float(np.median(spent))


def _row(
    model: str, n: int, precision: type[np.floating], oracle: str, error: float, cold: float | None, warm: float | None
) -> OracleRow:
    return OracleRow(model, n, np.dtype(precision).name, oracle, abs(float(error)), cold, warm)
