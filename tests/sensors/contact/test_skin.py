"""The skin against Navier's series, the membrane, the film alone and the stretching disc."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.large_deflection import disc_deflection, linear_excess
from sensors.contact.layer import LayerMaterial
from sensors.contact.skin import SkinCompliance, SkinMaterial, cosine_basis, sine_basis

FILM = LayerMaterial(1.5e-3, 5e6, 0.45)
SIDE = 0.08


def skin(n: int = 128, tension: float = 600.0, film: LayerMaterial = FILM) -> SkinCompliance:
    return SkinCompliance(Grid(n, SIDE), SkinMaterial(film, tension))


def navier(material: SkinMaterial, x: float, y: float, coefficient, terms: int = 399) -> float:
    """Deflection of the simply supported square at (x, y) from its corner, for double-sine load coefficients."""
    m = np.arange(1, terms + 1)
    k2 = (np.pi / SIDE) ** 2 * (m[:, None] ** 2 + m[None, :] ** 2)
    amplitude = coefficient(m[:, None], m[None, :]) * material.plate_compliance(k2)
    return float(np.sin(m * np.pi * y / SIDE) @ amplitude @ np.sin(m * np.pi * x / SIDE))


@pytest.mark.parametrize("tension", [1e-6, 600.0])
def test_uniform_pressure_sinks_the_plate_as_navier_says(tension):
    plate = skin(tension=tension)
    deflection = plate.deflection(np.ones((128, 128)))
    at = plate.grid.axis()[70] + SIDE / 2

    def uniform(m, n):
        return 16 / (np.pi**2 * m * n) * (m % 2) * (n % 2)

    assert deflection[70, 70] == pytest.approx(navier(plate.material, at, at, uniform), rel=1e-3)


def test_point_load_sinks_the_plate_as_navier_says():
    plate = skin(tension=1e-6)
    pressure = np.zeros((128, 128))
    pressure[40, 64] = 1 / plate.grid.cell_area_m2
    corner = plate.grid.axis() + SIDE / 2
    x0, y0 = corner[64], corner[40]

    def point(m, n):
        return 4 / SIDE**2 * np.sin(n * np.pi * x0 / SIDE) * np.sin(m * np.pi * y0 / SIDE)

    expected = navier(plate.material, corner[80], corner[50], point)
    assert plate.deflection(pressure)[50, 80] == pytest.approx(expected, rel=1e-3)


def test_textbook_coefficient_of_the_square_plate():
    """w = 0.00406 q a^4 / D at the centre (Timoshenko, table 8)."""
    plate = skin(tension=1e-6)
    centre = plate.deflection(np.ones((128, 128)))[63:65, 63:65].mean()
    assert centre == pytest.approx(0.00406 * SIDE**4 / plate.material.bending_stiffness_nm, rel=3e-3)


def test_without_bending_it_is_a_membrane():
    """w = 0.07367 p a^2 / N at the centre of a square membrane under uniform pressure."""
    soft = LayerMaterial(1e-5, 1e3, 0.45)
    membrane = skin(film=soft)
    centre = membrane.deflection(np.ones((128, 128)))[63:65, 63:65].mean()
    assert centre == pytest.approx(0.07367 * SIDE**2 / 600.0, rel=3e-3)


def test_compliances_add_in_series():
    plate = skin(64)
    pressure = np.random.default_rng(0).random((64, 64))
    squeeze = plate.displacement(pressure) - plate.deflection(pressure)
    k = np.pi * np.arange(1, 65) / SIDE
    symbol = FILM.surface_compliance(np.hypot(k[:, None], k[None, :]))
    basis = sine_basis((np.arange(64) + 0.5) / 64, 64)
    assert squeeze == pytest.approx(basis @ (basis.T @ pressure @ basis * symbol) @ basis.T, rel=1e-9, abs=1e-18)


def test_base_pressure_keeps_the_load():
    plate = skin()
    x, y = plate.grid.coordinates()
    pressure = np.where(np.hypot(x - 0.01, y + 0.02) < 0.008, 1e4, 0.0)
    assert plate.base_pressure(pressure).sum() == pytest.approx(pressure.sum(), rel=1e-3)


def test_finer_sampling_interpolates_the_same_modes():
    modes = np.random.default_rng(1).standard_normal((16, 16))
    grid_points = (np.arange(16) + 0.5) / 16
    coarse = sine_basis(grid_points, 16)
    assert coarse.T @ coarse == pytest.approx(np.eye(16), abs=1e-12)
    assert coarse.T @ (coarse @ modes @ coarse.T) @ coarse == pytest.approx(modes, abs=1e-12)


def test_cosine_basis_is_the_derivative():
    position, step = np.array([0.21, 0.64]), 1e-6
    difference = (sine_basis(position + step, 12) - sine_basis(position - step, 12)) / (2 * step * SIDE)
    assert cosine_basis(position, 12, SIDE) == pytest.approx(difference, rel=1e-6, abs=1e-4)


def test_a_window_is_the_same_operator():
    plate = skin(64)
    rows, columns = slice(3, 30), slice(25, 64)
    pressure = np.zeros((64, 64))
    pressure[rows, columns] = np.random.default_rng(0).random((27, 39))
    windowed = plate.window(rows, columns).displacement(pressure[rows, columns])
    assert windowed == pytest.approx(plate.displacement(pressure)[rows, columns], rel=1e-10)


def test_small_presses_do_not_stretch_the_skin():
    material = SkinMaterial(FILM, 600.0)
    assert linear_excess(material, 0.04, 0.006, 0.05) < 1e-4


def test_linear_disc_under_a_ring_of_tension_is_the_log_profile():
    """A membrane under a central patch: w0 = F / (2 pi N) (ln(a / b) + 1/2)."""
    membrane = SkinMaterial(LayerMaterial(2e-5, 5e6, 0.45), 600.0)
    expected = 2.0 / (2 * np.pi * 600.0) * (np.log(0.04 / 0.006) + 0.5)
    assert disc_deflection(membrane, 0.04, 0.006, 2.0, stretching=False) == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("patch_m", [3e-3, 6e-3, 12e-3])
@pytest.mark.parametrize("force_n", [1.5, 3.0, 5.0, 8.0])
def test_the_estimate_of_stretching_never_flatters(patch_m, force_n):
    material = SkinMaterial(FILM, 600.0)
    true = linear_excess(material, 0.04, patch_m, force_n)
    linear = disc_deflection(material, 0.04, patch_m, force_n, stretching=False)
    estimate = material.stretching_excess(linear, 0.04)
    assert estimate >= true
    if 0.005 < true < 0.15:
        assert estimate < 1.6 * true


def test_a_slack_skin_is_refused():
    with pytest.raises(ValueError, match="positive tension"):
        SkinMaterial(FILM, 0.0)
