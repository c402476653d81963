"""False alarms at rest: asked beside measured; detectors that look need frames."""

import json

import numpy as np
import pytest

import slip
from vtbench.run.detection.at_rest import rest_rates
from vtbench.run.detection.looking import frames_of, trial_scores
from vtbench.tasks.base import NotPossibleError


def predictions(note, alarms=(2, 0, 4), samples=(1000, 1000, 0)):
    return {"rest": np.stack([alarms, samples], axis=1), "choices": np.array([json.dumps(note)] * 2)}


def test_the_rate_at_rest_is_alarms_over_samples_within_its_interval():
    (only,) = rest_rates(predictions({"beta": 1.0}))
    assert only.name == "rest_rate"
    assert only.value == pytest.approx(2 / 2000)
    assert only.low <= only.value <= only.high
    assert only.n == 2  # a trial without a settled rest says nothing


def test_what_cfar_was_asked_stands_beside_it_and_old_predictions_have_none():
    note = {"asked": [0.001, 0.0008, 0.0013], "rest": [0.004, 0.002, 0.006], "coloured": True}
    found = {metric.name: metric for metric in rest_rates(predictions(note))}
    assert found["asked_rate"].value == pytest.approx(0.001)
    assert found["training_rest_rate"].high == pytest.approx(0.006)
    assert found["coloured"].value == 1.0
    assert list(rest_rates({"choices": np.array(["{}"])})) == []


class Blind:
    """Trials without frames."""

    def frames(self, trial):
        return np.empty((0, 0, 0, 3), np.uint8), np.empty(0)


def test_a_detector_of_forces_asks_for_no_frames_and_one_that_looks_says_what_is_missing():
    force = np.random.default_rng(0).standard_normal((60, 4))
    detector = slip.make_detector("energy")
    np.testing.assert_array_equal(trial_scores(detector, Blind(), 0, force), detector.score(force))
    with pytest.raises(NotPossibleError, match="without frames"):
        trial_scores(slip.make_detector("neural-force-frames"), Blind(), 0, force)
    with pytest.raises(NotPossibleError, match="without frames"):
        frames_of(Blind(), 0)
