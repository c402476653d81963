"""Hard contacts on every compliance, in both precisions, under both controls: converged, or refused in one line."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.half_space import HalfSpaceCompliance
from sensors.contact.hertz import HertzSphere, plane_strain_modulus
from sensors.contact.ladder import Pad, get_rung, indenter
from sensors.contact.large_deflection import disc_deflection
from sensors.contact.layer import LayerCompliance, LayerMaterial
from sensors.contact.neohookean import SweptSurface
from sensors.contact.skin import SkinCompliance, SkinMaterial
from sensors.contact.solver import NO_SURFACE, solve_indentation, solve_load
from sensors.gel_pad import GelPad

N, SIDE = 64, 0.08
GRID = Grid(N, SIDE)
FILM = LayerMaterial(1.5e-3, 5e6, 0.45)
DTYPES = [np.float64, np.float32]
COMPLIANCES = {
    "skin": lambda dtype: SkinCompliance(GRID, SkinMaterial(FILM, 600.0), dtype),
    "layer": lambda dtype: LayerCompliance(GRID, LayerMaterial(4e-3, 2e5, 0.45), dtype),
    "incompressible layer": lambda dtype: LayerCompliance(GRID, LayerMaterial(4e-3, 2e5, 0.5), dtype),
    "half-space": lambda dtype: HalfSpaceCompliance(GRID, plane_strain_modulus(2e5, 0.45), dtype),
}


def surfaces() -> dict[str, np.ndarray]:
    x, y = GRID.coordinates()
    r = np.hypot(x, y)
    rough = 1e-4 * np.random.default_rng(0).random(x.shape)
    single = (x == GRID.axis()[20]) & (y == GRID.axis()[30])
    out = {
        "line edge": np.where((np.abs(x) < 0.03) & (np.abs(y) < GRID.pitch_m), 0.0, NO_SURFACE),
        "rough": np.where(np.maximum(np.abs(x), np.abs(y)) < 0.03, rough, NO_SURFACE),
        "single pixel": np.where(single, 0.0, NO_SURFACE),
        "flat punch": np.where(r < 0.02, 0.0, NO_SURFACE),
        "tilted at the border": np.where(x < -0.03, (x + 0.04) / 10, NO_SURFACE),
        "a / h = 5": np.where(r < 0.02, r**2 / 8, NO_SURFACE),
    }
    return {name: gap - gap.min() for name, gap in out.items()}


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", list(surfaces()))
@pytest.mark.parametrize("compliance", list(COMPLIANCES))
def test_under_depth_control_no_cell_pulls_and_closed_gaps_are_closed(compliance, name, dtype):
    """0.2 mm deep: p >= 0; no penetration over 0.2 % of the depth (0.4 % in float32); open gaps carry nothing."""
    pad, gap, depth = COMPLIANCES[compliance](dtype), surfaces()[name], 2e-4
    solution = solve_indentation(pad, gap, depth)
    pressure = np.asarray(solution.pressure, float)
    opening = pad.displacement(solution.pressure) + gap - depth
    slack = (2e-3 if dtype is np.float64 else 4e-3) * depth
    assert solution.force_n > 0
    assert (pressure >= 0).all()
    assert opening[np.isfinite(gap)].min() > -slack
    touched = pressure > 0
    assert (np.abs(opening[touched]) * pressure[touched]).sum() <= 2e-4 * depth * pressure.sum()
    assert not pressure[~np.isfinite(gap)].any()


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_punch_on_a_thin_incompressible_pad_follows_the_squeezed_film(dtype):
    """nu = 1/2, a / h = 20: over the middle half p = p0 - 3 G d r^2 / (4 h^3), Reynolds' film, its curvature to 3 %."""
    grid, thickness, depth = Grid(128, 0.05), 1e-3, 1e-5
    r = np.hypot(*grid.coordinates())
    gap = np.where(r < 0.02, 0.0, NO_SURFACE)
    solution = solve_indentation(LayerCompliance(grid, LayerMaterial(thickness, 2e5, 0.5), dtype), gap, depth)
    middle = r < 0.01
    slope, top = np.polyfit(r[middle] ** 2, solution.pressure[middle].astype(float), 1)
    # the top slips freely: flux h^3 / (3 G) grad p, fed by d per area
    assert slope == pytest.approx(-0.75 * 2e5 / 3 * depth / thickness**3, rel=0.03)
    assert solution.pressure[middle] == pytest.approx(top + slope * r[middle] ** 2, abs=0.01 * top)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("compliance", list(COMPLIANCES))
