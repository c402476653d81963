"""Partial slip: Cattaneo-Mindlin, the loop of Mindlin-Deresiewicz, Coulomb's law cell by cell, paths and refusals."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.hertz import HertzSphere, plane_strain_modulus
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.solver import NO_SURFACE, ConvergenceError, solve_indentation, solve_load
from sensors.contact.tangential import HalfSpaceTangential, LayerTangential
from sensors.contact.tangential_oracle import CattaneoMindlin
from sensors.contact.tangential_projection import onto_discs, onto_discs_with_sum
from sensors.contact.tangential_report import half_space_rows, layer_rows
from sensors.contact.tangential_solver import solve_shift, solve_tangential_load

E, MU = 1e6, 0.5
PAD = LayerMaterial(2e-3, E, 0.45)


def oracle(nu: float) -> CattaneoMindlin:
    sphere = HertzSphere(10e-3, 0.1e-3, plane_strain_modulus(E, nu))
    return CattaneoMindlin(sphere, E / (2 * (1 + nu)), nu, MU)


def on_half_space(nu: float, n: int = 64, dtype=np.float64):
    """Cattaneo-Mindlin, its compliance, Hertz's pressure and the radius of each cell."""
    exact = oracle(nu)
    grid = Grid(n, 2.5 * exact.sphere.contact_radius_m)
    r = np.hypot(*grid.coordinates())
    return exact, HalfSpaceTangential(grid, E, nu, dtype), exact.sphere.pressure(r), r


def on_layer(n: int = 48, dtype=np.float64, scale: float = 1.0):
    """A layer under a sphere of 10 mm, 0.2 h deep (times `scale`): compliance and pressure."""
    grid = Grid(n, 0.02)
    x, y = grid.coordinates()
    gap = (x**2 + y**2) / 0.02
    press = solve_indentation(LayerCompliance(grid, PAD, dtype), gap, scale * 4e-4, tolerance=1e-5)
    return LayerTangential(grid, PAD, dtype), press.pressure


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("share", [0.3, 0.7, 0.95])
def test_sphere_follows_cattaneo_and_mindlin(nu, share):
    """Stick radius within 2 %, shift within 0.5 %, traction within 5 % of mu p0 (the slip edge is a cell wide)."""
    exact, compliance, pressure, r = on_half_space(nu)
    force = share * exact.limit_n
    solution = solve_tangential_load(compliance, pressure, MU, (force, 0.0))
    stuck = np.sqrt(solution.sticking.sum() * compliance.grid.cell_area_m2 / np.pi)
    assert stuck == pytest.approx(exact.stick_radius(force), rel=0.02)
    assert solution.shift_m[0] == pytest.approx(exact.shift(force), rel=5e-3)
    error = np.abs(solution.traction[0] - exact.traction(r, force)).max()
    assert error < 0.05 * MU * exact.sphere.peak_pressure_pa


