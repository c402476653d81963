"""Where samples come from: datasets of the suite, public recordings, features kept on disk."""

import json

import numpy as np
import pytest

from leaderboard.record import read_records
from tests.vtbench.run import small
from vtbench.run import run_suite
from vtbench.run.features import CHUNK, DiskFeatures
from vtbench.run.sources import find_sources, prepare_datasets
from vtbench.run.suite import Suite

TEXTURE = {
    "task": "texture/fabricslide16/v1",
    "variants": ["public"],
    "splits": ["random"],
    "modalities": ["spectrum"],
    "methods": ["knn"],
    "probes": False,
}


@pytest.fixture
def no_recordings(tmp_path, monkeypatch):
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("VTBENCH_DATA", str(tmp_path / "data"))


@pytest.mark.usefixtures("no_recordings")
def test_rows_of_recordings_that_are_not_here_name_the_command_that_brings_them(presses, tmp_path):
    suite = small.suite(presses)
    suite = Suite.model_validate({**suite.model_dump(), "entries": [TEXTURE, *suite.model_dump()["entries"]]})
    summary = run_suite(suite, tmp_path / "run", progress=False)
    (skipped,) = [record for record in summary.records if record.identity.task == TEXTURE["task"]]
    assert skipped.status.state == "skipped"
    assert "`vtbench fetch fabricslide16`" in skipped.status.reason
    assert "\n" not in skipped.status.reason
    assert skipped.identity.kind == "real"
    assert (summary.total, summary.skipped, summary.failed) == (3, 1, 0)
    assert run_suite(suite, tmp_path / "run", progress=False).done == 0


@pytest.mark.usefixtures("no_recordings")
def test_a_skipped_row_runs_when_its_recordings_have_come_and_has_the_same_key(tmp_path):
    suite = Suite.model_validate({"id": "t", "title": "t", "entries": [TEXTURE]})
    (before,) = run_suite(suite, tmp_path / "run", progress=False).records
    rng = np.random.default_rng(0)
    folder = tmp_path / "data/fabricslide16/data/fabric"
    folder.mkdir(parents=True)
    names = ["timestamp", "proximity1", "proximity2", *(f"channel{i}" for i in range(1, 17))]
    for fabric in ("Canvas", "Linen"):
        for number in range(12):
            rows = [",".join(names), *(",".join(map(str, row)) for row in rng.integers(0, 999, (150, 19)))]
            (folder / f"{fabric}_F120_V10mmps_{number}.csv").write_text("\n".join(rows) + "\n")
    again = run_suite(suite, tmp_path / "run", progress=False)
    (after,) = again.records
    assert (again.done, after.status.state, after.key) == (1, "ok", before.key)
    assert run_suite(suite, tmp_path / "run", progress=False).done == 0
    assert len(read_records(tmp_path / "run")) == 1


def simulated(**changes):
    spec = {"id": "own", "scene": "fvsight-press", "samples": 2, **changes}
    entry = {"task": "objects/deep/v1", "variants": ["own"], "methods": ["knn"]}
    return Suite.model_validate({"id": "s", "title": "s", "datasets": [spec], "entries": [entry]})


@pytest.fixture(scope="module")
def two_presses(tmp_path_factory):
    out = tmp_path_factory.mktemp("simulated")
    prepare_datasets(simulated(), out, 1, False)
    return out


def test_a_finished_dataset_is_not_written_again(two_presses):
    files = {path: path.stat().st_mtime_ns for path in two_presses.rglob("*.*")}
    assert {path.name for path in files} >= {"dataset.json", "shard-00000.parquet"}
    before = find_sources(simulated(), two_presses)
    prepare_datasets(simulated(), two_presses, 1, False)
    assert {path: path.stat().st_mtime_ns for path in two_presses.rglob("*.*")} == files
    assert find_sources(simulated(), two_presses) == before


