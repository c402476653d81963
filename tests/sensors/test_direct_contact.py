"""The direct solve of a small contact: the same answer as the iteration, exact where that one stops."""

import numpy as np
import pytest

from sensors.contact import direct
from sensors.contact.direct import solve_load_direct
from sensors.contact.grid import Grid
from sensors.contact.hertz import plane_strain_modulus
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.skin import SkinCompliance, SkinMaterial
from sensors.contact.solver import NO_SURFACE, ConvergenceError, solve_load

FILM = LayerMaterial(1.5e-3, 5e6, 0.45)
SKIN = SkinMaterial(FILM, 600.0)
PAD = LayerMaterial(4e-3, 0.3e6, 0.45)


def levels(kind: str, n: int = 64, dtype: type = np.float64) -> tuple:
    grid = Grid(n, 0.08)
    fine = SkinCompliance(grid, SKIN, dtype) if kind == "skin" else LayerCompliance(grid, PAD, dtype)
    return fine.coarser(), fine


def sphere(n: int = 64, radius_m: float = 0.02) -> np.ndarray:
    x, y = Grid(n, 0.08).coordinates()
    return ((x - 3e-3) ** 2 + (y + 2e-3) ** 2) / (2 * radius_m)


def rough(n: int = 64) -> np.ndarray:
    heights = np.random.default_rng(3).standard_normal((n, n)) * 2e-4
    gap = sphere(n) + heights
    gap = np.where(sphere(n) < 4e-3, gap - gap.min(), NO_SURFACE)
    return gap - gap.min()