def test_no_depth_and_no_load_give_no_pressure(compliance, dtype):
    pad = COMPLIANCES[compliance](dtype)
    gap = surfaces()["a / h = 5"]
    for solution in (*(solve_indentation(pad, gap, depth) for depth in (0.0, -1e-4)), solve_load(pad, gap, 0.0)):
        assert solution.force_n == 0
        assert not solution.contact.any()


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("compliance", list(COMPLIANCES))
def test_thirty_warm_steps_down_and_up_meet_the_cold_solve(compliance, dtype):
    """A rough ball loaded in 20 steps and unloaded in 10: force within 0.1 % of a cold solve at the end."""
    pad = COMPLIANCES[compliance](dtype)
    x, y = GRID.coordinates()
    gap = (x**2 + y**2) / 0.04 + 5e-5 * np.random.default_rng(1).random(x.shape)
    gap -= gap.min()
    pressure = None
    for depth in np.concatenate([np.linspace(4e-5, 8e-4, 20), np.linspace(7.6e-4, 4e-4, 10)]):
        step = solve_indentation(pad, gap, depth, initial=pressure)
        pressure = step.pressure
        assert step.residual <= 1e-4
    assert step.force_n == pytest.approx(solve_indentation(pad, gap, 4e-4).force_n, rel=1e-3)


@pytest.mark.parametrize("compliance", list(COMPLIANCES))
def test_a_load_that_no_depth_reaches_is_refused(compliance):
    """No surface, or no number: one line; a compliance alone knows no thickness, so that pads refuse (below)."""
    pad = COMPLIANCES[compliance](np.float64)
    for gap, load in [(np.full((N, N), NO_SURFACE), 1.0), (surfaces()["rough"], np.inf), (surfaces()["rough"], np.nan)]:
        with pytest.raises(ValueError, match=r"surface|finite"):
            solve_load(pad, gap, load)
    heavy = solve_load(pad, surfaces()["single pixel"], 1e6)
    assert heavy.force_n == pytest.approx(1e6)
    assert heavy.indentation_m > 4e-3


@pytest.mark.parametrize("rung", ["winkler", "layer-64", "neohookean"])
def test_no_rung_presses_a_pad_through(rung):
    """From the thickness on all refuse a depth in the same words; the flat ones a load that sinks as far, too."""
    opened, ball = get_rung(rung).open(Pad(LayerMaterial(3e-3, 1e5, 0.45), 0.024), "sphere"), indenter("sphere", 3e-3)
    for depth in (3e-3, 3e-2, np.inf):
        with pytest.raises(ValueError, match="less than the pad's thickness"):
            next(opened.press_depths(ball, [depth]))
    if rung != "neohookean":
        deep = next(opened.press_depths(ball, [2.9e-3]))
        assert next(opened.press_loads(ball, [deep.force_n])).indentation_m == pytest.approx(2.9e-3, rel=1e-2)
        with pytest.raises(ValueError, match="less than the pad's thickness 3 mm"):
            next(opened.press_loads(ball, [2 * deep.force_n]))


