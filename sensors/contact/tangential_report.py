"""Partial slip against Cattaneo and Mindlin, its cost on the layer, and what Goodman's approximation leaves out.

`python -m sensors.contact.tangential_report`
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from threadpoolctl import threadpool_limits

from sensors.contact.grid import Grid
from sensors.contact.hertz import HertzSphere, plane_strain_modulus
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.solver import ContactSolution, solve_load
from sensors.contact.tangential import HalfSpaceTangential, LayerTangential
from sensors.contact.tangential_oracle import CattaneoMindlin
from sensors.contact.tangential_solver import TangentialSolution, solve_tangential_load

_FRICTION = 0.5
_MODULUS_PA = 1e6
_SHARES = (0.1, 0.3, 0.5, 0.7, 0.9, 0.7, 0.5, 0.3)
"""Pull over friction times load along the timed path."""


def half_space_rows(n: int) -> Iterator[str]:
    """Errors (%) of stick radius, shift and traction (of mu p0) on a grid of `n` cells, a line per nu and pull."""
    yield f"half-space sphere, {n}x{n}, against Cattaneo-Mindlin: nu  Q/(mu P)  stick %  shift %  traction %  steps"
    for nu in (0.0, 0.3, 0.5):
        sphere = HertzSphere(10e-3, 0.1e-3, plane_strain_modulus(_MODULUS_PA, nu))
        exact = CattaneoMindlin(sphere, _MODULUS_PA / (2 * (1 + nu)), nu, _FRICTION)
        grid = Grid(n, 2.5 * sphere.contact_radius_m)
        r = np.hypot(*grid.coordinates())
        compliance = HalfSpaceTangential(grid, _MODULUS_PA, nu)
        for share in (0.3, 0.6, 0.9):
            force = share * exact.limit_n
            found = solve_tangential_load(compliance, sphere.pressure(r), _FRICTION, (force, 0.0))
            stick = np.sqrt(found.sticking.sum() * grid.cell_area_m2 / np.pi) / exact.stick_radius(force) - 1
            shift = found.shift_m[0] / exact.shift(force) - 1
            off = np.abs(found.traction[0] - exact.traction(r, force)).max() / (_FRICTION * sphere.peak_pressure_pa)
            errors = f"{100 * stick:+8.2f} {100 * shift:+8.2f} {100 * off:11.2f}"
            yield f"{nu:52.1f} {share:9.1f} {errors} {found.iterations:6d}"


def layer_rows(n: int, dtype: type[np.floating]) -> Iterator[str]:
    """CPU (ms) of a step of a loading and unloading path, and the neglected sinking over the indentation (%)."""
    for nu in (0.3, 0.45, 0.5):
        material = LayerMaterial(2e-3, _MODULUS_PA, nu)
        grid = Grid(n, 8 * material.thickness_m)
        x, y = grid.coordinates()
        press = solve_load(LayerCompliance(grid, material, dtype), (x**2 + y**2) / 0.02, 2.0)
        compliance = LayerTangential(grid, material, dtype)
        costs = []
        for _ in range(5):
            start = time.process_time()
            path = _path(compliance, press)
            costs.append(1e3 * (time.process_time() - start) / len(_SHARES))
        traction = path[4].traction
        # antisymmetric about the pull: it tips the contact, and carries no net load
        sinking = np.abs(compliance.sinking(traction)[press.contact]).max() / press.indentation_m
        yield (
            f"layer {n}x{n} {np.dtype(dtype).name}, nu {nu}: {int(press.contact.sum())} cells in contact, "
            f"{float(np.median(costs)):.1f} ms a step; at 0.9 mu P shear would tip the top by {100 * sinking:.1f} % "
            "of the depth"
        )


def _path(compliance: LayerTangential, press: ContactSolution) -> list[TangentialSolution]:
    path: list[TangentialSolution] = []
    for share in _SHARES:
        pull = (share * _FRICTION * press.force_n, 0.0)
        before = path[-1] if path else None
        path.append(solve_tangential_load(compliance, press.pressure, _FRICTION, pull, before=before))
    return path


def main() -> None:
    """Print the tables."""
    with threadpool_limits(1):
        for line in half_space_rows(64):
            print(line)
        for dtype in (np.float32, np.float64):
            for line in layer_rows(64, dtype):
                print(line)


if __name__ == "__main__":
    main()
