"""Datasets of slides: what goes in comes out, the same bytes whoever writes them, and what is wrong is named."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sensors.slide import simulate_slide
from tests.vtbench.data.fake_slides import FakeSlipScene, simulate, simulate_and_die, simulate_false_onset
from vtbench.config import load_scene
from vtbench.data import Dataset, check_dataset
from vtbench.data.files import sha256_of
from vtbench.data.meta import read_meta
from vtbench.data.opening import open_dataset, write_scene
from vtbench.data.shards import one_thread
from vtbench.data.slide_reader import SlideDataset
from vtbench.data.slide_writer import write_slides

SCENE = FakeSlipScene(period=4)


def write(out, scene=SCENE, **settings):
    settings = {"simulate": simulate, "progress": False, "samples_per_shard": 5, **settings}
    return write_slides(out, scene, **settings)


@pytest.fixture(scope="module")
def slides(tmp_path_factory):
    return write(tmp_path_factory.mktemp("slides") / "set", frames=True)


def test_a_trial_comes_back_unchanged(slides):
    dataset = open_dataset(slides)
    assert isinstance(dataset, SlideDataset)
    assert check_dataset(slides) == []
    series = dataset.force_series()
    for index in (0, 4, 11):
        made = simulate(SCENE, index, 0, True)
        np.testing.assert_array_equal(series[index], made.force_series)
        np.testing.assert_array_equal(dataset.states([index])[0], made.state)
        assert dataset.onsets()[index] == made.onset_sample
        frames, times = dataset.frames(index)
        np.testing.assert_array_equal(frames, made.frames)
        np.testing.assert_allclose(times, made.frame_time_s)
    rows = dataset.columns()
    assert rows["kind"].tolist() == ["slide"] * 9 + ["load_change"] * 3
    assert rows["onset"].isna().tolist() == [False] * 9 + [True] * 3


def test_series_come_in_the_order_asked_for_one_shard_at_a_time(slides):
    dataset = SlideDataset.open(slides)
    wanted = [11, 10, 2, 0, 7]
    for index, series in zip(wanted, dataset.each_series(wanted), strict=True):
        np.testing.assert_array_equal(series, simulate(SCENE, index, 0).force_series)
    assert list(dataset.each_series([])) == []


def test_the_bytes_do_not_depend_on_jobs(tmp_path):
    one, two = write(tmp_path / "one"), write(tmp_path / "two", jobs=2)
    for path in sorted(one.glob("*.parquet")):
        assert sha256_of(path) == sha256_of(two / path.name)
    assert read_meta(one).hash == read_meta(two).hash


def test_a_writer_that_died_goes_on_and_ends_with_the_same_bytes(tmp_path):
    whole = read_meta(write(tmp_path / "whole")).hash
    broken = tmp_path / "broken"
    with pytest.raises(OSError, match="worker process died"):
        write(broken, simulate=simulate_and_die, jobs=2)
    assert not (broken / "dataset.json").exists()
    assert read_meta(write(broken)).hash == whole


def test_a_dataset_of_slides_is_no_dataset_of_presses(slides):
    with pytest.raises(ValueError, match="expected a dataset of presses, it holds slides"):
        Dataset.open(slides)


def test_an_onset_that_contradicts_the_state_is_refused(tmp_path):
    with pytest.raises(ValueError, match="sample 0: onset at sample"):
        write(tmp_path / "set", simulate=simulate_false_onset)


@pytest.mark.parametrize(
    ("column", "value", "problem"),
    [
        ("onset", 3, "not the first sample of gross slip in `state`"),
        ("state", [7] * 2400, r"a state outside 0\.\.2"),
        ("state", [0, 0], "not one state for each sample of force_series"),
    ],
)
def test_validation_names_shard_row_and_column(tmp_path, column, value, problem):
    out = write(tmp_path / "set")
    path = out / "shard-00001.parquet"
    table = pq.read_table(path, partitioning=None)
    cells = table[column].to_pylist()
    cells[2] = value
    at = table.schema.get_field_index(column)
    pq.write_table(table.set_column(at, table.schema.field(at), pa.array(cells, table.schema.field(at).type)), path)
    from collections import Counter

    from vtbench.data.checks import check_shard

    meta = read_meta(out)
    found = check_shard(path, meta.shards[1], meta, Counter())
    assert any(f"shard-00001.parquet, row 2 (id '000007'), column {column!r}: " in line for line in found)
    import re

    assert any(re.search(problem, line) for line in found), found


def test_the_sensors_own_slides_pass_through_the_door(tmp_path):
    scene = load_scene("fvsight-slip", {"motion.rest_s": 0.5, "motion.rest_jitter_s": 0.1, "motion.move_s": 0.2})
    out = write_scene(tmp_path / "set", scene, samples=2, seed=3, progress=False)
    assert check_dataset(out) == []
    dataset = SlideDataset.open(out)
    with one_thread():
        made = simulate_slide(scene, 1, 3)
    np.testing.assert_array_equal(dataset.force_series([1])[0], made.force_series)
    assert dataset.onsets()[1] == made.onset_sample
    assert dataset.meta.scene == scene.model_dump(mode="json")


def test_what_a_scene_cannot_store_is_refused(tmp_path):
    with pytest.raises(ValueError, match="keeps its state and onset"):
        write_scene(tmp_path / "a", load_scene("fvsight-slip"), truth=("pressure",))
    with pytest.raises(ValueError, match="has its frame anyway"):
        write_scene(tmp_path / "b", load_scene("fvsight-press"), frames=True)
