"""The Winkler bed: closed forms, load against depth control, and its fit to the layer."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.solver import NO_SURFACE, solve_indentation
from sensors.contact.winkler import WinklerBed, fit_winkler

GRID = Grid(96, 0.02)
MATERIAL = LayerMaterial(2.5e-3, 2e5, 0.45)


def paraboloid(radius=8e-3):
    x, y = GRID.coordinates()
    return (x**2 + y**2) / (2 * radius)


def punch(radius=3e-3):
    x, y = GRID.coordinates()
    return np.where(np.hypot(x, y) < radius, 0.0, NO_SURFACE)


def test_a_paraboloid_follows_its_closed_form():
    """F = pi k R d^2."""
    bed, depth = WinklerBed(GRID, 1e8), 1e-3
    force = bed.solve_indentation(paraboloid(), depth).force_n
    assert force == pytest.approx(np.pi * 1e8 * 8e-3 * depth**2, rel=5e-3)


@pytest.mark.parametrize(
    "gap", [paraboloid(), punch(), paraboloid() + 1e-4 * np.random.default_rng(0).random((96, 96))]
)
@pytest.mark.parametrize("force", [1e-4, 0.3, 40.0, 1e4])
def test_load_control_meets_the_load(gap, force):
    solution = WinklerBed(GRID, 1e8).solve_load(gap, force)
    assert solution.force_n == pytest.approx(force, rel=1e-9)


def test_pressure_only_where_it_touches_and_displacement_follows_the_indenter():
    bed, gap = WinklerBed(GRID, 1e8), paraboloid()
    solution = bed.solve_indentation(gap, 5e-4)
    assert (solution.contact == (gap < 5e-4)).all()
    assert bed.displacement(solution)[solution.contact] == pytest.approx((5e-4 - gap)[solution.contact])
    assert not bed.solve_indentation(gap, -1e-4).contact.any()
    assert not bed.solve_load(gap, 0.0).contact.any()


@pytest.mark.parametrize("gap", [paraboloid(), punch()])
def test_a_fit_to_one_depth_meets_the_layer_there(gap):
    bed = fit_winkler(MATERIAL, GRID, gap, [4e-4], tolerance=1e-7)
    layer = solve_indentation(LayerCompliance(GRID, MATERIAL), gap, 4e-4, tolerance=1e-7)
    assert bed.solve_indentation(gap, 4e-4).force_n == pytest.approx(layer.force_n, rel=1e-9)


def test_a_fit_to_many_depths_is_the_best_stiffness():
    depths = np.linspace(1e-4, 6e-4, 4)
    bed = fit_winkler(MATERIAL, GRID, paraboloid(), depths)
    layer = LayerCompliance(GRID, MATERIAL)
    exact = np.array([solve_indentation(layer, paraboloid(), depth).force_n for depth in depths])

    def misfit(stiffness):
        springs = WinklerBed(GRID, stiffness)
        forces = np.array([springs.solve_indentation(paraboloid(), depth).force_n for depth in depths])
        return ((forces / exact - 1) ** 2).sum()

    best = misfit(bed.stiffness_pa_per_m)
    assert best < misfit(1.02 * bed.stiffness_pa_per_m)
    assert best < misfit(0.98 * bed.stiffness_pa_per_m)


def test_thinner_pads_and_flatter_indenters_have_their_own_stiffness():
    def stiffness(thickness, gap):
        return fit_winkler(LayerMaterial(thickness, 2e5, 0.45), GRID, gap, [3e-4]).stiffness_pa_per_m

    assert stiffness(1.5e-3, paraboloid()) > 1.2 * stiffness(3e-3, paraboloid())
    assert stiffness(2.5e-3, punch()) != pytest.approx(stiffness(2.5e-3, paraboloid()), rel=0.05)


def test_an_uncompressed_column_is_the_limit_of_a_wide_punch():
    """A punch much wider than the layer: k -> M / h, the confined modulus over the thickness."""
    grid, nu = Grid(128, 0.04), 0.2
    x, y = grid.coordinates()
    wide = np.where(np.hypot(x, y) < 0.018, 0.0, NO_SURFACE)
    bed = fit_winkler(LayerMaterial(5e-4, 2e5, nu), grid, wide, [1e-5])
    confined = 2e5 * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    assert bed.stiffness_pa_per_m == pytest.approx(confined / 5e-4, rel=0.04)


def test_impossible_beds_and_presses_are_refused():
    with pytest.raises(ValueError, match="positive, finite"):
        WinklerBed(GRID, 0.0)
    bed = WinklerBed(GRID, 1.0)
    with pytest.raises(ValueError, match="grid's shape"):
        bed.solve_indentation(np.zeros((3, 3)), 1e-3)
    with pytest.raises(ValueError, match="NaN"):
        bed.solve_load(np.full((96, 96), np.nan), 1.0)
    with pytest.raises(ValueError, match="needs a surface"):
        bed.solve_load(np.full((96, 96), NO_SURFACE), 1.0)
    with pytest.raises(ValueError, match="force_n"):
        bed.solve_load(punch(), -1.0)
    with pytest.raises(ValueError, match="touches"):
        fit_winkler(MATERIAL, GRID, punch(), [-1e-3])
