"""The half-space under a sphere beside tamaas, a contact solver from the package index, at equal pressure error.

tamaas: L. Frerot, G. Anciaux, V. Rey, S. Pham-Ba, J.-F. Molinari, J. Open Source Software 5 (2020) 2121. Its solver of
A. Polonsky and L. M. Keer on its non-periodic operator (`dcfft`) meets ours, on nested
grids, with the same cells, load and precision.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.half_space import HalfSpaceCompliance
from sensors.contact.hertz import HertzSphere
from sensors.contact.nested import solve_load_nested
from sensors.contact.scoring.closed_forms import SPHERE

Pressure = NDArray[np.float64]
Solver = Callable[[float], Pressure]
"""Solves to a tolerance of its own kind and gives the pressure (n, n)."""

_TOLERANCES = tuple(10.0 ** (-step / 2) for step in range(4, 21))
_COARSEST = 8
"""Cells of a side of the coarsest of our nested grids."""
_SLACK = 1.02
"""Both solvers must come this near to the larger of the two errors that the cells leave."""


@dataclass(frozen=True)
class PeerRow:
    """Both at the same error of the pressure field against Hertz: CPU ms (medians), and how many times faster ours is.

    `ratio` is the median over interleaved rounds, `ratio_low` and `ratio_high` the 5th and 95th percentile.
    """

    grid: int
    error: float
    peer_error: float
    ours_ms: float
    peer_ms: float
    ratio: float
    ratio_low: float
    ratio_high: float
    rounds: int


def has_tamaas() -> bool:
    """Whether the optional peer is installed."""
    return importlib.util.find_spec("tamaas") is not None


def compare_with_tamaas(grids: tuple[int, ...] = (64, 128, 256), rounds: int = 15) -> list[PeerRow]:
    """A row a grid, float64, cold, without building the operators. ValueError where tamaas is not installed.

    Each solver takes the loosest tolerance, of 1e-2 down to 1e-10 in half decades, at which its error is within 2 % of
    the larger of the two that remain at the tightest. Pin the threads to one outside.
    """
    if not has_tamaas():
        raise ValueError("the peer solver is not installed: pip install 'vtbench[peers]'")
    return [_compare(n, rounds) for n in grids]


def _compare(n: int, rounds: int) -> PeerRow:
    grid = Grid(n, 3 * SPHERE.contact_radius_m)
    exact = SPHERE.pressure(np.hypot(*grid.coordinates()))

    def error(pressure: Pressure) -> float:
        return float(np.linalg.norm(pressure - exact) / np.linalg.norm(exact))

    ours, peer = _our_solver(grid, SPHERE), _tamaas_solver(grid, SPHERE)
    found = [[error(solver(tolerance)) for tolerance in _TOLERANCES] for solver in (ours, peer)]
    target = _SLACK * max(errors[-1] for errors in found)
    at = [next(i for i, one in enumerate(errors) if one <= target) for errors in found]
    spent = np.array([[_clocked(ours, _TOLERANCES[at[0]]), _clocked(peer, _TOLERANCES[at[1]])] for _ in range(rounds)])
    ratio = spent[:, 1] / spent[:, 0]
    low, middle, high = (float(value) for value in np.percentile(ratio, (5, 50, 95)))
    ours_ms, peer_ms = (float(value) for value in np.median(spent, axis=0))
    return PeerRow(n, found[0][at[0]], found[1][at[1]], ours_ms, peer_ms, middle, low, high, rounds)


def _clocked(solver: Solver, tolerance: float) -> float:
    start = time.process_time()
    solver(tolerance)
    return 1e3 * (time.process_time() - start)


def _gap(grid: Grid, sphere: HertzSphere) -> Pressure:
    x, y = grid.coordinates()
    return (x**2 + y**2) / (2 * sphere.radius_m)


def _our_solver(grid: Grid, sphere: HertzSphere) -> Solver:
    sizes = [_COARSEST << level for level in range((grid.n // _COARSEST).bit_length())]
    spaces = [HalfSpaceCompliance(Grid(n, grid.size_m), sphere.modulus_pa) for n in sizes]
    gap = _gap(grid, sphere)

    def solve(tolerance: float) -> Pressure:
        return solve_load_nested(spaces, gap, sphere.force_n, tolerance=tolerance).pressure.astype(np.float64)

    return solve


def _tamaas_solver(grid: Grid, sphere: HertzSphere) -> Solver:
    import tamaas

    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [grid.size_m, grid.size_m], [grid.n, grid.n])
    model.E, model.nu = sphere.modulus_pa, 0.0  # E* of the half-space
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    surface = -_gap(grid, sphere)

    def solve(tolerance: float) -> Pressure:
        model.traction[...] = 0
        model.displacement[...] = 0
        solver = tamaas.PolonskyKeerRey(model, surface, tolerance)
        solver.setIntegralOperator("dcfft")
        solver.solve(sphere.force_n / grid.size_m**2)
        return np.array(model.traction)

    return solve
