"""A dataset in LeRobot's layout: the documented files, and nothing lost or moved between them."""

import json

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from tests.vtbench.data import fake_slides, fakes
from vtbench.data import Dataset, SlideDataset, write_dataset, write_slides
from vtbench.data.lerobot import write_lerobot
from vtbench.data.png import decode_png

IMAGE, FORCE, STATE = "observation.images.camera", "observation.force", "observation.slip_state"
COUNTERS = {"timestamp", "frame_index", "episode_index", "index", "task_index"}


@pytest.fixture(scope="module")
def presses(tmp_path_factory):
    folder = tmp_path_factory.mktemp("presses") / "set"
    scene = fakes.FakeScene()
    made = write_dataset(
        folder, scene, samples=7, samples_per_shard=3, simulate=fakes.simulate, describe=fakes.describe
    )
    return Dataset.open(made)


def slides(folder, **more):
    return SlideDataset.open(
        write_slides(folder, fake_slides.FakeSlipScene(), samples=3, simulate=fake_slides.simulate, **more)
    )


def read(root):
    """info, tasks, rows of the episodes, rows of the frames in the order of the files."""
    info = json.loads((root / "meta/info.json").read_text())
    tasks = pd.read_parquet(root / "meta/tasks.parquet")
    rows = pd.concat([pd.read_parquet(path) for path in sorted((root / "meta/episodes").glob("*/*.parquet"))])
    frames = pd.concat([pd.read_parquet(path) for path in sorted((root / "data").glob("*/*.parquet"))])
    return info, tasks, rows, frames


@pytest.mark.parametrize("file_mb", [100, 0.001])
def test_counts_and_places_agree_between_the_files(presses, tmp_path, file_mb):
    root = write_lerobot(presses, tmp_path / "out", file_mb=file_mb)
    info, tasks, rows, frames = read(root)
    assert info["codebase_version"] == "v3.0"
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (7, 14, len(fakes.OBJECTS))
    assert (len(rows), len(frames), len(tasks)) == (7, 14, len(fakes.OBJECTS))
    assert set(info["features"]) == {IMAGE, FORCE} | COUNTERS == set(frames.columns)
    assert list(frames["index"]) == list(range(14))
    np.testing.assert_allclose(frames["timestamp"], frames["frame_index"] / info["fps"])
    for row in rows.itertuples():
        own = frames.iloc[row.dataset_from_index : row.dataset_to_index]
        assert len(own) == row.length
        assert set(own["episode_index"]) == {row.episode_index}
        assert list(tasks["task_index"][list(row.tasks)]) == [own["task_index"].iloc[0]]
        place = {
            key: getattr(row, f"_{rows.columns.get_loc(f'data/{key}') + 1}") for key in ("chunk_index", "file_index")
        }
        there = pq.read_table(root / info["data_path"].format(**place))["episode_index"].to_pylist()
        assert there.count(row.episode_index) == row.length
    files = len(list((root / "data").glob("*/*.parquet")))
    assert files == (1 if file_mb == 100 else 7)


def test_frames_hold_what_was_recorded(presses, tmp_path):
    info, _, rows, frames = read(write_lerobot(presses, tmp_path / "out"))
    images = np.stack([decode_png(cell["bytes"]) for cell in frames[IMAGE]])
    np.testing.assert_array_equal(images[::2], presses.images(column="image_rest"))
    np.testing.assert_array_equal(images[1::2], presses.images())
    np.testing.assert_array_equal(np.stack(frames[FORCE])[1::2], presses.force())
    np.testing.assert_array_equal(np.stack(frames[FORCE])[::2], [series[0] for series in presses.force_series()])
    assert info["features"][IMAGE]["shape"] == [*presses.meta.image_size, 3]
    told = presses.columns(["id", "object", "unit"])
    assert list(rows["recording"]) == list(told["id"])
    assert [task for (task,) in rows["tasks"]] == [f"press {name}" for name in told["object"]]
    assert list(rows["unit"]) == list(told["unit"])


def test_statistics_are_those_of_all_frames(presses, tmp_path):
    root = write_lerobot(presses, tmp_path / "out")
    stats = json.loads((root / "meta/stats.json").read_text())
    _, _, rows, frames = read(root)
    force = np.stack(frames[FORCE]).astype(float)
    image = np.stack([decode_png(cell["bytes"]) for cell in frames[IMAGE]]) / 255.0
    for name, values, axis in ((FORCE, force, 0), (IMAGE, image, (0, 1, 2))):
        for key in ("min", "max", "mean", "std"):
            expected = getattr(np, key)(values, axis=axis)
            expected = expected.reshape(3, 1, 1) if name == IMAGE else expected
            np.testing.assert_allclose(stats[name][key], expected, rtol=1e-9, atol=1e-9)
        assert stats[name]["count"] == [14]
    np.testing.assert_allclose(rows[f"stats/{FORCE}/mean"].iloc[3], force[6:8].mean(axis=0))


def test_slides_run_at_the_rate_of_their_camera(tmp_path):
    dataset = slides(tmp_path / "set", frames=True)
    info, _, _, frames = read(write_lerobot(dataset, tmp_path / "out"))
    pictures, times = dataset.frames(1)
    own = frames[frames["episode_index"] == 1]
    assert info["fps"] == 30
    np.testing.assert_array_equal([decode_png(cell["bytes"]) for cell in own[IMAGE]], pictures)
    at = np.floor(times * dataset.meta.rate_hz + 1e-6).astype(int)
    np.testing.assert_array_equal(np.stack(own[FORCE]), dataset.force_series([1])[0][at])
    np.testing.assert_array_equal(own[STATE], dataset.states([1])[0][at])


def test_slides_without_frames_keep_every_sample_of_their_forces(tmp_path):
    dataset = slides(tmp_path / "set")
    info, _, _, frames = read(write_lerobot(dataset, tmp_path / "out"))
    assert info["fps"] == dataset.meta.rate_hz
    assert IMAGE not in info["features"]
    np.testing.assert_array_equal(np.stack(frames[FORCE]), np.concatenate(dataset.force_series()))
    np.testing.assert_array_equal(frames[STATE], np.concatenate(dataset.states()))


def test_the_output_is_whole_or_absent(presses, tmp_path):
    root = write_lerobot(presses, tmp_path / "out")
    before = {path: path.read_bytes() for path in root.rglob("*") if path.is_file()}
    with pytest.raises(ValueError, match="expected a new or empty folder"):
        write_lerobot(presses, root)
    (presses.path / "shard-00002.parquet").rename(presses.path / "away")
    try:
        with pytest.raises(OSError, match="shard-00002"):
            write_lerobot(presses, tmp_path / "other")
    finally:
        (presses.path / "away").rename(presses.path / "shard-00002.parquet")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    again = write_lerobot(presses, tmp_path / "again")
    assert {again / path.relative_to(root): data for path, data in before.items()} == {
        path: path.read_bytes() for path in again.rglob("*") if path.is_file()
    }


def test_the_command_says_what_came(vtbench, presses, tmp_path):
    answer = vtbench("convert", presses.path, "--to", "lerobot", "-o", tmp_path / "out")
    assert answer.code == 0
    assert answer.out.startswith(f"{tmp_path / 'out'}: LeRobot v3.0, 7 episodes, 14 frames, 4 tasks")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("nowhere", "--to", "lerobot"), "no dataset.json here"),
        (("nowhere", "--to", "lerobto"), "unknown layout 'lerobto'; did you mean 'lerobot'?"),
    ],
)
def test_the_command_refuses_in_one_line(refused, tmp_path, words, message):
    assert message in refused("convert", *words, "-o", tmp_path / "out")
