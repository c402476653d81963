"""A run killed at any moment, over and over: what was finished stays, and the end is that of one left alone."""

import json
import multiprocessing
import os
import time

import numpy as np
import pytest

from leaderboard.record import read_predictions, read_records, scan_records
from tests.vtbench.run import small
from vtbench.run import Suite, check_run, run_suite
from vtbench.run.features import DiskFeatures
from vtbench.run.folder import claim

KILLS = 20
DEAD = 2**30  # no process has this number
OBJECTS = ("battery-aa", "coin-1-euro", "pen-round")


@pytest.fixture(scope="module")
def context():
    """Fresh processes that have everything imported: a life is work, not imports."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(
        [
            "tests.vtbench.run.small",
            "vtbench.run.executor",
            "sensors.press",
            "vtbench.data.opening",
            "sklearn.neighbors",
        ]
    )
    return context


@pytest.fixture
def suite(tmp_path):
    """Simulated presses in two shards, features of frames, four cells: every part of a run."""
    data = {"id": "own", "scene": "fvsight-press", "samples": 30, "set": {"objects": OBJECTS}}
    entry = {
        "task": "objects/interference/v1",
        "variants": ["own"],
        "splits": ["random"],
        "modalities": ["force", "image"],
        "methods": ["knn", "wknn"],
        "probes": False,
    }
    content = {"id": "killed", "title": "it is killed", "backbone": "pixels", "datasets": [data], "entries": [entry]}
    path = tmp_path / "suite.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def finished(out):
    """Files that a later life must not touch: whole shards, features with their note, records with predictions."""
    done = {path.parent for path in out.glob("runs/*/record.json")}
    files = [path for folder in done for path in folder.iterdir() if not path.name.startswith(".")]
    files += out.glob("features/*.npy")
    files += out.glob("datasets/*/shard-*.parquet") if list(out.glob("datasets/*/dataset.json")) else []
    return {path.relative_to(out): (path.stat().st_mtime_ns, path.read_bytes()) for path in files}


def results(out):
    unlike = {"timing", "provenance"}
    records = {record.key: record.model_dump(exclude=unlike) for record in read_records(out)}
    return records, {key: read_predictions(out, key) for key in records}


def test_a_run_killed_before_its_first_file_was_whole_goes_on(presses, tmp_path):
    out = tmp_path / "run"
    for folder in (out, out / "features"):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f".suite.yaml.{DEAD}.tmp").write_text("id: sm")
    mine = out / "features" / f".a.npy.{os.getppid()}.tmp"
    mine.touch()
    (out / "features").rename(tmp_path / "kept")
    with claim(out, small.suite(presses)):
        assert sorted(path.name for path in out.iterdir()) == ["suite.yaml"]
    (tmp_path / "kept").rename(out / "features")
    with claim(out, small.suite(presses)):
        assert list((out / "features").iterdir()) == [mine], "what a living process writes is its own"


@pytest.mark.parametrize("damage", [b"", b"not an array", b"\x93NUMPY\x01\x00v\x00"])
def test_features_that_were_damaged_are_computed_again(tmp_path, damage):
    cache, identity = DiskFeatures(tmp_path), {"dataset": "a"}
    made = cache.cached(identity, 6, lambda rows: np.stack([rows, 2 * rows], 1).astype(np.float32))
    (path,) = tmp_path.glob("*.npy")
    whole = path.read_bytes()
    path.unlink()
    path.write_bytes(damage)
    again = cache.cached(identity, 6, lambda rows: np.stack([rows, 2 * rows], 1).astype(np.float32))
    np.testing.assert_array_equal(again, made)
    assert path.read_bytes() == whole


@pytest.mark.slow
def test_a_run_killed_at_twenty_moments_loses_nothing_and_ends_as_one_that_was_not(context, suite, tmp_path):
    def live(out, seconds=None):
        """Seconds that a run took, killed after some of them where it is not done by then, and whether it was."""
        process = context.Process(target=small.run_file, args=(suite, out, 1))
        started = time.monotonic()
        process.start()
        process.join(seconds)
        if running := process.is_alive():
            process.kill()
            process.join()
        else:
            assert process.exitcode == 0
        return time.monotonic() - started, running

    whole = tmp_path / "whole"
    assert live(whole)[1] is False
    records, predictions = results(whole)
    assert len(records) == 4
    assert all(record["status"]["state"] == "ok" for record in records.values())
    rng, kills, runs, stages = np.random.default_rng(0), 0, 0, set()
    full, _ = live(tmp_path / "again")
    while kills < KILLS:
        out, runs, killed = tmp_path / f"killed-{runs}", runs + 1, True
        before = {}
        while killed:
            _, killed = live(out, rng.uniform(0, full) if kills < KILLS else None)
            kills += killed
            now = finished(out)
            assert {path: now[path] for path in before} == before
            assert scan_records(out)[1] == [] if (out / "runs").is_dir() else True
            before = now
            stages.add(tuple(sorted({path.parts[0] for path in now})))
        ended, answers = results(out)
        assert ended == records
        for key, arrays in answers.items():
            assert arrays.keys() == predictions[key].keys()
            assert all(np.array_equal(array, predictions[key][name]) for name, array in arrays.items())
        assert check_run(out) == []
        assert not [path for path in out.rglob(".*.tmp")]
        assert run_suite(Suite.model_validate_json(suite.read_text()), out, progress=False).done == 0
    assert len(stages) > 2, "every kill fell into the same stage"
