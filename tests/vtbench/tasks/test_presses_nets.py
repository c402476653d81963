"""Pixels and force histories as nets take them, and which feeds go with which methods."""

import numpy as np
import pytest

from tests.vtbench.data import fakes
from vtbench.commands.check import suite_problems
from vtbench.data import Dataset, write_dataset
from vtbench.run.features import DiskFeatures
from vtbench.run.methods import METHODS
from vtbench.run.suite import Suite
from vtbench.tasks import TASKS, presses
from vtbench.tasks.base import NotPossibleError
from vtbench.tasks.presses import STEPS, change, in_steps


class Mean:
    """A network that gives the mean colour."""

    weights_sha256 = "f00"

    def extract(self, images):
        return images.reshape(len(images), -1, 3).mean(1).astype(np.float32)


def write(folder):
    return write_dataset(
        folder, fakes.FakeScene(), samples=26, seed=0, simulate=fakes.simulate, describe=fakes.describe
    )


def load(task, folder, features):
    return TASKS.get(f"objects/{task}/v1").load(folder, DiskFeatures(features), "mean")


def test_a_history_in_steps_keeps_its_mean_and_constant_and_counts_every_sample_alike():
    rng = np.random.default_rng(0)
    for length in (3, 32, 50, 1000):
        series = rng.normal(size=(length, 5))
        got = in_steps([series], 32).reshape(32, 5)
        np.testing.assert_allclose(got.mean(0), series.mean(0), atol=1e-6)
        np.testing.assert_allclose(in_steps([np.full((length, 2), 3.0)], 32), 3.0, rtol=1e-6)
    series = rng.normal(size=(96, 4))
    np.testing.assert_allclose(in_steps([series], 32).reshape(32, 4), series.reshape(32, 3, 4).mean(1), atol=1e-6)
    quick = np.sin(2 * np.pi * np.arange(1024) * 32 / 1024)[:, None]  # the step rate itself would alias to a constant
    assert np.abs(in_steps([quick], 32)).max() < 1e-6
    with pytest.raises(NotPossibleError, match="history"):
        in_steps([np.zeros((0, 4))], 32)


def test_pixels_and_histories_are_those_of_the_presses(tmp_path, monkeypatch):
    path = write(tmp_path / "set")
    shown = []
    monkeypatch.setattr(presses, "_backbone", lambda name: shown.append(name) or Mean())
    data, dataset = load("interference", path, tmp_path / "features"), Dataset.open(path)
    frames, rest = dataset.images(), dataset.images(column="image_rest")
    np.testing.assert_array_equal(data.block("pixels"), Mean().extract(frames))
    np.testing.assert_array_equal(data.block("pixels-change"), Mean().extract(change(frames, rest)))
    assert set(shown) == {"pixels"}
    assert data.feature_us("pixels-change") > 0
    np.testing.assert_array_equal(data.block("force-series"), in_steps(dataset.force_series(), STEPS))


def test_a_suite_that_names_no_modality_runs_none_of_the_nets_feeds_and_nets_take_only_those():
    task = TASKS.get("objects/deep/v1")
    by_name = {name for name, feed in task.modalities.items() if feed.by_name}
    assert by_name == {name for name, feed in task.modalities.items() if feed.shaped}
    late = METHODS.get("late-fusion")
    assert {name for name, feed in task.modalities.items() if late.takes(feed)} == by_name
    assert not METHODS.get("jksc").takes(task.feed("force-series"))
    suite = Suite.model_validate(
        {
            "id": "wrong",
            "title": "a net fed with features",
            "datasets": [{"id": "paper", "scene": "fvsight-press"}],
            "entries": [{"task": task.id, "variants": ["paper"], "modalities": ["fused"], "methods": ["late-fusion"]}],
        }
    )
    (problem,) = suite_problems(suite)
    assert "not from 'fused'" in problem
    assert "fused-pixels-change" in problem