def test_a_gel_is_not_pressed_through():
    """Just short of the thickness it answers, by load and by depth alike; at the thickness it refuses."""
    gel = GelPad(GRID, LayerMaterial(4e-3, 2e5, 0.45))
    gap = surfaces()["a / h = 5"]
    almost = gel.solve(gap, depth_mm=3.99)
    assert gel.solve(gap, load_n=almost.force_n).indentation_m == pytest.approx(3.99e-3, rel=1e-3)
    for press in ({"depth_mm": 4.0}, {"load_n": 1.01 * almost.force_n}):
        with pytest.raises(ValueError, match="less than the pad's thickness"):
            gel.solve(gap, **press)
    with pytest.raises(ValueError, match="less than the pad's thickness"):
        gel.solve(surfaces()["single pixel"], load_n=1e6)


def test_a_taut_skin_is_its_film_alone():
    """N = 1e9 N/m: a ball on the skin carries what the bonded layer of the film does, to 2 %."""
    x, y = GRID.coordinates()
    gap = (x**2 + y**2) / 0.08
    taut = solve_indentation(SkinCompliance(GRID, SkinMaterial(FILM, 1e9)), gap, 5e-4)
    film = solve_indentation(LayerCompliance(GRID, FILM), gap, 5e-4)
    assert taut.force_n == pytest.approx(film.force_n, rel=0.02)
    peak = film.pressure.max()
    assert taut.pressure == pytest.approx(film.pressure, abs=0.03 * peak)


def test_a_central_load_sinks_the_square_membrane_like_a_disc_of_1_08_its_half_side():
    """Conformal radius of the square: w = F / (2 pi N) (ln(1.0787 s / b) + 1/2) under a patch of radius b, to 1 %."""
    soft = SkinMaterial(LayerMaterial(2e-5, 5e6, 0.45), 600.0)
    grid = Grid(128, SIDE)
    r = np.hypot(*grid.coordinates())
    b = 6e-3
    patch = (r < b).astype(float)
    patch *= 2.0 / (patch.sum() * grid.cell_area_m2)
    skin = SkinCompliance(grid, soft)
    centre = skin.deflection(patch)[63:65, 63:65].mean()
    expected = 2.0 / (2 * np.pi * 600.0) * (np.log(1.0787 * SIDE / 2 / b) + 0.5)
    assert centre == pytest.approx(expected, rel=0.01)
    assert disc_deflection(soft, 1.0787 * SIDE / 2, b, 2.0, stretching=False) == pytest.approx(centre, rel=0.02)


@pytest.mark.parametrize("dtype", DTYPES)
def test_hertz_holds_in_both_precisions_for_field_force_and_radius(dtype):
    """Force 0.2 %, field 1.5 % of the peak inside 0.9 a, contact radius within a cell."""
    sphere = HertzSphere(10e-3, 1e-4, plane_strain_modulus(1e6, 0.3))
    grid = Grid(96, 3 * sphere.contact_radius_m)
    x, y = grid.coordinates()
    pad = HalfSpaceCompliance(grid, sphere.modulus_pa, dtype)
    solution = solve_indentation(pad, (x**2 + y**2) / 0.02, sphere.indentation_m, tolerance=1e-5)
    r = np.hypot(x, y)
    inside = r < 0.9 * sphere.contact_radius_m
    assert solution.force_n == pytest.approx(sphere.force_n, rel=2e-3)
    assert np.abs(solution.pressure - sphere.pressure(r))[inside].max() < 0.015 * sphere.peak_pressure_pa
    radius = np.sqrt(solution.contact.sum() * grid.cell_area_m2 / np.pi)
    assert radius == pytest.approx(sphere.contact_radius_m, abs=grid.pitch_m)


@pytest.mark.parametrize("rung", ["winkler", "layer-64"])
def test_rungs_rest_at_no_depth_and_refuse_a_depth_that_is_no_number(rung):
    opened, surface = (
        get_rung(rung).open(Pad(LayerMaterial(3e-3, 1e5, 0.45), 0.024), "sphere"),
        indenter("sphere", 3e-3),
    )
    for response in opened.press_depths(surface, [0.0, -1e-4]):
        assert response.force_n == 0
        assert not response.pressure.any()
    with pytest.raises(ValueError, match="finite"):
        next(opened.press_depths(SweptSurface(6e-3), [np.nan]))
