"""DIGIT: contact in newtons, a frame of the whole gel, light from three sides."""

import numpy as np
import pytest

from sensors.digit import FRAME_SHAPE, PIXEL_MM, Digit, DigitParameters
from sensors.gel_pad import ball_gap

BALL = 3e-3


@pytest.fixture(scope="module")
def sensor() -> Digit:
    return Digit()


def change(sensor, x=0.0, y=0.0, depth=0.5) -> np.ndarray:
    return sensor.press(ball_gap(sensor.grid, BALL, x, y), depth_mm=depth).frame.astype(float) - sensor.frame(None)


def test_frame_shows_the_whole_gel_without_saturation(sensor):
    rest = sensor.frame(None)
    assert rest.shape == (*FRAME_SHAPE, 3)
    assert rest.dtype == np.uint8
    assert rest.min() > 0
    assert (rest == 255).mean() < 1e-3
    assert (FRAME_SHAPE[0] * PIXEL_MM, FRAME_SHAPE[1] * PIXEL_MM) == pytest.approx((18.0, 24.0))


def test_load_is_carried_and_stiffness_scales_it(sensor):
    gap = ball_gap(sensor.grid, BALL)
    soft = sensor.press(gap, load_n=0.1)
    assert soft.contact.force_n == pytest.approx(0.1, rel=1e-5)
    stiff = Digit(DigitParameters(gel_modulus_kpa=60.0)).press(gap, depth_mm=soft.contact.indentation_m * 1e3)
    assert stiff.contact.force_n == pytest.approx(0.2, rel=1e-3)


def test_the_press_is_seen_where_it_is(sensor):
    weight = np.abs(change(sensor, 5e-3, -3e-3)).sum(axis=2)
    weight[weight < 15] = 0
    rows, columns = np.mgrid[:240, :320]
    place = [(columns * weight).sum() / weight.sum() - 159.5, (rows * weight).sum() / weight.sum() - 119.5]
    assert np.array(place) * PIXEL_MM == pytest.approx([5.0, -3.0], abs=0.5)


def test_each_colour_falls_on_the_side_of_its_led(sensor):
    changed = change(sensor)
    off_px = 12
    for channel, led in enumerate(sensor.parameters.leds):
        azimuth = np.deg2rad(led.azimuth_deg)
        dx, dy = (round(off_px * f(azimuth)) for f in (np.cos, np.sin))
        assert changed[120 + dy, 160 + dx, channel] > 5
        assert changed[120 - dy, 160 - dx, channel] < -5


def test_a_deeper_press_changes_more(sensor):
    assert np.abs(change(sensor, depth=0.2)).sum() < np.abs(change(sensor, depth=0.8)).sum()


def test_what_lies_beside_the_gel_is_not_touched(sensor):
    gap = np.where(sensor.gel, 1e-3, 0.0)
    pressed = sensor.press(gap, depth_mm=0.5)
    assert pressed.contact.force_n == 0.0
    assert np.array_equal(pressed.frame, sensor.frame(None))


@pytest.mark.parametrize("grid", [64, 320])
def test_other_grids_show_the_same_press(sensor, grid):
    other = Digit(DigitParameters(grid=grid))
    a = sensor.press(ball_gap(sensor.grid, BALL), load_n=0.1)
    b = other.press(ball_gap(other.grid, BALL), load_n=0.1)
    assert b.contact.indentation_m == pytest.approx(a.contact.indentation_m, rel=0.03)
    assert np.abs(a.frame.astype(int) - b.frame).mean() < 0.6


def test_noise_comes_from_the_generator_and_has_its_size(sensor):
    clean = sensor.frame(None).astype(float)
    noisy = [sensor.frame(None, np.random.default_rng(seed)) for seed in (3, 3, 4)]
    assert np.array_equal(noisy[0], noisy[1])
    assert not np.array_equal(noisy[0], noisy[2])
    inside = (clean > 10) & (clean < 245)
    assert (noisy[0] - clean)[inside].std() == pytest.approx(np.sqrt(1 + 2 / 12), rel=0.1)


def test_bad_input_is_refused(sensor):
    with pytest.raises(ValueError, match=r"grid's shape \(160, 160\)"):
        sensor.press(np.zeros((5, 5)), load_n=1.0)
    with pytest.raises(ValueError, match="one of them"):
        sensor.press(ball_gap(sensor.grid, BALL))
    with pytest.raises(ValueError, match="gel_modulus_kpa"):
        DigitParameters(gel_modulus_kpa=-1.0)
