"""What is finished is never done again, and what is killed goes on to the same records."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from leaderboard.record import read_predictions, read_records, record_key, write_record
from leaderboard.submission import Submission
from tests.vtbench.run import small
from vtbench.run import check_run, run_suite
from vtbench.run.folder import claim

FOLDS = 10 + 3  # random draws, units held out


def run(suite, out, **options):
    return run_suite(suite, out, progress=False, **options)


@pytest.fixture
def counted(presses, log):
    """A suite with a classifier that counts its fits and a built-in one: four cells."""
    return small.suite(presses, ["knn", "mine"], {"mine": small.own("Nearest", log=log.path)})


def contents(out):
    return {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in out.glob("runs/*/*")}


def key_of(summary, method, split):
    (key,) = [r.key for r in summary.records if (r.identity.method, r.identity.split) == (method, split)]
    return key


def same_results(one, other):
    """Records of two runs are equal but for time and place, predictions to the bit."""
    left, right = ({r.key: r for r in read_records(out)} for out in (one, other))
    assert left.keys() == right.keys()
    assert left
    for key, record in left.items():
        unlike = {"timing", "provenance"}
        assert record.model_dump(exclude=unlike) == right[key].model_dump(exclude=unlike)
        a, b = read_predictions(one, key), read_predictions(other, key)
        assert a.keys() == b.keys()
        for name in a:
            np.testing.assert_array_equal(a[name], b[name], err_msg=name)


def test_a_finished_key_is_never_run_again(counted, log, tmp_path):
    first = run(counted, tmp_path / "run")
    assert (first.total, first.done, first.kept) == (4, 4, 0)
    assert set(small.states(first).values()) == {"ok"}
    assert log() == FOLDS
    before = contents(tmp_path / "run")

    again = run(counted, tmp_path / "run")
    assert (again.total, again.done, again.kept) == (4, 0, 4)
    assert again.records == first.records
    assert "nothing to do" in again.lines()[0]
    assert log() == FOLDS
    assert contents(tmp_path / "run") == before
    assert check_run(tmp_path / "run") == []


@pytest.mark.parametrize("damage", ["gone", "cut", "not its key", "no predictions", "empty predictions"])
def test_only_the_cell_whose_record_is_missing_or_broken_runs_again(counted, log, tmp_path, damage):
    out = tmp_path / "run"
    first = run(counted, out)
    record = out / "runs" / key_of(first, "mine", "held-out-unit") / "record.json"
    other = out / "runs" / key_of(first, "knn", "random") / "record.json"
    text = record.read_bytes()
    if damage == "gone":
        record.unlink()
    elif damage.endswith("predictions"):
        record.with_name("predictions.npz").unlink()
        if damage.startswith("empty"):
            record.with_name("predictions.npz").touch()
    else:
        record.write_bytes(text[: len(text) // 2] if damage == "cut" else other.read_bytes())
    before = contents(out)
    assert len(check_run(out)) >= 1

    again = run(counted, out)
    assert (again.done, again.kept) == (1, 3)
    assert log() == FOLDS + 3
    changed = {path.parent for path, state in contents(out).items() if before.get(path) != state}
    assert changed == {record.parent}
    unlike = {"timing", "provenance"}
    assert [r.model_dump(exclude=unlike) for r in again.records] == [
        r.model_dump(exclude=unlike) for r in first.records
    ]


def test_fresh_runs_every_cell_again_to_the_same_end(counted, log, tmp_path):
    out = tmp_path / "run"
    first = run(counted, out)
    again = run(counted, out, fresh=True)
    assert (again.done, again.kept) == (4, 0)
    assert log() == 2 * FOLDS
    unlike = {"timing", "provenance"}
    assert [r.model_dump(exclude=unlike) for r in again.records] == [
        r.model_dump(exclude=unlike) for r in first.records
    ]


def hand_in(out, record, **identity):
    """A record of somebody else's model beside those of a run, with predictions of its own."""
    who = record.identity.model_copy(update={"method": "theirs@00000000", **identity})
    given = record.model_copy(
        update={
            "identity": who,
            "key": record_key(who),
            "submission": Submission(id="theirs", title="Theirs", status="verified"),
        }
    )
    write_record(out, given, read_predictions(out, record.key))
    return given


def test_fresh_keeps_what_others_handed_in_and_what_cannot_be_read(counted, log, tmp_path):
    out = tmp_path / "run"
    theirs = hand_in(out, run(counted, out).records[0])
    damaged = out / "runs" / ("0" * 64) / "record.json"
    damaged.parent.mkdir()
    damaged.write_text('{"submission": {"id": "cut o')
    before = {path: state for path, state in contents(out).items() if path.parent.name == theirs.key}
    assert len(before) == 2
    assert run(counted, out, fresh=True).done == 4
    assert before.items() <= contents(out).items()
    assert log() == 2 * FOLDS
    assert [path.read_text() for path in out.glob("superseded/*/record.json")] == ['{"submission": {"id": "cut o']