def single_cell(n: int = 64) -> np.ndarray:
    gap = np.full((n, n), NO_SURFACE)
    gap[n // 2, n // 3] = 0.0
    return gap


def edge(n: int = 64) -> np.ndarray:
    gap = np.full((n, n), NO_SURFACE)
    gap[n // 2, 5:-5] = 0.0
    return gap


@pytest.mark.parametrize("kind", ["skin", "layer"])
@pytest.mark.parametrize("shape", [sphere, rough, single_cell, edge])
def test_direct_and_iterative_solves_agree(kind, shape):
    grids, gap = levels(kind), shape()
    exact = solve_load_direct(grids, gap, 2.0)
    iterated = solve_load(grids[-1], gap, 2.0, tolerance=1e-9, max_iterations=5000)
    assert exact.residual < 1e-12, "the answer came from the iteration"
    assert exact.indentation_m == pytest.approx(iterated.indentation_m, rel=1e-5)
    assert exact.force_n == pytest.approx(2.0, rel=1e-12)
    assert np.abs(exact.pressure - iterated.pressure).max() < 1e-3 * iterated.pressure.max()


@pytest.mark.parametrize("kind", ["skin", "layer"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_answer_is_a_contact(kind, dtype):
    """No cell pulls, loaded cells meet the surface, no other cell penetrates."""
    grids, gap = levels(kind, dtype=dtype), rough().astype(dtype)
    solution = solve_load_direct(grids, gap, 1.0)
    opening = grids[-1].displacement(solution.pressure) + gap - solution.indentation_m
    rounding = 3e-6 if dtype is np.float32 else 1e-10
    assert (solution.pressure >= 0).all()
    assert solution.pressure.dtype == dtype
    assert np.abs(opening[solution.contact]).max() < rounding * solution.indentation_m
    assert opening[np.isfinite(gap)].min() > -1.1e-5 * solution.indentation_m


@pytest.mark.parametrize("kind", ["skin", "layer"])
def test_influence_is_the_displacement_of_a_loaded_cell(kind):
    compliance = levels(kind)[-1]
    rows, columns = np.random.default_rng(0).integers(0, 64, (2, 9))
    coefficients = compliance.influence(rows, columns)
    for i, cell in enumerate(zip(rows, columns, strict=True)):
        load = np.zeros((64, 64))
        load[cell] = 1.0
        np.testing.assert_allclose(coefficients[i], compliance.displacement(load)[rows, columns], rtol=1e-9)
    np.testing.assert_array_equal(coefficients, coefficients.T)


def test_any_first_guess_leads_to_the_same_answer():
    grids, gap = levels("skin"), rough()
    cold = solve_load_direct(grids, gap, 1.0)
    for guess in (single_cell() == 0, sphere() < 4e-3, np.zeros((64, 64), bool)):
        warm = solve_load_direct(grids, gap, 1.0, initial=guess.astype(float))
        np.testing.assert_array_equal(warm.contact, cold.contact)
        np.testing.assert_allclose(warm.pressure, cold.pressure, rtol=1e-9, atol=1e-9 * cold.pressure.max())


def test_hertz_on_a_thick_layer():
    grid = Grid(128, 0.02)
    soft = LayerMaterial(0.2, 1e6, 0.3)
    x, y = grid.coordinates()
    radius, force = 0.02, 0.1
    fine = LayerCompliance(grid, soft, np.float64)
    solution = solve_load_direct((fine.coarser(), fine), (x**2 + y**2) / (2 * radius), force)
    a = (3 * force * radius / (4 * plane_strain_modulus(1e6, 0.3))) ** (1 / 3)
    assert solution.pressure.max() == pytest.approx(1.5 * force / (np.pi * a**2), rel=0.02)
    assert np.sqrt(solution.contact.sum() * grid.cell_area_m2 / np.pi) == pytest.approx(a, rel=0.03)


def test_a_large_contact_is_left_to_the_iteration(monkeypatch):
    grids, gap = levels("layer"), sphere()
    wanted = solve_load(grids[-1], gap, 2.0, tolerance=1e-6)
    monkeypatch.setattr(direct, "MOST_CELLS", 5)
    got = solve_load_direct(grids, gap, 2.0, tolerance=1e-6)
    np.testing.assert_array_equal(got.pressure, wanted.pressure)


@pytest.mark.parametrize("kind", ["skin", "layer"])
@pytest.mark.parametrize("iterated", [True, False])
def test_a_spike_on_a_flat_face_carries_a_light_load_alone(kind, iterated):
    """The face holds all but one of the cells, and nearly all of a first guess of the pressure."""
    gap = np.full((64, 64), 2e-3)
    gap[30, 20] = 0.0
    grids = levels(kind)
    solve, pad = (solve_load, grids[-1]) if iterated else (solve_load_direct, grids)
    solution = solve(pad, gap, 1e-6, tolerance=1e-3)
    assert np.argwhere(solution.contact).tolist() == [[30, 20]]


def test_a_contact_that_the_iteration_cannot_solve_comes_back(monkeypatch):
    """In single precision on 256 x 256 cells the iteration goes round in a circle under some flat objects."""

    def circle(*_, **__):
        raise ConvergenceError

    grids, gap = levels("skin"), sphere()
    wanted = solve_load_direct(grids, gap, 2.0)
    monkeypatch.setattr(direct, "MOST_CELLS", 5)
    monkeypatch.setattr(direct, "solve_load", circle)
    np.testing.assert_array_equal(solve_load_direct(grids, gap, 2.0).contact, wanted.contact)
    monkeypatch.setattr(direct, "_LAST_RESORT_CELLS", 5)
    with pytest.raises(ConvergenceError):
        solve_load_direct(grids, gap, 2.0)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("force_n", [1e-8, 1e-15, 1e-20, 1e-30])
def test_a_load_that_rounding_would_lose_is_carried(dtype, force_n):
    """Down to loads whose depth drowns in the gaps: the force is what was asked, on cells that touch first."""
    solution = solve_load_direct(levels("layer", dtype=dtype), sphere(), force_n)
    assert solution.force_n == pytest.approx(force_n, rel=1e-3)
    assert solution.contact[np.unravel_index(sphere().argmin(), (64, 64))]


def test_a_load_beyond_the_precision_is_refused():
    for force_n in (1e-300, 1e39):
        with pytest.raises(ValueError, match="beyond what float32 holds"):
            solve_load_direct(levels("layer", dtype=np.float32), sphere(), force_n)


def test_no_load_and_bad_input():
    grids, gap = levels("skin"), sphere()
    nothing = solve_load_direct(grids, gap, 0.0)
    assert nothing.force_n == 0
    assert not nothing.contact.any()
    with pytest.raises(ValueError, match="force_n must be finite and >= 0, got -1"):
        solve_load_direct(grids, gap, -1.0)
    with pytest.raises(ValueError, match="needs a surface"):
        solve_load_direct(grids, np.full((64, 64), NO_SURFACE), 1.0)
    with pytest.raises(ValueError, match="NaN"):
        solve_load_direct(grids, np.full((64, 64), np.nan), 1.0)
    with pytest.raises(ValueError, match="-inf"):
        solve_load_direct(grids, np.where(np.eye(64) > 0, -np.inf, gap), 1.0)
    for guess, message in ((np.full((64, 64), np.nan), "not finite"), (np.ones((32, 32)), "initial must have")):
        with pytest.raises(ValueError, match=message):
            solve_load_direct(grids, gap, 1.0, initial=guess)
    with pytest.raises(ValueError, match="must double"):
        solve_load_direct((grids[-1], grids[-1]), gap, 1.0)
    with pytest.raises(ValueError, match="no half"):
        Grid(33, 0.08).coarser()
