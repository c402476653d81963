"""The half-space kernel against Hertz and the flat punch."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.half_space import HalfSpaceCompliance
from sensors.contact.hertz import HertzSphere, flat_punch_force, plane_strain_modulus
from sensors.contact.solver import NO_SURFACE, solve_indentation, solve_load

MODULUS_PA = plane_strain_modulus(1e6, 0.3)
SPHERE = HertzSphere(radius_m=10e-3, indentation_m=0.1e-3, modulus_pa=MODULUS_PA)


def sphere_on(n: int) -> tuple[HalfSpaceCompliance, np.ndarray]:
    grid = Grid(n, 3 * SPHERE.contact_radius_m)
    x, y = grid.coordinates()
    return HalfSpaceCompliance(grid, MODULUS_PA), (x**2 + y**2) / (2 * SPHERE.radius_m)


def test_sphere_force_and_peak_pressure_are_hertz():
    compliance, gap = sphere_on(128)
    solution = solve_indentation(compliance, gap, SPHERE.indentation_m, tolerance=1e-8)
    assert solution.force_n == pytest.approx(SPHERE.force_n, rel=1e-3)
    assert solution.pressure.max() == pytest.approx(SPHERE.peak_pressure_pa, rel=5e-3)


def test_sphere_pressure_field_is_hertz_away_from_the_edge():
    compliance, gap = sphere_on(128)
    solution = solve_indentation(compliance, gap, SPHERE.indentation_m, tolerance=1e-8)
    x, y = compliance.grid.coordinates()
    r = np.hypot(x, y)
    inside = r < 0.9 * SPHERE.contact_radius_m
    error = np.abs(solution.pressure - SPHERE.pressure(r))[inside]
    assert error.max() < 0.01 * SPHERE.peak_pressure_pa


def test_load_control_finds_the_indentation_of_hertz():
    compliance, gap = sphere_on(128)
    solution = solve_load(compliance, gap, SPHERE.force_n, tolerance=1e-8)
    assert solution.force_n == pytest.approx(SPHERE.force_n, rel=1e-12)
    assert solution.indentation_m == pytest.approx(SPHERE.indentation_m, rel=1e-3)


def test_flat_punch_converges_at_first_order():
    radius, depth = 1e-3, 1e-5

    def error(n: int) -> float:
        grid = Grid(n, 3 * radius)
        x, y = grid.coordinates()
        gap = np.where(np.hypot(x, y) <= radius, 0.0, NO_SURFACE)
        force = solve_indentation(HalfSpaceCompliance(grid, MODULUS_PA), gap, depth, tolerance=1e-8).force_n
        # the staircase rim changes the punch's area: compare with the disc of the same area
        same_area = np.sqrt(np.isfinite(gap).sum() * grid.cell_area_m2 / np.pi)
        return abs(force / flat_punch_force(same_area, depth, MODULUS_PA) - 1)

    errors = [error(n) for n in (32, 64, 128)]
    assert errors[2] < 0.02
    assert errors[0] / errors[2] > 2.5
