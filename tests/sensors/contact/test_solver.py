"""The contact solver: complementarity on hard cases, agreement with a dense solver, refusals."""

import numpy as np
import pytest
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

from sensors.contact.grid import Grid
from sensors.contact.half_space import HalfSpaceCompliance
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.skin import SkinCompliance, SkinMaterial
from sensors.contact.solver import NO_SURFACE, ConvergenceError, solve_indentation, solve_load

FILM = LayerMaterial(1.5e-3, 5e6, 0.45)


def skin(n=64, dtype=np.float64):
    return SkinCompliance(Grid(n, 0.08), SkinMaterial(FILM, 600.0), dtype)


def pad(n=64, dtype=np.float64, nu=0.45):
    return LayerCompliance(Grid(n, 0.08), LayerMaterial(4e-3, 2e5, nu), dtype)


def surfaces(grid: Grid) -> dict[str, np.ndarray]:
    x, y = grid.coordinates()
    rough = 1e-4 * np.random.default_rng(0).random(x.shape)
    out = {
        "sphere": 0.012 - np.sqrt(np.maximum(0.012**2 - x**2 - y**2, 0)),
        "line edge": np.where((np.abs(x) < 0.03) & (np.abs(y) < grid.pitch_m), 0.0, NO_SURFACE),
        "rough": np.where(np.maximum(np.abs(x), np.abs(y)) < 0.03, rough, NO_SURFACE),
        "single pixel": np.where((np.abs(x - grid.axis()[20]) + np.abs(y - grid.axis()[30])) == 0, 0.0, NO_SURFACE),
        "flat punch": np.where(np.hypot(x, y) < 0.02, 0.0, NO_SURFACE),
        "tilted at the border": np.where(x < -0.03, (x + 0.04) / 10, NO_SURFACE),
        "a / h = 5": np.where(np.hypot(x, y) < 0.02, (x**2 + y**2) / 8, NO_SURFACE),
        "knurled": (x**2 + y**2) / 0.04 + 1e-4 * np.cos(3000 * x) * np.cos(3000 * y),
    }
    return {name: gap - gap.min() for name, gap in out.items()}


@pytest.mark.parametrize("name", list(surfaces(Grid(64, 0.08))))
@pytest.mark.parametrize("make", [skin, pad])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_hard_surfaces_meet_complementarity(name, make, dtype):
    compliance = make(dtype=dtype)
    gap = surfaces(compliance.grid)[name]
    solution = solve_load(compliance, gap, 3.0)
    assert solution.force_n == pytest.approx(3.0, rel=1e-5)
    assert solution.residual <= 1e-4
    assert (solution.pressure >= 0).all()
    # open gaps stay open, closed ones are closed
    opening = compliance.displacement(solution.pressure) + gap.astype(dtype) - solution.indentation_m
    scale = abs(solution.indentation_m)
    there = np.isfinite(gap)
    assert opening[there].min() > -2e-3 * scale - 1e-7
    work = np.abs(opening[there] * solution.pressure[there]).sum()
    assert work <= 2e-4 * scale * solution.pressure.sum()


@pytest.mark.parametrize("make", [skin, pad])
def test_load_and_indentation_control_agree(make):
    compliance = make()
    gap = surfaces(compliance.grid)["sphere"]
    by_load = solve_load(compliance, gap, 2.0, tolerance=1e-8)
    by_depth = solve_indentation(compliance, gap, by_load.indentation_m, tolerance=1e-8)
    assert by_depth.force_n == pytest.approx(2.0, rel=1e-4)
    assert by_depth.pressure == pytest.approx(by_load.pressure, abs=1e-3 * by_load.pressure.max())


def test_it_solves_the_quadratic_programme():
    """min 1/2 p C p - (d - gap) p over p >= 0, by a dense non-negative least squares."""
    grid = Grid(12, 3e-3)
    compliance = HalfSpaceCompliance(grid, 1e6)
    x, y = grid.coordinates()
    gap = (x**2 + 2 * y**2) / 0.02 + 2e-6 * np.random.default_rng(3).random(x.shape)
    unit = np.eye(144).reshape(144, 12, 12)
    matrix = np.stack([compliance.displacement(one).ravel() for one in unit])
    matrix = (matrix + matrix.T) / 2
    factor = cholesky(matrix, lower=True)
    right = solve_triangular(factor, (4e-5 - gap).ravel(), lower=True)
    reference, _ = nnls(factor.T, right, maxiter=2000)
    solution = solve_indentation(compliance, gap, 4e-5, tolerance=1e-10)
    assert solution.pressure.ravel() == pytest.approx(reference, abs=1e-6 * reference.max())


def test_deeper_is_heavier():
    compliance = pad(32)
    gap = surfaces(compliance.grid)["sphere"]
    forces = [solve_indentation(compliance, gap, depth).force_n for depth in np.linspace(0, 1.2e-3, 7)]
    assert forces[0] == 0
    assert (np.diff(forces) > 0).all()


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_warm_path_of_thirty_steps_ends_where_a_cold_solve_does(dtype):
    compliance = pad(dtype=dtype)
    gap = surfaces(compliance.grid)["knurled"]
    pressure, steps = None, 0
    for depth in np.linspace(4e-5, 1.2e-3, 30):
        warm = solve_indentation(compliance, gap, depth, initial=pressure)
        pressure, steps = warm.pressure, max(steps, warm.iterations)
    cold = solve_indentation(compliance, gap, 1.2e-3)
    assert warm.force_n == pytest.approx(cold.force_n, rel=1e-3)
    assert steps < 80