@pytest.mark.parametrize("change", [{"samples": 3}, {"seed": 1}, {"scene": "fvsight-press/hard"}])
def test_a_dataset_changed_in_the_suite_is_refused_and_not_silently_the_old_one(two_presses, change):
    with pytest.raises(ValueError, match="own"):
        prepare_datasets(simulated(**change), two_presses, 1, False)


def test_one_protocol_on_two_datasets_gives_the_cells_of_both(tmp_path):
    one, two = (small.write(tmp_path / name, seed=seed) for name, seed in (("a", 1), ("b", 2)))
    suite = small.suite(one).model_dump()
    entries = [{**suite["entries"][0], "variants": {"own": name}, "splits": ["random"]} for name in ("a", "b")]
    datasets = [{"id": "a", "path": str(one)}, {"id": "b", "path": str(two)}]
    summary = run_suite(
        Suite.model_validate({**suite, "datasets": datasets, "entries": entries}), tmp_path / "run", progress=False
    )
    assert {record.identity.dataset for record in summary.records} == {"a", "b"}


def test_an_unused_dataset_is_not_made(tmp_path):
    suite = simulated()
    more = Suite.model_validate(
        {
            **suite.model_dump(),
            "datasets": [{"id": "own", "path": "nowhere"}, suite.datasets[0].model_dump() | {"id": "x"}],
        }
    )
    with pytest.raises(ValueError, match="nowhere"):
        prepare_datasets(more, tmp_path, 1, False)
    assert not (tmp_path / "datasets").exists()


class Rows:
    """Features that say which row they are of, and keep count."""

    def __init__(self, factor=1.0):
        self.factor = factor
        self.calls = 0

    def __call__(self, rows):
        self.calls += 1
        return (np.stack([rows, rows**2], 1) * self.factor).astype(np.float32)


N = 2 * CHUNK + 7


def test_kept_features_are_not_computed_again(tmp_path):
    compute = Rows()
    first = DiskFeatures(tmp_path).cached({"dataset": "a"}, N, compute)
    np.testing.assert_array_equal(first, compute(np.arange(N)))
    calls = compute.calls
    again = DiskFeatures(tmp_path).cached({"dataset": "a"}, N, compute)
    np.testing.assert_array_equal(again, first)
    assert compute.calls == calls
    assert again.dtype == np.float32


def test_features_of_something_else_are_computed(tmp_path):
    cache = DiskFeatures(tmp_path)
    one = cache.cached({"dataset": "a", "frames": "image"}, N, Rows())
    for identity in ({"dataset": "b", "frames": "image"}, {"dataset": "a", "frames": "rest"}):
        other = Rows(2.0)
        np.testing.assert_array_equal(cache.cached(identity, N, other), 2 * one)
        assert other.calls
    same = Rows(2.0)
    np.testing.assert_array_equal(cache.cached({"frames": "image", "dataset": "a"}, N, same), one)
    assert not same.calls


@pytest.mark.parametrize("left", ["matrix only", "note only", "fewer rows"])
def test_features_that_are_not_whole_are_computed_again(tmp_path, left):
    DiskFeatures(tmp_path).cached({"dataset": "a"}, N - 1 if left == "fewer rows" else N, Rows())
    if left != "fewer rows":
        (lost,) = tmp_path.glob("*.json" if left == "matrix only" else "*.npy")
        lost.unlink()
    compute = Rows()
    got = DiskFeatures(tmp_path).cached({"dataset": "a"}, N, compute)
    assert compute.calls
    np.testing.assert_array_equal(got[:, 0], np.arange(N))


def test_the_time_a_sample_took_is_kept_beside_them(tmp_path):
    cache = DiskFeatures(tmp_path)
    assert cache.us_per_sample({"dataset": "a"}) is None
    cache.cached({"dataset": "a"}, N, Rows())
    assert cache.us_per_sample({"dataset": "a"}) > 0
    (note,) = tmp_path.glob("*.json")
    assert json.loads(note.read_text())["rows"] == N
