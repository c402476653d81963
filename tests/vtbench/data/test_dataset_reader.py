"""What is read is what was simulated, with our reader and with others'."""

import numpy as np
import pandas as pd
import pytest

from tests.vtbench.data import fakes
from vtbench.data import Dataset, write_dataset
from vtbench.data.png import decode_png, encode_png

TRUTH = ("displacement", "pressure", "contact")
N = 11


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    out = write_dataset(
        tmp_path_factory.mktemp("data") / "set",
        fakes.FakeScene(),
        samples=N,
        seed=5,
        truth=TRUTH,
        samples_per_shard=4,
        simulate=fakes.simulate,
        describe=fakes.describe,
    )
    return Dataset.open(out, verify="sha256")


@pytest.fixture(scope="module")
def recordings():
    return [fakes.simulate(fakes.FakeScene(), index, 5, TRUTH) for index in range(N)]


@pytest.mark.parametrize("indices", [None, [10, 0, 7, 7, 3], np.array([4]), []])
def test_arrays_come_back_unchanged_in_the_order_asked(dataset, recordings, indices):
    asked = list(range(N)) if indices is None else [int(i) for i in indices]
    for column in ("image", "image_rest"):
        frames = dataset.images(indices, column)
        assert frames.shape == (len(asked), fakes.SIZE, fakes.SIZE, 3)
        for frame, index in zip(frames, asked, strict=True):
            np.testing.assert_array_equal(frame, getattr(recordings[index], column))
    for column in ("force", "taxel_load"):
        for force, index in zip(dataset.force(indices, column), asked, strict=True):
            np.testing.assert_array_equal(force, getattr(recordings[index], column))
    for series, index in zip(dataset.force_series(indices), asked, strict=True):
        np.testing.assert_array_equal(series, recordings[index].force_series)
    for field in TRUTH:
        for grid, index in zip(dataset.truth(field, indices), asked, strict=True):
            np.testing.assert_array_equal(grid, recordings[index].truth[field])


def test_columns_hold_the_labels(dataset, recordings):
    frame = dataset.columns()
    assert len(frame) == len(dataset) == N
    assert "image" not in frame
    for key in ("object", "label", "press", "unit", "session", "seed", "pose_x_mm", "pose_deg"):
        assert list(frame[key]) == [recording.labels[key] for recording in recordings]
    assert list(frame["round"]) == [index // 4 for index in range(N)]
    assert [dataset.classes[label] for label in frame["label"]] == list(frame["object"])
    assert list(dataset.columns(["unit", "id"])) == ["unit", "id"]


def test_metadata_says_what_was_made(dataset):
    meta = dataset.meta
    assert meta.scene == fakes.FakeScene().model_dump()
    assert meta.sensor == fakes.describe(fakes.FakeScene())
    assert (meta.seed, meta.samples, meta.n_taxels, meta.rate_hz) == (5, N, 16, 1000.0)
    assert meta.truth == dict.fromkeys(TRUTH, (fakes.GRID, fakes.GRID))
    assert [shard.rows for shard in meta.shards] == [4, 4, 3]


def test_pandas_reads_a_shard_with_no_code_of_ours(dataset, recordings):
    frame = pd.read_parquet(dataset.path / "shard-00001.parquet")
    row, recording = frame.iloc[1], recordings[5]
    assert row["object"] == recording.labels["object"]
    assert row["force"].dtype == np.float32
    np.testing.assert_array_equal(row["force"], recording.force)
    np.testing.assert_array_equal(np.stack(list(row["force_series"])), recording.force_series)
    np.testing.assert_array_equal(np.stack(list(row["truth_pressure"])), recording.truth["pressure"])
    np.testing.assert_array_equal(decode_png(row["image"]["bytes"]), recording.image)


def test_pandas_reads_the_folder(dataset):
    assert len(pd.read_parquet([dataset.path / shard.name for shard in dataset.meta.shards])) == N


def test_png_is_lossless_and_rgb():
    image = np.zeros((5, 7, 3), np.uint8)
    image[..., 0], image[:, 3, 2] = 200, 9
    np.testing.assert_array_equal(decode_png(encode_png(image)), image)


@pytest.mark.parametrize("cut", [0, 4, -1])
def test_damaged_png_is_refused(cut):
    with pytest.raises(ValueError, match=r"no image|not PNG|truncated"):
        decode_png(encode_png(np.zeros((5, 7, 3), np.uint8))[:cut])


def test_unknown_columns_and_indices_are_refused(dataset):
    with pytest.raises(ValueError, match="no column 'forse'"):
        dataset.columns(["forse"])
    with pytest.raises(ValueError, match=r"sample indices must lie in 0\.\.10"):
        dataset.images([11])


def test_truth_that_was_not_stored_names_the_flag(tmp_path):
    out = write_dataset(tmp_path, fakes.FakeScene(), samples=2, simulate=fakes.simulate, describe=fakes.describe)
    with pytest.raises(ValueError, match="--truth pressure"):
        Dataset.open(out).truth("pressure")


def test_a_folder_without_a_dataset_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"nowhere: no dataset.json here"):
        Dataset.open(tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("text", "message"), [("{", "not readable as JSON"), ('{"schema_version": 1}', "dataset.json: kind: ")]
)
def test_a_damaged_dataset_json_is_one_line(tmp_path, text, message):
    (tmp_path / "dataset.json").write_text(text)
    with pytest.raises(ValueError, match=message) as failure:
        Dataset.open(tmp_path)
    assert "\n" not in str(failure.value)