@pytest.mark.parametrize("depth", [0.0, -1e-3])
def test_no_depth_no_pressure(depth):
    compliance = skin(32)
    solution = solve_indentation(compliance, surfaces(compliance.grid)["sphere"], depth)
    assert solution.force_n == 0
    assert not solution.contact.any()


def test_no_load_no_pressure():
    compliance = skin(32)
    assert not solve_load(compliance, surfaces(compliance.grid)["sphere"], 0.0).contact.any()


def test_contact_on_an_incompressible_thin_pad():
    compliance = LayerCompliance(Grid(64, 0.04), LayerMaterial(2e-3, 2e5, 0.5))
    x, y = compliance.grid.coordinates()
    gap = np.where(np.hypot(x, y) < 0.01, 0.0, NO_SURFACE)
    solution = solve_indentation(compliance, gap, 1e-4)
    # squeezed fluid: pressure falls from the centre to the rim, apart from the singular edge
    row = solution.pressure[32, 24:40]
    assert solution.residual <= 1e-4
    assert row[7] > row[2]


def test_float32_agrees_with_float64():
    for make in (skin, pad):
        gap = surfaces(Grid(64, 0.08))["sphere"]
        single, double = (solve_load(make(dtype=dtype), gap, 4.0) for dtype in (np.float32, np.float64))
        assert single.indentation_m == pytest.approx(double.indentation_m, rel=1e-4)


def test_a_shifted_surface_shifts_the_pressure():
    compliance = pad()
    x, y = compliance.grid.coordinates()
    step = 5 * compliance.grid.pitch_m

    def pressure(at: float) -> np.ndarray:
        return solve_load(compliance, ((x - at) ** 2 + y**2) / 0.02, 2.0, tolerance=1e-9).pressure

    there = pressure(step)
    assert np.roll(pressure(0.0), 5, axis=1) == pytest.approx(there, abs=1e-4 * there.max())


@pytest.mark.parametrize(
    ("gap", "load", "message"),
    [
        (np.full((16, 16), NO_SURFACE), 1.0, "needs a surface"),
        (np.full((16, 16), np.nan), 1.0, "NaN"),
        (np.where(np.eye(16) > 0, -np.inf, 0.0), 1.0, "NaN or -inf"),
        (np.zeros((8, 16)), 1.0, "grid's shape"),
        (np.zeros((16, 16)), -1.0, "force_n"),
        (np.zeros((16, 16)), np.nan, "force_n"),
    ],
)
def test_impossible_presses_are_refused(gap, load, message):
    with pytest.raises(ValueError, match=message):
        solve_load(skin(16), gap, load)


def test_a_gap_without_end_is_refused_at_every_depth():
    gap = np.where(np.eye(16) > 0, -np.inf, 0.0)
    for depth in (-1e-3, 0.0, 1e-3):
        with pytest.raises(ValueError, match="NaN or -inf"):
            solve_indentation(skin(16), gap, depth)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_only_the_shape_of_a_first_guess_counts(dtype):
    """The same guess at any scale that a float holds leads to the same answer, under depth and under load."""
    compliance = pad(dtype=dtype)
    gap = surfaces(compliance.grid)["sphere"]
    deep, loaded = solve_indentation(compliance, gap, 1e-4), solve_load(compliance, gap, 1.0)
    shape = deep.pressure / deep.pressure.max()
    for scale in (1e-36, 1e-30, 1e-8, 1e8, 1e20, 1e33):
        guess = shape * dtype(scale)
        assert solve_indentation(compliance, gap, 1e-4, initial=guess).force_n == pytest.approx(deep.force_n, rel=1e-4)
        again = solve_load(compliance, gap, 1.0, initial=guess)
        assert again.indentation_m == pytest.approx(loaded.indentation_m, rel=1e-4)


@pytest.mark.parametrize(
    ("guess", "message"),
    [
        (np.full((16, 16), np.nan), "not finite"),
        (np.full((16, 16), np.inf), "not finite"),
        (np.ones((8, 8)), r"initial must have the grid's shape \(16, 16\), got \(8, 8\)"),
    ],
)
def test_a_first_guess_that_is_none_is_refused(guess, message):
    compliance, gap = skin(16), np.zeros((16, 16))
    for solve, value in ((solve_load, 1.0), (solve_indentation, 1e-4)):
        with pytest.raises(ValueError, match=message):
            solve(compliance, gap, value, initial=guess)


def test_an_unreached_tolerance_is_an_error():
    compliance = skin(32)
    with pytest.raises(ConvergenceError, match="residual"):
        solve_load(compliance, surfaces(compliance.grid)["rough"], 2.0, max_iterations=1)
