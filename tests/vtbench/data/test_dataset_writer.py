"""Same seed, same bytes: whatever the number of jobs, the kills and the resumes."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.vtbench.data import fakes
from vtbench.data import Dataset, write_dataset
from vtbench.data.format import META_FILE, PARTIAL_FILE
from vtbench.data.meta import first_difference

ROOT = Path(__file__).resolve().parents[3]


def write(out, *, scene=None, seed=3, jobs=1, simulate=fakes.simulate, **more):
    return write_dataset(
        out,
        scene or fakes.FakeScene(),
        seed=seed,
        jobs=jobs,
        samples_per_shard=4,
        simulate=simulate,
        describe=fakes.describe,
        **more,
    )


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    return contents(write(tmp_path_factory.mktemp("reference") / "set"))


def test_two_jobs_give_the_bytes_of_one(tmp_path, reference):
    assert contents(write(tmp_path / "set", jobs=2)) == reference


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_killed_run_goes_on_and_ends_with_the_same_bytes(tmp_path, reference, jobs):
    out = tmp_path / "set"
    code = (
        "from tests.vtbench.data import fakes; from vtbench.data import write_dataset; "
        f"write_dataset({str(out)!r}, fakes.FakeScene(), seed=3, jobs={jobs}, samples_per_shard=4, "
        "simulate=fakes.simulate_slowly, describe=fakes.describe)"
    )
    child = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, start_new_session=True)
    while not any(out.glob("shard-*.parquet")):
        assert child.poll() is None
        time.sleep(0.01)
    time.sleep(0.1)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    assert not (out / META_FILE).exists()
    whole = {path: path.stat().st_mtime_ns for path in sorted(out.glob("shard-*.parquet"))[:1]}
    assert contents(write(out, jobs=jobs)) == reference
    assert all(path.stat().st_mtime_ns == written for path, written in whole.items())


def test_a_finished_dataset_is_left_alone(tmp_path):
    out = write(tmp_path / "set")
    before = {path: path.stat().st_mtime_ns for path in out.iterdir()}
    write(out)
    assert {path: path.stat().st_mtime_ns for path in out.iterdir()} == before


def test_a_damaged_shard_is_made_again(tmp_path, reference):
    out = write(tmp_path / "set")
    (out / "shard-00002.parquet").write_bytes(b"PAR1")
    (out / "shard-00003.parquet").unlink()
    assert contents(write(out)) == reference


def test_a_fresh_run_replaces_another_plan(tmp_path, reference):
    out = write(tmp_path / "set", seed=4, samples=30)
    assert contents(write(out, resume=False)) == reference


@pytest.mark.parametrize("finished", [True, False])
def test_another_plan_is_refused_and_nothing_is_lost(tmp_path, finished):
    out = write(tmp_path / "set")
    if not finished:
        meta = Dataset.open(out).meta
        partial = f'{{"plan": {meta.plan.model_dump_json()}, "shards": []}}'
        (out / PARTIAL_FILE).write_text(partial)
        (out / META_FILE).unlink()
    before = contents(out)
    with pytest.raises(ValueError, match=r"holds another dataset \(seed is 3 there, 4 asked\)"):
        write(out, seed=4)
    with pytest.raises(ValueError, match=r"scene.settings.load_n is 5.0 there, 6.0 asked"):
        write(out, scene=fakes.FakeScene(settings={"load_n": 6.0}))
    assert contents(out) == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"samples": -3}, "samples: expected at least 1, got -3"),
        ({"samples": 0}, "samples: expected at least 1, got 0"),
        ({"seed": -1}, "seed: expected 0 or more, got -1"),
        ({"jobs": 0}, "jobs: expected at least 1"),
        ({"truth": ("presure",)}, "truth: unknown field 'presure'"),
    ],
)
def test_arguments_out_of_range_write_nothing(tmp_path, arguments, message):
    with pytest.raises(ValueError, match=message):
        write(tmp_path / "set", **arguments)
    assert not (tmp_path / "set").exists()


def test_an_unwritable_folder_is_named(tmp_path):
    (tmp_path / "file").write_text("here first")
    with pytest.raises(OSError, match=r"file/set: cannot write here \(Not a directory\)"):
        write(tmp_path / "file" / "set")
    assert (tmp_path / "file").read_text() == "here first"


def test_a_folder_with_other_things_is_refused(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(ValueError, match="not empty and holds no dataset"):
        write(tmp_path)
    assert contents(tmp_path) == {"thesis.tex": b"precious"}


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize(
    ("simulate", "message"),
    [
        (fakes.simulate_and_fail, "fake-press, sample 9: ZeroDivisionError: no contact anywhere"),
        (fakes.simulate_nan_force, "fake-press, sample 9: force is not finite at taxel 3"),
    ],
)
def test_a_sample_that_fails_is_named_and_the_rest_can_go_on(tmp_path, jobs, simulate, message, reference):
    out = tmp_path / "set"
    with pytest.raises(ValueError, match=re.escape(message)) as failure:
        write(out, jobs=jobs, simulate=simulate)
    assert str(failure.value) == message
    assert not list(out.glob(".*"))
    assert not (out / META_FILE).exists()
    assert contents(write(out)) == reference


def test_a_worker_that_dies_is_reported_in_one_line(tmp_path):
    with pytest.raises(OSError, match="a worker process died") as failure:
        write(tmp_path / "set", jobs=2, simulate=fakes.simulate_and_die)
    assert "\n" not in str(failure.value)


def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch, reference):
    from vtbench.data import shards

    real = shards.write_parquet

    def full(table, path):
        if "00003" in path.name:
            path.write_bytes(b"PAR1")
            raise OSError(28, "No space left on device")
        real(table, path)

    out = tmp_path / "set"
    with monkeypatch.context() as patch:
        patch.setattr(shards, "write_parquet", full)
        with pytest.raises(OSError, match="No space left on device"):
            write(out)
    assert sorted(path.name for path in out.glob("*.parquet")) == [f"shard-0000{i}.parquet" for i in range(3)]
    assert contents(write(out)) == reference


def test_two_writers_do_not_share_a_folder(tmp_path):
    from vtbench.data.files import only_writer

    out = write(tmp_path / "set", samples=8)
    with only_writer(out), pytest.raises(OSError, match="another process is writing"):
        write(out, samples=8)


def test_a_difference_of_lists_is_named_and_not_quoted_at_length():
    assert first_difference({"columns": ["id", "image"]}, {"columns": ["id", "image"]}) is None
    assert first_difference({"columns": ["id", "truth"]}, {"columns": ["id"]}) == "columns has truth there"
    assert first_difference({"columns": ["id"]}, {"columns": ["id", "truth"]}) == "columns lacks truth there"
    assert first_difference({"order": [1, 2]}, {"order": [2, 1]}) == "order is [1,2] there, [2,1] asked"
