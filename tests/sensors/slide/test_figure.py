"""The picture of a trial: written, and different where the trial differs."""

import numpy as np
import pytest
from matplotlib.image import imread

from sensors.slide import SlideRecording, draw_slide

LABELS = {
    "object": "ball", "kind": "slide", "load_n": 5.0, "speed_mm_s": 10.0, "direction_deg": 0.0, "rotation_deg_s": 0.0,
    "trial": 3, "unit": 0,
}  # fmt: skip


def trial(state, **more):
    series = np.tile(np.linspace(0, 2, len(state), dtype=np.float32)[:, None], (1, 16)) * np.arange(16) / 16
    onset = np.flatnonzero(state == 2)
    return SlideRecording(
        series.astype(np.float32), 1000.0, state, int(onset[0]) if len(onset) else None, LABELS, **more
    )


STATE = np.repeat([0, 1, 2, 0], [300, 30, 300, 200]).astype(np.uint8)


@pytest.mark.parametrize("with_slip", [False, True])
@pytest.mark.parametrize("with_frames", [False, True])
def test_a_trial_is_drawn_with_what_it_has(tmp_path, with_slip, with_frames):
    more = {"truth": {"slip_distance": np.linspace(0, 3e-3, len(STATE))}} if with_slip else {}
    if with_frames:
        more |= {"frames": np.full((10, 32, 32, 3), 90, np.uint8), "frame_time_s": np.arange(10) / 30}
    picture = imread(draw_slide(trial(STATE, **more), tmp_path / "trial.png"))
    assert picture.ndim == 3
    assert picture[..., :3].std() > 0.05


def test_the_states_are_seen(tmp_path):
    slipping = imread(draw_slide(trial(STATE), tmp_path / "slip.png"))
    resting = imread(draw_slide(trial(np.zeros_like(STATE)), tmp_path / "rest.png"))
    assert slipping.shape == resting.shape
    assert np.abs(slipping - resting).mean() > 0.01