def test_traction_of_cattaneo_converges_with_the_grid():
    """RMS error at nu = 0, where the closed form is exact: falls with the grid, under 0.15 % of mu p0 at 128."""
    errors = []
    for n in (32, 64, 128):
        exact, compliance, pressure, r = on_half_space(0.0, n)
        force = 0.5 * exact.limit_n
        solution = solve_tangential_load(compliance, pressure, MU, (force, 0.0))
        difference = solution.traction[0] - exact.traction(r, force)
        errors.append(np.sqrt(np.mean(difference**2)) / (MU * exact.sphere.peak_pressure_pa))
    assert errors[2] < 0.0015
    assert errors[0] > 1.6 * errors[1] > 1.6 * 1.4 * errors[2]


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_reversed_pull_follows_mindlin_and_deresiewicz(dtype):
    """Shift within 0.5 % of the peak's, traction left within 7 % of mu p0, loop closed to 0.1 %, its work 2 %."""
    exact, compliance, pressure, r = on_half_space(0.0, dtype=dtype)
    peak = 0.8 * exact.limit_n
    step, steps, work = None, {}, 0.0
    for leg, share in enumerate([1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0, 0.5, 1.0]):
        before = step
        step = solve_tangential_load(compliance, pressure, MU, (share * peak, 0.0), before=before)
        steps[leg] = step
        if before is not None:
            slipped = (step.slip - before.slip).astype(float)
            work += float((step.traction * slipped).sum()) * compliance.grid.cell_area_m2
    top = exact.shift(peak)
    for leg, share in [(0, 1.0), (1, 0.5), (2, 0.0), (3, -0.5), (4, -1.0)]:
        assert steps[leg].shift_m[0] == pytest.approx(exact.shift_after_reversal(peak, share * peak), abs=5e-3 * top)
        assert steps[8 - leg].shift_m[0] == pytest.approx(
            steps[0].shift_m[0] if leg == 0 else -exact.shift_after_reversal(peak, -share * peak), abs=5e-3 * top
        )
    assert steps[8].shift_m[0] == pytest.approx(steps[0].shift_m[0], rel=1e-3)
    error = np.abs(steps[2].traction[0] - exact.traction_after_reversal(r, peak, 0.0))
    assert error.max() < 0.07 * MU * exact.sphere.peak_pressure_pa
    assert work == pytest.approx(exact.loop_work(peak), rel=0.02)


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_loop_work_of_the_oracle_is_the_area_of_its_loop(share):
    exact = oracle(0.3)
    peak = share * exact.limit_n
    force = np.linspace(-peak, peak, 4001)
    back = np.array([exact.shift_after_reversal(peak, one) for one in force])
    assert exact.loop_work(peak) == pytest.approx(np.trapezoid(back + back[::-1], force), rel=1e-5)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("pull", [(1.5e-4, 0.0), (-1e-4, 2e-4)])
def test_every_cell_obeys_coulomb_on_the_layer(dtype, pull):
    """Inside the cone; where it sticks the surface follows to 0.2 %; where it slips, along the traction to 1 %."""
    compliance, pressure = on_layer(dtype=dtype)
    solution = solve_shift(compliance, pressure, MU, pull, tolerance=1e-6 if dtype is np.float64 else 1e-5)
    size = np.hypot(*solution.traction)
    assert (size <= solution.limit * (1 + 1e-5)).all()
    lag = np.array(pull)[:, None, None] - compliance.displacement(solution.traction)
    sticking, slipping = solution.sticking, solution.slipping
    assert sticking.sum() > 20
    assert slipping.sum() > 20
    assert np.abs(lag[:, sticking]).max() < 2e-3 * np.hypot(*pull)
    slip = solution.slip[:, slipping]
    length = np.hypot(*slip)
    aligned = (slip * solution.traction[:, slipping]).sum(axis=0) / size[slipping]
    assert (length - aligned).max() < 0.01 * length.max()


def test_a_small_pull_sticks_and_a_large_one_slides_as_a_whole():
    compliance, pressure = on_layer()
    load = pressure.sum() * compliance.grid.cell_area_m2
    gentle, gentler = (solve_shift(compliance, pressure, MU, (shift, 0.0), tolerance=1e-7) for shift in (2e-6, 1e-6))
    assert gentle.sticking.sum() > 0.6 * (pressure > 0).sum()
    assert gentle.force_n[0] == pytest.approx(2 * gentler.force_n[0], rel=0.02)
    whole = solve_shift(compliance, pressure, MU, (3e-3, 4e-3))
    assert not whole.sticking.any()
    assert np.hypot(*whole.force_n) == pytest.approx(MU * load, rel=2e-3)
    assert whole.force_n[1] / whole.force_n[0] == pytest.approx(4 / 3, rel=0.02)


