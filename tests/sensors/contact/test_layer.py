"""The bonded layer against its state-space solution, its limits and thin-pad oracles."""

import numpy as np
import pytest
from scipy.linalg import expm

from sensors.contact.grid import Grid
from sensors.contact.hertz import HertzSphere
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.solver import solve_indentation

POISSON = (0.0, 0.3, 0.45, 0.499, 0.5)


def state_space(k: float, material: LayerMaterial) -> tuple[float, float]:
    """Top displacement and base stress per top pressure, by a matrix exponential through the thickness.

    Plane strain in x, z with u_x = U sin kx, u_z = W cos kx, tau_xz = T sin kx, sigma_zz = S cos kx; lengths in units
    of the thickness, stresses in units of the shear modulus. Needs nu < 1/2.
    """
    nu, h = material.poisson_ratio, material.thickness_m
    kh = k * h
    lam = 2 * nu / (1 - 2 * nu)  # Lame's first parameter over the shear modulus
    p_wave = lam + 2
    # d/dz of (U, W, T, S)
    system = np.array(
        [
            [0, kh, 1, 0],
            [-lam / p_wave * kh, 0, 0, 1 / p_wave],
            [(p_wave - lam**2 / p_wave) * kh**2, 0, 0, lam / p_wave * kh],
            [0, 0, -kh, 0],
        ]
    )
    through = expm(system)
    # base: U = W = 0, unknown (T, S); top: T = 0, S = -1
    base = np.linalg.solve(through[2:, 2:], np.array([0.0, -1.0]))
    top_w = through[1, 2:] @ base
    shear = material.youngs_modulus_pa / (2 * (1 + nu))
    return -top_w * h / shear, -base[1]


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.49])
@pytest.mark.parametrize("kh", [1e-3, 0.1, 0.5, 1.0, 2.0, 5.0])
def test_symbols_equal_the_state_space_solution(nu, kh):
    material = LayerMaterial(2e-3, 1e6, nu)
    k = kh / material.thickness_m
    compliance, base = state_space(k, material)
    assert material.surface_compliance(np.array([k]))[0] == pytest.approx(compliance, rel=1e-8)
    assert material.base_transfer(np.array([k]))[0] == pytest.approx(base, rel=1e-8)


@pytest.mark.parametrize("nu", POISSON)
def test_short_waves_see_a_half_space(nu):
    material = LayerMaterial(2e-3, 1e6, nu)
    k = np.array([1e5, 1e6, 1e8])
    assert material.surface_compliance(k) == pytest.approx(2 / (material.modulus_pa * k), rel=1e-12)
    assert np.all(material.base_transfer(k) < 1e-60)


@pytest.mark.parametrize("nu", POISSON)
def test_a_uniform_load_squeezes_the_layer_and_passes_to_the_base(nu):
    material = LayerMaterial(2e-3, 1e6, nu)
    squeeze = 2e-3 * (1 - 2 * nu) * (1 + nu) / ((1 - nu) * 1e6)
    assert material.surface_compliance(np.array([0.0]))[0] == pytest.approx(squeeze, rel=1e-12, abs=1e-25)
    assert material.base_transfer(np.array([0.0]))[0] == pytest.approx(1.0, rel=1e-14)


def test_incompressible_long_waves_do_not_cancel():
    material = LayerMaterial(2e-3, 1e6, 0.5)
    k = np.array([1e-4, 1e-2, 1.0])
    limit = 4 / 3 * k**2 * material.thickness_m**3 / material.modulus_pa
    assert material.surface_compliance(k) == pytest.approx(limit, rel=1e-4)


def test_symbols_are_continuous_where_the_form_changes():
    material = LayerMaterial(1e-3, 1e6, 0.45)
    k = 20.0 / material.thickness_m * np.array([1 - 1e-9, 1 + 1e-9])
    compliance = material.surface_compliance(k)
    assert compliance[0] == pytest.approx(compliance[1], rel=1e-8)
    base = material.base_transfer(k)
    assert base[0] == pytest.approx(base[1], rel=1e-6)


def test_base_pressure_at_two_thicknesses_is_the_layers_and_not_the_half_spaces():
    material = LayerMaterial(1e-3, 1e6, 0.5)
    base = material.base_transfer(np.array([2 / material.thickness_m]))[0]
    assert base == pytest.approx(0.607, abs=1e-3)
    assert base > 1.4 * (1 + 2) * np.exp(-2)


@pytest.mark.parametrize("x", [0.2, 0.4])
def test_bonded_sphere_follows_the_finite_thickness_series(x):
    """Garcia, Garcia, Biophys. J. 114 (2018) 2923: force over Hertz for nu = 1/2, x = sqrt(R d) / h."""
    radius, thickness = 10e-3, 2e-3
    material = LayerMaterial(thickness, 1e6, 0.5)
    depth = (x * thickness) ** 2 / radius
    grid = Grid(256, 8 * thickness)
    cx, cy = grid.coordinates()
    solution = solve_indentation(LayerCompliance(grid, material), (cx**2 + cy**2) / (2 * radius), depth, tolerance=1e-7)
    series = 1 + 1.133 * x + 1.497 * x**2 + 1.469 * x**3 + 0.755 * x**4
    hertz = HertzSphere(radius, depth, material.modulus_pa).force_n
    assert solution.force_n / hertz == pytest.approx(series, rel=5e-3)


def test_a_thin_pad_is_not_a_half_space():
    """At sqrt(R d) / h = 0.4 Hertz is off by 80 %: a layer must not be tested against it."""
    x = 0.4
    series = 1 + 1.133 * x + 1.497 * x**2 + 1.469 * x**3 + 0.755 * x**4
    assert series > 1.8


def test_base_pressure_keeps_the_load():
    grid = Grid(64, 0.08)
    pad = LayerCompliance(grid, LayerMaterial(4e-3, 2e5, 0.45))
    x, y = grid.coordinates()
    pressure = np.exp(-((x / 0.01) ** 2) - (y / 0.006) ** 2)
    assert pad.base_pressure(pressure).sum() == pytest.approx(pressure.sum(), rel=1e-3)


def test_a_window_is_the_same_operator():
    grid = Grid(48, 0.02)
    pad = LayerCompliance(grid, LayerMaterial(2e-3, 2e5, 0.45))
    rows, columns = slice(7, 29), slice(20, 45)
    pressure = np.zeros((48, 48))
    pressure[rows, columns] = np.random.default_rng(0).random((22, 25))
    whole = pad.displacement(pressure)[rows, columns]
    windowed = pad.window(rows, columns).displacement(pressure[rows, columns])
    assert windowed == pytest.approx(whole, rel=1e-10)


@pytest.mark.parametrize("bad", [(-1e-3, 1e6, 0.3), (1e-3, 0.0, 0.3), (1e-3, 1e6, 0.51), (1e-3, 1e6, -0.1)])
def test_impossible_materials_are_refused(bad):
    with pytest.raises(ValueError, match=r"layer needs|poisson_ratio"):
        LayerMaterial(*bad)
