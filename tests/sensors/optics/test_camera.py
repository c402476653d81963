"""Frames: shading follows the slope, views show the same skin, noise is as stated."""

import numpy as np
import pytest

from sensors.contact.skin import sine_basis
from sensors.optics.camera import Camera, CameraParameters
from sensors.optics.canvas import Canvas
from sensors.optics.lights import LedRing

SIDE, MODES = 0.08, 64


def camera(view="region", canvas=None, **lights) -> Camera:
    canvas = canvas or Canvas(weave_contrast=0.0, thread_spread=0.0)
    return Camera(CameraParameters(view=view), LedRing(**lights), canvas, SIDE, MODES, np.random.default_rng(0))


def bump(x0=0.0, y0=0.0, height=1e-3, width=0.008) -> np.ndarray:
    position = (np.arange(MODES) + 0.5) / MODES
    axis = (position - 0.5) * SIDE
    field = height * np.exp(-(((axis[None, :] - x0) / width) ** 2) - ((axis[:, None] - y0) / width) ** 2)
    basis = sine_basis(position, MODES)
    return (basis.T @ field @ basis).astype(np.float32)


def test_a_flat_skin_is_the_rest_frame():
    eye = camera()
    assert np.array_equal(eye.clean(np.zeros((MODES, MODES), np.float32)), eye.clean(None))


def test_the_side_of_a_bump_that_faces_a_colour_gains_that_colour():
    eye = camera(crosstalk=0.0)
    change = eye.clean(bump()) - eye.clean(None)
    off = 16  # pixels from the centre, on the flank
    red_at, centre = 90.0, 128  # the red arc lies at +y
    assert red_at == LedRing().azimuths_deg[0]
    assert change[0, centre + off, centre] > 1.0
    assert change[0, centre - off, centre] < -1.0


def test_three_equal_lights_at_the_centre_shed_equal_light():
    frame = camera().clean(None)
    assert frame[:, 127:129, 127:129].mean(axis=(1, 2)) / np.array(Canvas().colour) == pytest.approx(
        frame[0, 127:129, 127:129].mean() / Canvas().colour[0], rel=1e-3
    )


def test_power_scales_its_channel_alone_without_crosstalk():
    bright = camera(crosstalk=0.0, power=(2.0, 1.0, 1.0)).clean(None)
    plain = camera(crosstalk=0.0).clean(None)
    assert bright[0] == pytest.approx(2 * plain[0], rel=1e-5)
    assert bright[1] == pytest.approx(plain[1], rel=1e-5)


def test_full_frame_and_region_show_the_same_skin():
    region = camera().clean(bump(0.01, -0.005))
    full = camera("full").clean(bump(0.01, -0.005))
    # 720 / 256 is no whole number: compare at the same places
    at = ((np.arange(256) + 0.5) / 256 * 720 - 0.5).round().astype(int)
    assert full[:, at[:, None], at] == pytest.approx(region, abs=1.5)


def test_views_have_their_stated_shapes():
    rng = np.random.default_rng(0)
    assert camera().capture(None, rng).shape == (256, 256, 3)
    assert camera("native_crop").capture(None, rng).shape == (256, 256, 3)
    assert camera("full").capture(None, rng).shape == (720, 1280, 3)


def test_native_crop_is_the_middle_of_the_full_frame():
    crop = camera("native_crop").clean(bump())
    full = camera("full").clean(bump())
    assert full[:, 232:488, 232:488] == pytest.approx(crop, abs=1e-2)


def test_noise_has_the_stated_size_and_no_bias():
    eye = camera("full")
    clean = eye.clean(None)
    noisy = np.stack([eye.capture(None, np.random.default_rng(seed))[:, 280:1000] for seed in range(8)])
    error = noisy.transpose(0, 3, 1, 2).astype(float) - clean
    inside = (clean > 30) & (clean < 200)
    p = CameraParameters()
    expected = np.sqrt(p.read_noise**2 + p.shot_noise**2 * clean[inside] / 255 + 1 / 12)
    assert (error.std(axis=0)[inside] / expected).mean() == pytest.approx(np.sqrt(7 / 8), abs=0.04)
    assert error[:, inside].mean() == pytest.approx(0, abs=0.02)


def test_the_housing_is_as_noisy_as_the_skin_is_dark():
    p = CameraParameters()
    frame = camera("full").capture(None, np.random.default_rng(3)).astype(float)
    sides = np.concatenate((frame[:, :280], frame[:, 1000:]), axis=1)
    assert sides.mean() == pytest.approx(12, abs=0.02)
    assert sides.std() == pytest.approx(np.sqrt(p.read_noise**2 + p.shot_noise**2 * 12 / 255 + 1 / 12), rel=0.02)
    assert np.ptp(camera("full").capture(None, None)[:, :280]) == 0


def test_same_generator_same_frame():
    eye = camera()
    frames = [eye.capture(bump(), np.random.default_rng(5)) for _ in range(2)]
    assert np.array_equal(*frames)


def test_canvas_keeps_its_mean_colour_between_pixel_sizes():
    axis = (np.arange(512) + 0.5) / 512 * SIDE
    fine = Canvas().reflectance(axis, axis, np.random.default_rng(1))
    coarse = Canvas().reflectance(axis[::2], axis[::2], np.random.default_rng(1))
    assert fine.mean(axis=(1, 2)) == pytest.approx(coarse.mean(axis=(1, 2)), rel=0.02)


def test_weave_and_threads_can_be_left_out():
    axis = (np.arange(64) + 0.5) / 64 * SIDE
    plain = Canvas(weave_contrast=0.0, thread_spread=0.0).reflectance(axis, axis, np.random.default_rng(0))
    assert plain == pytest.approx(np.asarray(Canvas().colour)[:, None, None] * np.ones((3, 64, 64)), rel=1e-6)
