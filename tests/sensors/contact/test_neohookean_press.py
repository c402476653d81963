"""Pressed hyperelastic pads: contact laws, the small-strain limit, symmetry, paths and refusals."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.neohookean import GridSurface, NeoHookeanPad, SweptSurface, graded_pad
from sensors.contact.neohookean.contact import TopContact
from sensors.contact.solver import ConvergenceError, solve_indentation

H, E = 2e-3, 3e5
SPHERE = SweptSurface(2 * H)


def make(cells=8, layers=4, nu=0.45, quarter=True, core=1.2, side=6.0, modulus=E):
    mesh = graded_pad(side * H, H, (core * H, core * H), cells, layers, quarter=quarter)
    return NeoHookeanPad(mesh, LayerMaterial(H, modulus, nu))


def last(solutions):
    return list(solutions)[-1]


@pytest.fixture(scope="module")
def pressed():
    return last(make().press_depths(SPHERE, [0.1 * H, 0.25 * H]))


def test_contact_force_is_the_slope_of_its_energy_and_the_tangent_that_of_the_force():
    pad = make(4, 2, quarter=False)
    rng = np.random.default_rng(0)
    top = len(pad.mesh.top)
    contact = TopContact(pad.mesh, SweptSurface(2 * H, H), 1e-3 * rng.random(top), np.full(top, 50.0))
    u, depth = 1e-5 * rng.standard_normal(pad.mesh.nodes.shape), 0.2 * H
    v, dv, step = rng.standard_normal(u.shape), 0.7, 1e-9
    force, total = contact.force(u, depth)
    ahead, behind = (contact.energy(u + s * step * v, depth + s * step * dv) for s in (1, -1))
    assert (force * v[pad.mesh.top]).sum() + total * dv == pytest.approx((ahead - behind) / (2 * step), rel=1e-6)
    place = np.arange(u.size)
    change = contact.hessian(u, depth, place) @ np.append(v.ravel(), dv)
    forces = [contact.force(u + s * step * v, depth + s * step * dv) for s in (1, -1)]
    assert change[-1] == pytest.approx((forces[0][1] - forces[1][1]) / (2 * step), rel=1e-5)
    by_node = change[:-1].reshape(-1, 3)[pad.mesh.top]
    assert by_node == pytest.approx((forces[0][0] - forces[1][0]) / (2 * step), abs=1e-5 * np.abs(by_node).max())


def test_contact_is_unilateral_to_the_stated_tolerance(pressed):
    assert (pressed.normal_load >= 0).all()
    assert pressed.penetration_m <= 1e-5 * H
    assert np.abs(pressed.gap[pressed.normal_load > 0]).max() <= 1e-5 * H
    assert 0 < (pressed.normal_load > 0).sum() < len(pressed.normal_load)


def test_the_base_carries_the_load(pressed):
    assert pressed.base_reaction_n == pytest.approx(pressed.force_n, rel=1e-6)


def test_a_quarter_is_the_whole_pad(pressed):
    whole = last(make(quarter=False).press_depths(SPHERE, [0.25 * H]))
    assert whole.force_n == pytest.approx(pressed.force_n, rel=1e-4)
    load = whole.normal_load.reshape(whole.mesh.points[:2])
    assert load == pytest.approx(load[::-1], abs=1e-5 * load.max())
    assert load == pytest.approx(load.T, abs=1e-5 * load.max())
    grid = Grid(21, 6 * H)
    assert whole.depression(grid) == pytest.approx(pressed.depression(grid), abs=2e-3 * H)


def test_depth_and_load_control_agree(pressed):
    by_load = last(make().press_loads(SPHERE, [0.4 * pressed.force_n, pressed.force_n]))
    assert by_load.force_n == pytest.approx(pressed.force_n, rel=1e-6)
    assert by_load.indentation_m == pytest.approx(pressed.indentation_m, rel=1e-4)


def test_a_warm_path_ends_where_a_cold_press_does(pressed):
    warm = last(make().press_depths(SPHERE, np.linspace(0.05, 0.25, 5) * H))
    assert warm.force_n == pytest.approx(pressed.force_n, rel=1e-4)
    unloaded = list(make().press_depths(SPHERE, [0.25 * H, 0.1 * H, 0.0]))
    loaded = next(make().press_depths(SPHERE, [0.1 * H]))
    assert unloaded[1].force_n == pytest.approx(loaded.force_n, rel=1e-4)
    assert unloaded[2].force_n == pytest.approx(0.0, abs=1e-6 * E * H**2)


def test_force_scales_with_the_modulus(pressed):
    stiff = last(make(modulus=7 * E).press_depths(SPHERE, [0.25 * H]))
    assert stiff.force_n == pytest.approx(7 * pressed.force_n, rel=1e-4)


@pytest.mark.parametrize("nu", [0.41, 0.45])
def test_small_strains_are_the_layers(nu):
    """A shallow large sphere, d = 0.02 h: force within 2 % of the linear bonded layer."""
    surface, depth = SweptSurface(8 * H), 0.02 * H
    pad = make(15, 7, nu=nu, core=0.6)
    solution = last(pad.press_depths(surface, [depth]))
    grid = Grid(192, 6 * H)
    layer = LayerCompliance(grid, pad.material)
    linear = solve_indentation(layer, surface.jet(*grid.coordinates()).gap, depth, tolerance=1e-6)
    assert solution.force_n == pytest.approx(linear.force_n, rel=0.02)


def test_volume_is_kept_without_locking():
    """nu = 0.4999 on a coarse mesh: volume kept to 1e-3, force within 4 % of the incompressible linear layer."""
    surface, depth = SweptSurface(8 * H), 0.03 * H
    pad = make(12, 6, nu=0.4999, core=0.7)
    solution = last(pad.press_depths(surface, [depth]))
    assert pad.assembly.dilatation(solution.displacement) == pytest.approx(1.0, abs=1e-3)
    grid = Grid(128, 6 * H)
    layer = LayerCompliance(grid, LayerMaterial(H, E, 0.4999))
    linear = solve_indentation(layer, surface.jet(*grid.coordinates()).gap, depth, tolerance=1e-6)
    assert solution.force_n == pytest.approx(linear.force_n, rel=0.04)


@pytest.mark.slow
def test_force_converges_with_the_mesh():
    """Sphere, d = 0.05 to 0.25 h: first order, as nodes enter the contact one by one (errors against 18 cells)."""
    depths = np.linspace(0.05, 0.25, 5) * H
    coarse, medium, fine = (
        np.array([press.force_n for press in make(cells, layers, core=1.6).press_depths(SPHERE, depths)])
        for cells, layers in [(6, 3), (12, 6), (18, 9)]
    )
    errors = [np.sqrt(np.mean((forces / fine - 1) ** 2)) for forces in (coarse, medium)]
    # order 1 gives (1/6 - 1/18) / (1/12 - 1/18) = 4
    assert errors[0] > 3 * errors[1]
    assert errors[1] < 0.02


def test_a_tilted_face_pushes_along_its_normal():
    """No friction: a plane of slope s loads the base with a horizontal force of s times the vertical one."""
    grid, slope = Grid(40, 10 * H), 0.05
    x, _ = grid.coordinates()
    surface = GridSurface(grid, slope * (x + 3 * H), 10 * H)
    solution = last(make(4, 3, quarter=False, core=3.0).press_depths(surface, [0.2 * H]))
    reaction = solution.internal_force[solution.mesh.base].sum(axis=0)
    assert reaction[0] == pytest.approx(-slope * reaction[2], rel=0.02)
    assert reaction[1] == pytest.approx(0, abs=1e-6 * reaction[2])


def test_a_grid_of_a_sphere_presses_like_the_sphere(pressed):
    grid = Grid(96, 6 * H)
    surface = GridSurface(grid, SPHERE.jet(*grid.coordinates()).gap, 10 * H)
    assert surface.quarter
    solution = last(make().press_depths(surface, [0.1 * H, 0.25 * H]))
    assert solution.force_n == pytest.approx(pressed.force_n, rel=0.01)


def test_no_load_and_no_depth_are_at_rest():
    assert not next(make(3, 2).press_loads(SPHERE, [0.0])).displacement.any()
    for depth in (0.0, -1e-3):
        assert next(make(3, 2).press_depths(SPHERE, [depth])).force_n == 0


def test_a_load_that_no_depth_reaches_is_an_error():
    with pytest.raises(ConvergenceError, match="no equilibrium on the way"):
        last(make(4, 2).press_loads(SPHERE, [1e4 * E * H**2]))


def test_impossible_presses_are_refused():
    pad = make(3, 2)
    tilted = GridSurface(Grid(8, 6 * H), np.tile(np.arange(8.0), (8, 1)), 10.0)
    with pytest.raises(ValueError, match="quarter mesh"):
        last(pad.press_depths(tilted, [1e-4]))
    with pytest.raises(ValueError, match="thickness"):
        last(pad.press_depths(SPHERE, [H]))
    with pytest.raises(ValueError, match="load must be finite"):
        last(pad.press_loads(SPHERE, [-1.0]))
    with pytest.raises(ValueError, match="thick"):
        NeoHookeanPad(pad.mesh, LayerMaterial(2 * H, E, 0.45))
