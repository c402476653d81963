"""One FVSight unit: conservation, accuracy, units, refusals."""

import numpy as np
import pytest

from sensors.fvsight import FVSightParameters, fvsight_unit
from sensors.press import presented_gap
from sensors.scene import PressScene, nominal_pose

SCENE = PressScene(id="test", title="test", pose={"nominal_offset_mm": 8.0, "nominal_turn_deg": 180.0})
NAMES = SCENE.object_names


def gap_of(unit, label):
    return presented_gap(NAMES[label], unit, nominal_pose(SCENE.pose, label), SCENE.specimen_mm * 1e-3)


def centroid(load: np.ndarray) -> np.ndarray:
    at = np.stack(np.meshgrid(np.arange(4), np.arange(4))).reshape(2, 16)
    return at @ np.maximum(load, 0) / np.maximum(load, 0).sum() * 20.0


@pytest.mark.parametrize("label", range(0, 27, 2))
@pytest.mark.parametrize("support", ["hollow", "plate"])
def test_true_taxel_loads_sum_to_the_load(label, support):
    unit = fvsight_unit(FVSightParameters(support=support), 0)
    press = unit.press(gap_of(unit, label), 5.0)
    assert press.taxel_load.sum() == pytest.approx(5.0, rel=0.01)
    assert press.contact.force_n == pytest.approx(5.0, rel=1e-5)
    assert press.taxel_load.min() > -0.01


@pytest.mark.parametrize("label", range(0, 27, 3))
def test_read_back_is_accurate_before_unit_spread_and_tracks_the_centroid(label):
    unit = fvsight_unit(FVSightParameters(taxel_gain_spread=0, unit_gain_spread=0), 0)
    true = unit.press(gap_of(unit, label), 5.0).taxel_load
    ramp = np.concatenate((np.linspace(0, 1, 300), np.ones(300)))[:, None]
    read = unit.read(ramp * true, unit.session(None), np.random.default_rng(0))[300:].mean(axis=0)
    assert (np.abs(read - true) <= np.maximum(0.2, 0.05 * true)).all()
    assert centroid(read) == pytest.approx(centroid(true), abs=0.3)


def test_frame_and_taxels_show_the_press_at_the_same_place():
    unit = fvsight_unit(FVSightParameters(unit_gain_spread=0, camera_offset_mm=0), 0)
    x, y = unit.grid.coordinates()
    for x0, y0 in ((-0.02, 0.01), (0.015, -0.02)):
        press = unit.press(((x - x0) ** 2 + (y - y0) ** 2) / 0.03, 4.0)
        deflection = unit.surface(press.surface_modes)
        row, column = np.unravel_index(deflection.argmax(), deflection.shape)
        peak_mm = unit.grid.axis()[[column, row]] * 1e3
        assert peak_mm == pytest.approx([x0 * 1e3, y0 * 1e3], abs=1.5)
        assert centroid(press.taxel_load) - 30 == pytest.approx([x0 * 1e3, y0 * 1e3], abs=6)


def test_a_unit_is_the_same_sensor_every_time_and_differs_from_the_next():
    parameters = FVSightParameters()
    first, again, other = (
        fvsight_unit(parameters, 3),
        type(fvsight_unit(parameters, 3))(parameters, 3),
        fvsight_unit(parameters, 4),
    )
    assert np.array_equal(first.taxel_gain, again.taxel_gain)
    frames = [unit.frame(None, unit.session(None), None) for unit in (first, again, other)]
    assert np.array_equal(frames[0], frames[1])
    assert not np.array_equal(frames[0], frames[2])
    assert first.skin.tension_n_per_m != other.skin.tension_n_per_m


def test_more_tension_sinks_less():
    depths = []
    for tension in (400.0, 800.0):
        unit = fvsight_unit(FVSightParameters(tension_n_per_m=tension, tension_spread=0), 0)
        depths.append(unit.press(gap_of(unit, 0), 3.0).contact.indentation_m)
    assert depths[0] > depths[1]


def test_a_press_beyond_the_linear_skin_is_refused():
    unit = fvsight_unit(FVSightParameters(), 0)
    x, y = unit.grid.coordinates()
    with pytest.raises(ValueError, match="stretching is off by"):
        unit.press((x**2 + y**2) / 0.01, 20.0)


def test_the_frames_shading_error_against_a_finer_grid_is_small():
    """The 128x128 grid against 256x256: grey levels of the same press."""
    frames = []
    for grid in (128, 256):
        unit = fvsight_unit(FVSightParameters(grid=grid), 0)
        press = unit.press(gap_of(unit, 4), 5.0)
        frames.append(unit.camera.clean(press.surface_modes))
    assert np.abs(frames[0] - frames[1]).mean() < 0.5


@pytest.mark.parametrize("label", range(0, 27, 4))
def test_the_solvers_tolerance_hides_below_the_noise(label):
    unit = fvsight_unit(FVSightParameters(), 0)
    gap = gap_of(unit, label)
    usual, tight = unit.press(gap, 5.0), unit.press(gap, 5.0, tolerance=3e-6)
    frames = [unit.camera.clean(press.surface_modes) for press in (usual, tight)]
    assert np.abs(frames[0] - frames[1]).max() < 0.1
    assert np.abs(usual.taxel_load - tight.taxel_load).max() < 0.01


def test_unknown_parameters_are_refused():
    with pytest.raises(ValueError, match="tention"):
        FVSightParameters(tention_n_per_m=600)
