"""In-plane compliance: state-space solution, limits, Cerruti's far field, symmetry, the bound on its eigenvalues."""

import numpy as np
import pytest
from scipy.linalg import expm

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerMaterial
from sensors.contact.tangential import HalfSpaceTangential, LayerTangential, coupling_symbol, in_plane_symbols

MATERIAL = LayerMaterial(2e-3, 1e6, 0.45)


def state_space(k: float, material: LayerMaterial) -> tuple[float, float, float]:
    """Shift per traction along and across a plane wave and per pressure, by matrix exponentials; nu < 1/2."""
    nu, h = material.poisson_ratio, material.thickness_m
    kh = k * h
    lam = 2 * nu / (1 - 2 * nu)
    p_wave = lam + 2
    # (U, W, T, S) as in the layer's tests: u_x = U sin kx, tau_xz = T sin kx, stresses over G, lengths over h
    system = np.array(
        [
            [0, kh, 1, 0],
            [-lam / p_wave * kh, 0, 0, 1 / p_wave],
            [(p_wave - lam**2 / p_wave) * kh**2, 0, 0, lam / p_wave * kh],
            [0, 0, -kh, 0],
        ]
    )
    through = expm(system)
    sheared = np.linalg.solve(through[2:, 2:], np.array([1.0, 0.0]))  # T = 1, S = 0 on top
    pressed = np.linalg.solve(through[2:, 2:], np.array([0.0, -1.0]))
    across = expm(np.array([[0, 1], [kh**2, 0]]))  # (V, T) of the anti-plane wave
    shear = material.youngs_modulus_pa / (2 * (1 + nu))
    unit = h / shear
    return through[0, 2:] @ sheared * unit, across[0, 1] / across[1, 1] * unit, through[0, 2:] @ pressed * unit


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.49])
@pytest.mark.parametrize("kh", [1e-3, 0.1, 0.5, 1.0, 2.0, 5.0])
def test_symbols_equal_the_state_space_solution_to_1e_8(nu, kh):
    material = LayerMaterial(2e-3, 1e6, nu)
    k = kh / material.thickness_m
    along, across = in_plane_symbols(material, np.array([k]))
    coupling = coupling_symbol(material, np.array([k]))[0]
    exact = state_space(k, material)
    assert (along[0], across[0]) == pytest.approx(exact[:2], rel=1e-8)
    assert coupling == pytest.approx(exact[2], rel=1e-8, abs=1e-9 * along[0])


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_long_waves_shear_the_layer_and_short_ones_see_a_half_space(nu):
    material = LayerMaterial(2e-3, 1e6, nu)
    shear = 1e6 / (2 * (1 + nu))
    k = np.array([0.0, 1e-6, 1e6])
    along, across = in_plane_symbols(material, k)
    assert along == pytest.approx([2e-3 / shear, 2e-3 / shear, 2 / (material.modulus_pa * 1e6)], rel=1e-8)
    assert across == pytest.approx([2e-3 / shear, 2e-3 / shear, 1 / (shear * 1e6)], rel=1e-8)


def test_symbols_are_continuous_where_the_form_changes():
    k = 20.0 / MATERIAL.thickness_m * np.array([1 - 1e-9, 1 + 1e-9])
    for symbol in (*in_plane_symbols(MATERIAL, k), coupling_symbol(MATERIAL, k)):
        assert symbol[0] == pytest.approx(symbol[1], rel=1e-8)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_far_from_a_loaded_cell_the_half_space_shifts_as_cerruti_says(nu):
    """u = Q / (2 pi G) [(1 - nu) / r + nu x x / r^3], to 1e-3 ten cells away."""
    grid, modulus = Grid(32, 0.032), 1e6
    compliance = HalfSpaceTangential(grid, modulus, nu)
    traction = np.zeros((2, 32, 32))
    traction[0, 4, 6] = 1.0
    shift = compliance.displacement(traction)
    offset = np.array([14.0, 12.0]) * grid.pitch_m  # x, y
    r = np.hypot(*offset)
    scale = grid.cell_area_m2 * (1 + nu) / (np.pi * modulus)
    expected = scale * np.array([(1 - nu) / r + nu * offset[0] ** 2 / r**3, nu * offset[0] * offset[1] / r**3])
    assert shift[:, 16, 20] == pytest.approx(expected, rel=1e-3, abs=1e-3 * expected[0])


def test_a_thick_layer_shifts_like_the_half_space_up_to_a_constant():
    """Load-free differences of the shift near the load agree within 2 %; the pad 16 sides wide keeps images away."""
    grid, modulus, nu = Grid(256, 0.256), 1e6, 0.3
    layer = LayerTangential(grid, LayerMaterial(0.05, modulus, nu))
    half_space = HalfSpaceTangential(grid, modulus, nu)
    x, y = grid.coordinates()
    patch = (np.hypot(x, y) < 4e-3).astype(float)
    near = np.s_[:, 120:136, 120:136]
    for direction in ([1.0, 0.0], [0.6, 0.8]):
        traction = np.array(direction)[:, None, None] * patch
        one, other = layer.displacement(traction)[near], half_space.displacement(traction)[near]
        one, other = one - one[:, :1, :1], other - other[:, :1, :1]
        assert np.abs(one - other).max() < 0.02 * np.abs(other).max()