def test_a_failed_cell_keeps_its_row_until_fresh(presses, tmp_path):
    broken = small.suite(presses, ["mine"], {"mine": small.own("Raises")})
    assert set(small.states(run(broken, tmp_path / "run")).values()) == {"failed"}
    again = run(broken, tmp_path / "run")
    assert (again.done, again.kept, again.failed) == (0, 2, 2)
    assert "--fresh" in "\n".join(again.lines())
    assert run(broken, tmp_path / "run", fresh=True).done == 2


def test_two_runs_at_once_in_one_folder_are_refused(counted, log, tmp_path):
    out = tmp_path / "run"
    with claim(out, counted), pytest.raises(OSError, match="another run is at work") as refused:
        run(counted, out)
    assert "\n" not in str(refused.value)
    assert log() == 0
    assert run(counted, out).done == 4


def test_a_folder_of_another_suite_or_of_other_things_is_left_alone(presses, tmp_path):
    out = tmp_path / "run"
    run(small.suite(presses), out)
    before = contents(out)
    with pytest.raises(ValueError, match="holds a run of the suite 'small', not of 'other'"):
        run(small.suite(presses, id="other"), out, fresh=True)
    assert contents(out) == before

    (tmp_path / "photos").mkdir()
    (tmp_path / "photos/cat.png").write_bytes(b"cat")
    with pytest.raises(ValueError, match="other things in it"):
        run(small.suite(presses), tmp_path / "photos", fresh=True)
    assert [path.name for path in (tmp_path / "photos").iterdir()] == ["cat.png"]


def test_a_suite_changed_in_place_runs_what_is_new_and_sets_aside_what_it_no_longer_has(presses, log, tmp_path):
    out = tmp_path / "run"
    first = run(small.suite(presses, ["knn", "mine"], {"mine": small.own("Nearest", log=log.path)}), out)
    changed = small.suite(presses, ["knn", "mine"], {"mine": small.own("Nearest", log=log.path, power=2)})
    again = run(changed, out)
    assert (again.total, again.done, again.kept) == (4, 2, 2)
    assert log() == 2 * FOLDS
    old = {r.key for r in first.records} - {r.key for r in again.records}
    assert {path.name for path in (out / "superseded").iterdir()} == old
    assert len(old) == 2
    assert {path.name for path in (out / "runs").iterdir()} == {r.key for r in again.records}
    assert check_run(out) == []

    # back and forth: nothing that was set aside is overwritten
    run(small.suite(presses, ["knn", "mine"], {"mine": small.own("Nearest", log=log.path)}), out)
    run(changed, out)
    assert len(list((out / "superseded").iterdir())) == 6


def test_other_samples_under_the_same_name_are_other_cells(tmp_path):
    data = small.write(tmp_path / "set", seed=1)
    first = run(small.suite(data), tmp_path / "run")
    data.rename(tmp_path / "old")
    small.write(tmp_path / "set", seed=2)
    again = run(small.suite(data), tmp_path / "run")
    assert (again.done, again.kept) == (2, 0)
    assert not {r.key for r in first.records} & {r.key for r in again.records}


@pytest.mark.parametrize("value", [0, -1])
def test_jobs_below_one_are_refused_before_any_work(presses, tmp_path, value):
    with pytest.raises(ValueError, match="jobs: expected at least 1"):
        run(small.suite(presses), tmp_path / "run", jobs=value)
    with pytest.raises(ValueError, match="device: expected 'cpu'"):
        run(small.suite(presses), tmp_path / "run", device="cuda")
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_a_killed_run_goes_on_to_the_records_of_one_that_was_not(presses, log, tmp_path):
    slow = {f"mine-{i}": small.own("Nearest", log=log.path, delay_s=0.05, power=i) for i in range(1, 5)}
    suite = small.suite(presses, ["knn", *slow], slow)
    (tmp_path / "suite.json").write_text(json.dumps(suite.model_dump(mode="json")))
    script = (
        "import sys; from vtbench.run import Suite, run_suite\n"
        "suite = Suite.model_validate_json(open(sys.argv[1]).read())\n"
        "run_suite(suite, sys.argv[2], progress=False)\n"
    )
    out = tmp_path / "killed"
    process = subprocess.Popen([sys.executable, "-c", script, tmp_path / "suite.json", out], env=dict(os.environ))
    deadline = time.monotonic() + 120
    while len(list(out.glob("runs/*/record.json"))) < 4 and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL

    finished = {r.key for r in read_records(out)}  # a record that cannot be read would warn, and fail
    assert 4 <= len(finished) < 10
    before = contents(out)
    again = run(suite, out)
    assert again.done == 10 - len(finished)
    after = contents(out)
    assert all(after[path] == state for path, state in before.items() if path.parent.name in finished)
    run(suite, tmp_path / "whole")
    same_results(out, tmp_path / "whole")


@pytest.mark.slow
def test_two_processes_give_the_predictions_of_one(presses, tmp_path):
    suite = small.suite(presses, ["knn", "svm", "mine"], {"mine": small.own("Nearest")})
    assert run(suite, tmp_path / "one", jobs=1).done == 6
    assert run(suite, tmp_path / "two", jobs=2).done == 6
    same_results(tmp_path / "one", tmp_path / "two")
