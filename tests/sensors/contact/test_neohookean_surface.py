"""Rigid surfaces: derivatives, shapes and the spline through a grid."""

import numpy as np
import pytest

from sensors.contact.grid import Grid
from sensors.contact.neohookean import GridSurface, SweptSurface
from sensors.contact.solver import NO_SURFACE

GRID = Grid(40, 8.0)


def dome() -> np.ndarray:
    x, y = GRID.coordinates()
    return (x**2 + 2 * y**2) / 10 + 0.05 * np.sin(2 * x + y)


SURFACES = {
    "sphere": SweptSurface(2.0),
    "cylinder": SweptSurface(1.5, half_length_m=1.0),
    "edge": SweptSurface(0.5, half_length_m=1.0),
    "punch": SweptSurface(0.3, core_radius_m=0.7),
    "grid": GridSurface(GRID, dome(), 10.0),
}


@pytest.mark.parametrize("name", list(SURFACES))
def test_slope_and_curvature_are_derivatives(name):
    surface = SURFACES[name]
    x, y = np.random.default_rng(5).uniform(-1.8, 1.8, (2, 300))
    jet, step = surface.jet(x, y), 1e-6
    for axis, (dx, dy) in enumerate([(step, 0.0), (0.0, step)]):
        ahead, behind = surface.jet(x + dx, y + dy), surface.jet(x - dx, y - dy)
        assert jet.gradient[:, axis] == pytest.approx((ahead.gap - behind.gap) / (2 * step), abs=1e-7)
        slopes = (ahead.gradient - behind.gradient) / (2 * step)
        assert jet.hessian[:, :, axis] == pytest.approx(slopes, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("name", ["sphere", "cylinder", "edge", "punch"])
def test_swept_surfaces_touch_at_the_centre_and_mirror(name):
    surface = SURFACES[name]
    assert surface.jet(np.zeros(1), np.zeros(1)).gap == 0
    x, y = np.random.default_rng(6).uniform(-3, 3, (2, 100))
    assert surface.jet(-x, y).gap == pytest.approx(surface.jet(x, y).gap)
    assert surface.jet(x, -y).gap == pytest.approx(surface.jet(x, y).gap)


def test_a_swept_point_is_a_sphere_and_its_apex_has_the_curvature():
    jet = SweptSurface(2.0).jet(np.array([0.0, 0.6]), np.array([0.0, 0.8]))
    assert jet.gap == pytest.approx([0.0, 2 - np.sqrt(3)])
    assert jet.hessian[0] == pytest.approx(np.eye(2) / 2)


def test_a_flat_core_is_flat():
    jet = SURFACES["punch"].jet(np.array([0.0, 0.3, -0.69]), np.array([0.0, 0.5, 0.0]))
    assert jet.gap == pytest.approx(0.0)
    assert jet.gradient == pytest.approx(0.0)
    assert jet.hessian == pytest.approx(0.0)


def test_the_spline_stays_between_its_cells_and_has_no_holes():
    x, y = GRID.coordinates()
    gap = np.where(np.hypot(x, y) < 1.5, 0.0, NO_SURFACE)
    fine = Grid(173, 9.0)
    values = GridSurface(GRID, gap, 0.7).jet(*fine.coordinates()).gap
    assert values.min() >= -1e-15
    assert values.max() == pytest.approx(0.7)


def test_the_spline_is_off_by_the_stated_share_of_the_curvature():
    x, y = GRID.coordinates()
    surface = GridSurface(GRID, (x**2 + y**2) / 10, 100.0)
    inside = np.array([0.13, -0.9, 1.7]), np.array([0.4, 0.05, -1.1])
    excess = surface.jet(*inside).gap - (inside[0] ** 2 + inside[1] ** 2) / 10
    # curvature 1/5 in both directions: 2 x pitch^2 / 6 x 1/5
    assert excess == pytest.approx(GRID.pitch_m**2 / 3 / 5, rel=1e-9)


def test_only_a_mirrored_grid_may_be_quartered():
    x, y = GRID.coordinates()
    assert GridSurface(GRID, x**2 + y**2, 100.0).quarter
    assert not GridSurface(GRID, x**2 + y**2 + 0.1 * x, 100.0).quarter


def test_impossible_surfaces_are_refused():
    with pytest.raises(ValueError, match="tip_radius_m"):
        SweptSurface(0.0)
    with pytest.raises(ValueError, match="finite somewhere"):
        GridSurface(GRID, np.full((40, 40), NO_SURFACE), 1.0)
    with pytest.raises(ValueError, match="grid's shape"):
        GridSurface(GRID, np.zeros((4, 40)), 1.0)