def test_a_uniform_shear_of_a_wide_patch_is_the_layers_own():
    """Ten thicknesses from its edge a patch shifts by h / G per traction, to 1e-3."""
    grid, material = Grid(128, 0.064), LayerMaterial(1e-3, 1e6, 0.45)
    x, y = grid.coordinates()
    wide = np.maximum(np.abs(x), np.abs(y)) < 0.02
    shift = LayerTangential(grid, material).displacement(np.stack([wide * 1.0, wide * -2.0]))
    shear = 1e6 / (2 * 1.45)
    middle = np.hypot(x, y) < 0.008
    assert shift[0][middle] == pytest.approx(1e-3 / shear, rel=1e-3)
    assert shift[1][middle] == pytest.approx(-2e-3 / shear, rel=1e-3)


@pytest.mark.parametrize(
    "compliance",
    [LayerTangential(Grid(10, 0.01), MATERIAL), HalfSpaceTangential(Grid(10, 0.01), 1e6, 0.3)],
    ids=["layer", "half-space"],
)
def test_it_is_symmetric_positive_and_its_bound_holds_within_a_half(compliance):
    unit = np.eye(200).reshape(200, 2, 10, 10)
    matrix = np.stack([compliance.displacement(one).ravel() for one in unit])
    values = np.linalg.eigvalsh(matrix)
    assert matrix == pytest.approx(matrix.T, abs=1e-12 * values[-1])
    assert values[0] > 0
    bound = compliance.window(slice(0, 10), slice(0, 10)).largest(np.ones((10, 10), bool))
    assert values[-1] <= bound * (1 + 1e-12)
    assert bound < 1.5 * values[-1]


def test_a_window_is_the_same_operator():
    grid = Grid(48, 0.02)
    pad = LayerTangential(grid, MATERIAL)
    rows, columns = slice(7, 29), slice(20, 45)
    traction = np.zeros((2, 48, 48))
    traction[:, rows, columns] = np.random.default_rng(0).standard_normal((2, 22, 25))
    whole = pad.displacement(traction)[:, rows, columns]
    windowed = pad.window(rows, columns).displacement(traction[:, rows, columns])
    assert windowed == pytest.approx(whole, rel=1e-9, abs=1e-12 * np.abs(whole).max())


def test_a_press_pulls_a_soft_solid_in_and_squeezes_an_incompressible_one_out():
    """In-plane motion under a patch of pressure: towards it at nu = 0, away from it at nu = 1/2."""
    grid = Grid(64, 0.03)
    x, y = grid.coordinates()
    pressure = 1e3 * (np.hypot(x, y) < 3e-3)
    rim = (np.hypot(x, y) > 3.5e-3) & (np.hypot(x, y) < 5e-3)
    for nu, sign in [(0.0, -1), (0.5, 1)]:
        u = LayerTangential(grid, LayerMaterial(2e-3, 1e6, nu)).under_pressure(pressure)
        assert (sign * (u[0] * x + u[1] * y)[rim] > 0).all()
        assert u[0] == pytest.approx(-u[0][:, ::-1], abs=1e-9 * np.abs(u).max())
        assert u[0] == pytest.approx(u[1].T, abs=1e-9 * np.abs(u).max())


def test_shear_does_the_work_on_a_press_that_the_press_does_on_shear():
    """Reciprocity (Betti): sum q.u(p) = sum p w(q) for any p and q, to 1e-9."""
    pad, rng = LayerTangential(Grid(24, 0.01), MATERIAL), np.random.default_rng(3)
    pressure, traction = rng.random((24, 24)), rng.standard_normal((2, 24, 24))
    work = (traction * pad.under_pressure(pressure)).sum()
    assert work == pytest.approx((pressure * pad.sinking(traction)).sum(), rel=1e-9)
    assert abs(work) > 0


def test_a_cover_gives_locally_and_in_series_and_the_face_below_it_does_not():
    grid, material = Grid(24, 12e-3), LayerMaterial(2e-3, 1e5, 0.45)
    bare, covered = LayerTangential(grid, material), LayerTangential(grid, material, cover_m_per_pa=3e-9)
    traction = np.random.default_rng(0).standard_normal((2, 24, 24)) * 1e3
    assert covered.displacement(traction) - bare.displacement(traction) == pytest.approx(3e-9 * traction, abs=1e-15)
    assert covered.face(traction) == pytest.approx(bare.displacement(traction), abs=1e-15)
    with pytest.raises(ValueError, match="cover_m_per_pa"):
        LayerTangential(grid, material, cover_m_per_pa=-1.0)
