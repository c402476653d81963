"""LEDs around a gel: Lambert's law, falloff, lobes and shadows, each against its closed form."""

import numpy as np
import pytest

from sensors.optics.gel_leds import Led, LedShader, Membrane

SHAPE, PIXEL = (60, 80), 1e-4
MATT = Membrane(gloss=0.0, ambient=(0.0, 0.0, 0.0), shadow_reach_mm=0.0)
RED = Led(azimuth_deg=0.0, distance_mm=20.0, height_mm=10.0, colour=(1.0, 0.0, 0.0))


def light(surface, membrane=MATT, leds=(RED,)) -> np.ndarray:
    return LedShader(tuple(leds), membrane, SHAPE, PIXEL).light(surface)


def flat() -> np.ndarray:
    return np.zeros(SHAPE)


def ridge(height_px=10.0, at=40) -> np.ndarray:
    """A wall across the frame, one side facing +x, the other -x, in metres."""
    x = np.arange(SHAPE[1])
    profile = height_px * np.exp(-((x - at) ** 2) / (2 * 3.0**2))
    return np.broadcast_to(profile * PIXEL, SHAPE)


def test_flat_matt_membrane_follows_lambert_and_inverse_square():
    seen = light(flat())[..., 0]
    y, x = (((np.arange(n) + 0.5) - n / 2) * PIXEL for n in SHAPE)
    r2 = (20e-3 - x[None, :]) ** 2 + y[:, None] ** 2 + 10e-3**2
    r0 = 20e-3**2 + 10e-3**2
    assert seen == pytest.approx(MATT.albedo * 10e-3 / np.sqrt(r2) * r0 / r2, rel=1e-4)


def test_a_tilted_plane_follows_the_cosine():
    x = ((np.arange(SHAPE[1]) + 0.5) - SHAPE[1] / 2) * PIXEL
    slope = -0.5
    plane = np.broadcast_to(slope * x, SHAPE)
    middle = light(plane)[30, 40, 0]
    towards = np.array([20.0, 10.0]) / np.hypot(20, 10)
    normal = np.array([-slope, 1.0]) / np.hypot(slope, 1)
    assert middle == pytest.approx(MATT.albedo * normal @ towards, rel=0.01)


def test_the_side_that_faces_a_light_gains_it_and_the_other_loses_it():
    change = (light(ridge()) - light(flat()))[30, :, 0]
    assert change[44] > 0.1
    assert change[36] < -0.1


def test_no_light_comes_from_below_the_horizon_of_a_facet():
    steep = ridge(height_px=60.0)
    assert light(steep)[30, 36, 0] == 0.0


def test_light_adds_up_over_leds_and_scales_with_colour():
    blue = Led(azimuth_deg=120.0, colour=(0.0, 0.0, 0.5))
    both = light(ridge(), leds=(RED, blue))
    assert both == pytest.approx(light(ridge()) + light(ridge(), leds=(blue,)), abs=1e-6)
    twice = blue.model_copy(update={"colour": (0.0, 0.0, 1.0)})
    assert light(ridge(), leds=(twice,)) == pytest.approx(2 * light(ridge(), leds=(blue,)), abs=1e-6)


def test_turning_led_and_surface_turns_the_light():
    square = (60, 60)
    y, x = np.mgrid[:60, :60]
    bump = 8 * PIXEL * np.exp(-((x - 36) ** 2 + (y - 30) ** 2) / 50.0)
    shadowed = Membrane(gloss=0.1)
    ahead = LedShader((RED,), shadowed, square, PIXEL).light(bump)
    turned = RED.model_copy(update={"azimuth_deg": 90.0})
    assert LedShader((turned,), shadowed, square, PIXEL).light(bump.T).transpose(1, 0, 2) == pytest.approx(
        ahead, abs=1e-3
    )


def test_gloss_is_brightest_where_the_halfway_vector_is_the_normal():
    glossy = MATT.model_copy(update={"gloss": 1.0, "shininess": 200.0})
    x = ((np.arange(SHAPE[1]) + 0.5) - SHAPE[1] / 2) * PIXEL
    half = np.tan(np.arctan2(20.0, 10.0) / 2)  # slope of the mirror that sends the LED's light to the camera
    mirror = np.broadcast_to(-half * x, SHAPE)
    assert (light(mirror, glossy) - light(mirror))[30, 40, 0] == pytest.approx(1.0, rel=0.02)
    assert (light(flat(), glossy) - light(flat()))[30, 40, 0] < 1e-3


def test_a_wall_casts_a_shadow_as_long_as_the_light_is_low():
    shadowed = MATT.model_copy(update={"shadow_reach_mm": 8.0, "shadow_softness_deg": 0.5})
    low = RED.model_copy(update={"distance_mm": 100.0, "height_mm": 50.0})
    wall = np.zeros(SHAPE)
    wall[:, 56:70] = 10 * PIXEL
    ratio = light(wall, shadowed, (low,))[30, :54, 0] / light(wall, MATT, (low,))[30, :54, 0]
    length = 10 * 100 / 50  # pixels; steps of a quarter may cut it that much short
    assert ratio[: int(56 - 1.1 * length)].min() == pytest.approx(1.0)
    assert ratio[int(56 - 0.75 * length) :].max() == pytest.approx(0.0)


def test_a_surface_no_steeper_than_the_light_casts_no_shadow():
    shadowed = MATT.model_copy(update={"shadow_reach_mm": 8.0, "shadow_softness_deg": 1.0})
    gentle = ridge(height_px=1.0)
    assert light(gentle, shadowed) == pytest.approx(light(gentle), abs=1e-6)


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="at least one LED"):
        LedShader((), MATT, SHAPE, PIXEL)
    with pytest.raises(ValueError, match="frame's shape"):
        light(np.zeros((5, 5)))
