"""The sensors' own recordings through the writer and back."""

import os
import subprocess
import sys

import numpy as np
import pytest

from sensors import PressScene, objects, simulate
from sensors.sensor_card import describe
from vtbench.data import Dataset, check_dataset, write_dataset
from vtbench.data.shards import one_thread

TRUTH = ("displacement", "pressure", "contact")


@pytest.fixture(scope="module")
def scene():
    return PressScene(id="two-objects", title="two objects", objects=objects.names()[:2])


def test_a_simulated_press_comes_back_unchanged(tmp_path, scene):
    out = write_dataset(tmp_path / "set", scene, samples=3, seed=7, truth=TRUTH)
    assert check_dataset(out) == []
    dataset = Dataset.open(out)
    assert dataset.meta.sensor == describe(scene)
    assert dataset.meta.scene == scene.model_dump(mode="json")
    with one_thread():
        recording = simulate(scene, 2, 7, TRUTH)
    np.testing.assert_array_equal(dataset.images([2])[0], recording.image)
    np.testing.assert_array_equal(dataset.images([2], "image_rest")[0], recording.image_rest)
    np.testing.assert_array_equal(dataset.force([2])[0], recording.force)
    np.testing.assert_array_equal(dataset.force([2], "taxel_load")[0], recording.taxel_load)
    np.testing.assert_array_equal(dataset.force_series([2])[0], recording.force_series)
    for field in TRUTH:
        np.testing.assert_allclose(dataset.truth(field, [2])[0], recording.truth[field], rtol=1e-6)
    row = dataset.columns().iloc[2]
    for key in ("id", "object", "label", "press", "unit", "session", "round", "seed", "pose_deg"):
        assert row[key] == recording.labels[key]


@pytest.mark.slow
def test_presses_have_the_same_bytes_for_one_and_two_jobs(tmp_path, scene):
    folders = [
        write_dataset(tmp_path / str(jobs), scene, samples=16, seed=7, jobs=jobs, samples_per_shard=4)
        for jobs in (1, 2)
    ]
    first, second = ({path.name: path.read_bytes() for path in folder.iterdir()} for folder in folders)
    assert first == second


@pytest.mark.slow
@pytest.mark.parametrize("threads", ["1", "2", "4"])
def test_the_threads_that_the_environment_allows_do_not_change_the_bytes(tmp_path, scene, threads):
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    code = (
        "from pathlib import Path; from sensors import PressScene; from vtbench.data import write_dataset; "
        f"scene = PressScene.model_validate_json({scene.model_dump_json()!r}); "
        f"write_dataset({str(tmp_path / 'child')!r}, scene, samples=4, seed=7)"
    )
    subprocess.run([sys.executable, "-c", code], env={**os.environ, **dict.fromkeys(names, threads)}, check=True)
    here = write_dataset(tmp_path / "here", scene, samples=4, seed=7)
    assert Dataset.open(tmp_path / "child").hash == Dataset.open(here).hash
