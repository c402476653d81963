"""The dragged weave: nothing without a shift, and the cloth elsewhere with one."""

import cv2
import numpy as np
import pytest

from sensors.fvsight import FVSightParameters, FVSightUnit
from sensors.optics.canvas import Canvas
from sensors.optics.dragged_weave import DraggedWeave

AXIS = ((np.arange(256) + 0.5) / 256 - 0.5) * 0.08
ONES = np.ones((256, 256), np.float32)


def weave():
    return DraggedWeave(Canvas(), AXIS, AXIS, np.random.default_rng(3))


def test_a_shift_by_whole_pixels_shows_the_neighbouring_cloth():
    pixel = AXIS[1] - AXIS[0]
    cloth = Canvas().reflectance(AXIS, AXIS, np.random.default_rng(3))[1]
    ratio = weave().ratio(ONES, (2 * pixel, 0.0))
    assert (cloth * ratio)[:, 2:-2] == pytest.approx(cloth[:, :-4], abs=1e-5)
    ratio = weave().ratio(ONES, (0.0, -pixel))
    assert (cloth * ratio)[2:-2] == pytest.approx(cloth[3:-1], abs=1e-5)


def test_a_shift_by_parts_of_a_pixel_is_close_to_the_cloth_drawn_there():
    shift = 0.07e-3
    canvas = Canvas(colour=(1.0, 1.0, 1.0), thread_spread=0.0)
    there = canvas.reflectance(AXIS - shift, AXIS, np.random.default_rng(3))[0]
    here = canvas.reflectance(AXIS, AXIS, np.random.default_rng(3))[0]
    moved = here * DraggedWeave(canvas, AXIS, AXIS, np.random.default_rng(3)).ratio(ONES, (shift, 0.0))
    inside = np.s_[8:-8, 8:-8]
    error = np.sqrt(((moved - there)[inside] ** 2).mean())
    assert error < 0.15 * np.sqrt(((here - there)[inside] ** 2).mean())


def test_a_cloth_that_stretches_is_close_to_one_whose_points_moved_one_by_one():
    x, y = np.meshgrid(AXIS, AXIS)
    shape = np.exp(-(x**2 + y**2) / (2 * 0.012**2)).astype(np.float32)
    shift = (0.3e-3, -0.2e-3)
    canvas = Canvas(colour=(1.0, 1.0, 1.0))
    fine = canvas.weave(AXIS, AXIS, np.random.default_rng(3), 4)
    column, row = np.meshgrid(np.arange(1024.0), np.arange(1024.0))
    moved = cv2.resize(shape, (1024, 1024)) * 4 / (AXIS[1] - AXIS[0])
    places = [(at - moved * by).astype(np.float32) for at, by in zip((column, row), shift, strict=True)]
    there = cv2.remap(fine, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    here, there = (field.reshape(256, 4, 256, 4).mean(axis=(1, 3)) for field in (fine, there))
    error = here * weave().ratio(shape, shift) - there
    assert np.sqrt((error**2).mean()) < 0.1 * np.sqrt(((here - there) ** 2).mean())


def test_without_a_shift_the_frame_is_the_frame_of_a_press():
    unit = FVSightUnit(FVSightParameters(), 2)
    assert unit.camera.dragged_weave(ONES, (0.0, 0.0)) is None
    still = unit.frame(None, unit.session(None), np.random.default_rng(0))
    ratio = unit.camera.dragged_weave(0 * ONES, (1e-4, 0.0))
    assert ratio == pytest.approx(1, abs=1e-6)
    again = unit.frame(None, unit.session(None), np.random.default_rng(0), ratio)
    assert np.abs(again.astype(int) - still).max() <= 1


def test_the_shape_of_a_shift_is_seen_where_it_is():
    unit = FVSightUnit(FVSightParameters(), 0)
    grid = unit.grid
    x, y = grid.coordinates()
    bump = np.exp(-((x - 0.01) ** 2 + y**2) / (2 * 0.008**2))
    from sensors.contact.skin import sine_basis

    basis = sine_basis((np.arange(grid.n) + 0.5) / grid.n, grid.n)
    seen = unit.camera.shift_shape(basis.T @ bump @ basis)
    top = np.unravel_index(seen.argmax(), seen.shape)
    assert seen.max() == pytest.approx(1, abs=0.01)
    assert AXIS[top[1]] == pytest.approx(0.01, abs=2e-3)
    assert AXIS[top[0]] == pytest.approx(0.0, abs=2e-3)