def test_force_rises_with_the_shift_and_stick_shrinks():
    compliance, pressure = on_layer()
    step, forces, stuck = None, [], []
    for shift in np.linspace(2e-5, 6e-4, 30):
        step = solve_shift(compliance, pressure, MU, (shift, 0.0), before=step)
        forces.append(step.force_n[0])
        stuck.append(step.sticking.sum())
    assert (np.diff(forces) > -1e-6).all()
    assert (np.diff(stuck) <= 0).all()
    assert stuck[0] > 0 == stuck[-1]
    alone = solve_shift(compliance, pressure, MU, (2e-4, 0.0))
    assert alone.force_n[0] == pytest.approx(np.interp(2e-4, np.linspace(2e-5, 6e-4, 30), forces), rel=2e-3)


def test_load_and_shift_control_agree():
    compliance, pressure = on_layer()
    by_shift = solve_shift(compliance, pressure, MU, (5e-5, 2e-5), tolerance=1e-7)
    by_load = solve_tangential_load(compliance, pressure, MU, by_shift.force_n, tolerance=1e-7)
    assert by_load.force_n == pytest.approx(by_shift.force_n, rel=1e-9)
    assert by_load.shift_m == pytest.approx(by_shift.shift_m, rel=1e-4)


def test_a_turned_pull_has_turned_tractions():
    compliance, pressure = on_layer()
    along_x = solve_shift(compliance, pressure, MU, (6e-5, 0.0), tolerance=1e-7).traction
    along_y = solve_shift(compliance, pressure, MU, (0.0, 6e-5), tolerance=1e-7).traction
    # (x, y) -> (y, x) swaps components and transposes the grid
    assert along_y == pytest.approx(along_x[::-1].transpose(0, 2, 1), abs=1e-4 * along_x.max())


def test_pressing_harder_at_rest_adds_no_shear():
    """Cells that come into contact later start unsheared: tractions stay to 1e-3."""
    compliance, light = on_layer(scale=0.6)
    _, heavy = on_layer()
    first = solve_shift(compliance, light, MU, (4e-5, 0.0), tolerance=1e-7)
    later = solve_shift(compliance, np.maximum(heavy, light), MU, (4e-5, 0.0), before=first, tolerance=1e-7)
    assert (heavy > 0).sum() > 1.2 * (light > 0).sum()
    assert later.traction == pytest.approx(first.traction, abs=1e-3 * first.traction.max())


def test_lifting_the_indenter_lets_go():
    compliance, pressure = on_layer()
    first = solve_shift(compliance, pressure, MU, (4e-5, 0.0))
    assert not solve_shift(compliance, 0 * pressure, MU, (4e-5, 0.0), before=first).traction.any()


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("name", ["border", "single pixel", "rough", "line"])
def test_hard_contacts_carry_the_load(name, dtype):
    """Force kept to 1e-5 and no cell beyond mu p, for contacts at the border, of one cell, rough, of one row."""
    grid = Grid(48, 0.02)
    x, y = grid.coordinates()
    gap = {
        "border": np.where(x < -0.006, (x + 0.01) / 20, NO_SURFACE),
        "single pixel": np.where((np.abs(x - grid.axis()[20]) + np.abs(y - grid.axis()[30])) == 0, 0.0, NO_SURFACE),
        "rough": 5e-5 * np.random.default_rng(0).random(x.shape) + (x**2 + y**2) / 0.2,
        "line": np.where((np.abs(y) < grid.pitch_m / 2 + 1e-9) & (np.abs(x) < 8e-3), 0.0, NO_SURFACE),
    }[name]
    pressure = solve_load(LayerCompliance(grid, PAD, dtype), gap - gap.min(), 1.0).pressure
    solution = solve_tangential_load(LayerTangential(grid, PAD, dtype), pressure, MU, (0.2, -0.3))
    assert solution.force_n == pytest.approx([0.2, -0.3], abs=1e-5)
    assert (np.hypot(*solution.traction) <= solution.limit * (1 + 1e-5)).all()
    assert solution.shift_m[0] > 0 > solution.shift_m[1]


def test_projections_are_the_nearest_points():
    """No point of the discs (with that sum) is nearer: (z - P z).(other - P z) <= 0 for random others."""
    rng = np.random.default_rng(4)
    limit = rng.random(50)
    limit[:5] = 0
    z = 2 * rng.standard_normal((2, 50))
    nearest = onto_discs(z, limit)
    total = 0.6 * limit.sum() * np.array([0.8, -0.6])
    with_sum, multiplier = onto_discs_with_sum(z, limit, total, np.zeros(2))
    assert with_sum.sum(axis=1) == pytest.approx(total, rel=1e-10)
    assert with_sum == pytest.approx(onto_discs(z + multiplier[:, None], limit))
    for _ in range(50):
        other = onto_discs(2 * rng.standard_normal((2, 50)), limit)
        assert ((z - nearest) * (other - nearest)).sum() <= 1e-12
        same_sum, _ = onto_discs_with_sum(other, limit, total, np.zeros(2))
        assert ((z - with_sum) * (same_sum - with_sum)).sum() <= 1e-8


def test_a_sum_next_to_the_limit_is_still_met():
    limit = np.random.default_rng(5).random(300)
    total = (1 - 1e-6) * limit.sum() * np.array([1.0, 0.0])
    out, _ = onto_discs_with_sum(np.random.default_rng(6).standard_normal((2, 300)), limit, total, np.zeros(2))
    assert out.sum(axis=1) == pytest.approx(total, rel=1e-9, abs=1e-9)


def test_without_friction_or_pull_there_is_no_traction():
    compliance, pressure = on_layer()
    assert not solve_shift(compliance, pressure, 0.0, (1e-4, 0.0)).traction.any()
    assert not solve_shift(compliance, pressure, MU, (0.0, 0.0)).traction.any()
    assert not solve_tangential_load(compliance, pressure, MU, (0.0, 0.0)).traction.any()


def test_impossible_pulls_are_refused():
    compliance, pressure = on_layer()
    most = MU * pressure.sum() * compliance.grid.cell_area_m2
    with pytest.raises(ValueError, match="slides"):
        solve_tangential_load(compliance, pressure, MU, (most, 0.0))
    with pytest.raises(ValueError, match="slides"):
        solve_tangential_load(compliance, 0 * pressure, MU, (1e-3, 0.0))
    with pytest.raises(ValueError, match="two finite numbers"):
        solve_shift(compliance, pressure, MU, (np.nan, 0.0))
    with pytest.raises(ValueError, match="two finite numbers"):
        solve_shift(compliance, pressure, MU, 1e-5)
    with pytest.raises(ValueError, match="nowhere negative"):
        solve_shift(compliance, -pressure, MU, (1e-5, 0.0))
    with pytest.raises(ValueError, match="grid's shape"):
        solve_shift(compliance, pressure[:3], MU, (1e-5, 0.0))
    with pytest.raises(ValueError, match="friction"):
        solve_shift(compliance, pressure, -0.1, (1e-5, 0.0))
    other = solve_shift(LayerTangential(Grid(8, 0.02), PAD), np.ones((8, 8)), MU, (1e-5, 0.0))
    with pytest.raises(ValueError, match="another grid"):
        solve_shift(compliance, pressure, MU, (1e-5, 0.0), before=other)


def test_an_unreached_tolerance_is_an_error():
    compliance, pressure = on_layer()
    with pytest.raises(ConvergenceError, match="residual"):
        solve_shift(compliance, pressure, MU, (5e-5, 0.0), max_iterations=2)


def test_the_report_shows_every_nu_within_its_errors_and_the_cost_of_the_layer():
    rows = list(half_space_rows(32))
    assert len(rows) == 10
    for row in rows[1:]:
        _, _, stick, shift, traction, _ = map(float, row.split())
        assert abs(stick) < 5
        assert abs(shift) < 1
        assert traction < 12
    layers = list(layer_rows(24, np.float32))
    tips = [float(line.split("tip the top by ")[1].split(" %")[0]) for line in layers]
    assert all(0 < tip < 50 for tip in tips)
